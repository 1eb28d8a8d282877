#include "image/palette.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

namespace spinel::palette_test {
namespace {

double error_of(const std::vector<std::uint32_t>& colors, const ColorPalette& palette) {
    double sum = 0;
    for (std::size_t i = 0; i < colors.size(); ++i) {
        const glm::vec3 d = oklab_of_linear(linear_of_srgb8(colors[i])) -
                            oklab_of_linear(linear_of_srgb8(palette.colors[palette.index[i]]));
        sum += double(glm::dot(d, d));
    }
    return std::sqrt(sum / double(colors.size()));
}

TEST(Palette, eight_bit_colours_survive_the_way_to_linear_light_and_back) {
    for (std::uint32_t c = 0; c < 256; ++c) {
        const std::uint32_t color = c | (255 - c) << 8 | (c * 7 & 255) << 16;
        EXPECT_EQ(srgb8(linear_of_srgb8(color)), color);
        EXPECT_EQ(srgb8(linear_of_oklab(oklab_of_linear(linear_of_srgb8(color)))), color);
    }
}

TEST(Palette, few_colours_stay_as_they_are) {
    const std::vector<std::uint32_t> colors = {0x0000ff, 0x123456, 0x0000ff, 0xffffff, 0};
    const ColorPalette palette = quantise_colors(colors, 4);
    ASSERT_EQ(palette.colors.size(), 4u);
    for (std::size_t i = 0; i < colors.size(); ++i) EXPECT_EQ(palette.colors[palette.index[i]], colors[i]);
}

// Levels of each channel, as evenly as so many colours allow, are the naive way.
TEST(Palette, many_colours_are_nearer_than_with_even_levels) {
    std::mt19937 random(1);
    std::normal_distribution<float> spread(0, 0.12f);
    std::vector<std::uint32_t> colors;
    for (int i = 0; i < 60000; ++i) {
        const glm::vec3 centre = i % 3 == 0   ? glm::vec3(0.7f, 0.2f, 0.1f)
                                 : i % 3 == 1 ? glm::vec3(0.1f, 0.4f, 0.6f)
                                              : glm::vec3(0.5f);
        colors.push_back(srgb8(centre + glm::vec3(spread(random), spread(random), spread(random))));
    }
    const ColorPalette palette = quantise_colors(colors, 255);
    EXPECT_EQ(palette.colors.size(), 255u);
    ColorPalette even;
    for (int i = 0; i < 252; ++i)
        even.colors.push_back(std::uint32_t(i % 6 * 51) | std::uint32_t(std::lround(i / 6 % 7 * 42.5)) << 8 |
                              std::uint32_t(i / 42 * 51) << 16);
    for (const std::uint32_t c : colors)
        even.index.push_back(std::uint16_t((c & 255) * 5 / 255.0 + 0.5) +
                             6 * std::uint16_t((c >> 8 & 255) * 6 / 255.0 + 0.5) +
                             42 * std::uint16_t((c >> 16) * 5 / 255.0 + 0.5));
    EXPECT_LT(error_of(colors, palette), 0.5 * error_of(colors, even));
    for (const std::uint16_t i : palette.index) ASSERT_LT(i, palette.colors.size());
    const ColorPalette two = quantise_colors(colors, 2);
    EXPECT_EQ(two.colors.size(), 2u);
    EXPECT_LT(error_of(colors, palette), 0.25 * error_of(colors, two));
}

}  // namespace
}  // namespace spinel::palette_test
