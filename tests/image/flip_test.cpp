#include "image/flip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "image/tone_map.h"

namespace spinel::flip_test {
namespace {

Image constant(int width, int height, std::vector<float> color) {
    Image image{width, height, int(color.size()), {}};
    for (int i = 0; i < width * height; ++i) image.values.insert(image.values.end(), color.begin(), color.end());
    return image;
}

Image random_image(int width, int height, unsigned seed) {
    std::mt19937 engine(seed);
    Image image{width, height, 3, {}};
    for (int i = 0; i < 3 * width * height; ++i) image.values.push_back(float(engine() >> 8) * 0x1p-24f);
    return image;
}

TEST(Flip, equal_pictures_do_not_differ) {
    const Image a = random_image(40, 30, 1);
    const Result<Image> map = flip_map(a, a);
    ASSERT_TRUE(map) << map.error().message;
    for (const float v : map->values) ASSERT_EQ(v, 0.0f);
    EXPECT_EQ(*flip(a, a), 0.0);
}

TEST(Flip, is_symmetric_and_between_0_and_1) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
        const Image a = random_image(33, 17, seed), b = random_image(33, 17, seed + 100);
        const Result<Image> there = flip_map(a, b), back = flip_map(b, a);
        ASSERT_TRUE(there && back);
        for (std::size_t i = 0; i < there->values.size(); ++i) {
            ASSERT_EQ(there->values[i], back->values[i]) << "seed " << seed << ", pixel " << i;
            ASSERT_GT(there->values[i], 0.0f) << "seed " << seed << ", pixel " << i;
            ASSERT_LE(there->values[i], 1.0f) << "seed " << seed << ", pixel " << i;
        }
    }
}

// By hand from the paper's constants: the distance of black and white is 100, the largest there is, between green and
// blue, 203.3017; both to the power of 0.7, of which 0.4 times the larger is mapped to 0.95 and the larger itself to 1.
TEST(Flip, distances_of_plain_colors_follow_the_paper) {
    const double largest = std::pow(203.3017, 0.7), knee = 0.4 * largest, white = std::pow(100.0, 0.7);
    const Image black = constant(20, 20, {0, 0, 0});
    EXPECT_NEAR(*flip(constant(20, 20, {1, 1, 1}), black), 0.95 + 0.05 * (white - knee) / (largest - knee), 1e-4);
    EXPECT_NEAR(*flip(constant(20, 20, {0, 1, 0}), constant(20, 20, {0, 0, 1})), 1.0, 1e-6);
    // Two greys are their difference of lightness L* apart, here 10.
    const auto grey = [](double lightness) { return srgb_encoded(float(std::pow((lightness + 16) / 116, 3))); };
    EXPECT_NEAR(*flip(constant(20, 20, {grey(50)}), constant(20, 20, {grey(60)})), std::pow(10, 0.7) * 0.95 / knee,
                1e-4);
}

// The numbers of a twin that filters by the paper's two-dimensional kernels as they stand, in NumPy.
TEST(Flip, equals_its_naive_twin) {
    const auto picture = [](int k) {
        Image image{24, 18, 3, {}};
        for (int y = 0; y < 18; ++y)
            for (int x = 0; x < 24; ++x)
                for (int c = 0; c < 3; ++c)
                    image.values.push_back(float((x * 7 + y * 13 + c * 29 + k * (x * y + 3 * c)) % 32) / 31);
        return image;
    };
    const Image a = picture(1), b = picture(2);
    EXPECT_NEAR(*flip(a, b), 0.3622447, 1e-6);
    EXPECT_NEAR(*flip(a, b, 20), 0.7803331, 1e-6);
    const Result<Image> map = flip_map(a, b);
    ASSERT_TRUE(map);
    EXPECT_NEAR(*map->at(7, 5), 0.3009766f, 1e-6f);
}

TEST(Flip, one_channel_is_grey) {
    const Image a = random_image(20, 20, 1);
    Image one{20, 20, 1, {}}, three{20, 20, 3, {}};
    for (int i = 0; i < 400; ++i) {
        one.values.push_back(a.values[std::size_t(i)]);
        for (int c = 0; c < 3; ++c) three.values.push_back(a.values[std::size_t(i)]);
    }
    EXPECT_NEAR(*flip(one, constant(20, 20, {0.5f})), *flip(three, constant(20, 20, {0.5f, 0.5f, 0.5f})), 1e-9);
}

// A grid of single pixels that the eye does not resolve from afar nearly is its mean; from near it is not.
TEST(Flip, detail_beyond_sight_does_not_count) {
    Image board{64, 64, 1, {}};
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) board.values.push_back((x + y) % 2 == 0 ? 1.0f : 0.0f);
    const Image mean = constant(64, 64, {srgb_encoded(0.5f)});
    EXPECT_LT(*flip(board, mean, 200), 0.02);
    EXPECT_GT(*flip(board, mean, 10), 0.2);
}

TEST(Flip, more_of_an_edge_is_seen_than_of_the_same_change_spread_out) {
    Image flat = constant(60, 60, {0.5f}), edge = flat, ramp = flat;
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 60; ++x) {
            *edge.at(x, y) = x < 30 ? 0.45f : 0.55f;
            *ramp.at(x, y) = 0.45f + 0.1f * float(x) / 59;
        }
    const Result<Image> of_edge = flip_map(edge, flat), of_ramp = flip_map(ramp, flat);
    ASSERT_TRUE(of_edge && of_ramp);
    EXPECT_GT(*of_edge->at(28, 30), 1.3f * *of_edge->at(10, 30)) << "as large a difference, and an edge";
    EXPECT_GT(*flip(edge, flat), *flip(ramp, flat));
}

TEST(Flip, what_cannot_be_compared_is_refused) {
    EXPECT_FALSE(flip(constant(2, 2, {0}), constant(2, 3, {0})));
    EXPECT_FALSE(flip(constant(2, 2, {0}), constant(2, 2, {0, 0, 0})));
    EXPECT_FALSE(flip(constant(2, 2, {0, 0, 0, 1}), constant(2, 2, {0, 0, 0, 1})));
    EXPECT_FALSE(flip(constant(2, 2, {NAN}), constant(2, 2, {0})));
    EXPECT_FALSE(flip(Image{}, Image{}));
}

}  // namespace
}  // namespace spinel::flip_test
