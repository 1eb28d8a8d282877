#pragma once
// Many colours to few. Colours are 8-bit sRGB, red in the low byte.

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace spinel {

std::uint32_t srgb8(glm::vec3 linear);           // rounded, clamped to 0 … 1
glm::vec3 linear_of_srgb8(std::uint32_t color);  // linear Rec.709

// Ottosson, "A perceptual color space for image processing", 2020: differences are about as large as they look.
glm::vec3 oklab_of_linear(glm::vec3 rgb);
glm::vec3 linear_of_oklab(glm::vec3 lab);

struct ColorPalette {
    std::vector<std::uint32_t> colors;  // at most as many as asked for
    std::vector<std::uint16_t> index;   // into them, for every colour that was given
};

// Where there are few enough colours, exactly these, in rising order. Otherwise Oklab is divided by median cut
// (Heckbert 1982, splitting where the variance is largest, at the mean, after Wan et al. 1990) and the centres are
// moved by a few rounds of k-means (Lloyd), unless there are so many of them that this would take minutes.
ColorPalette quantise_colors(std::span<const std::uint32_t> colors, int max_colors);

}  // namespace spinel
