#include "image/tone_map.h"

#include <gtest/gtest.h>

#include <cmath>

namespace spinel::tone_map_test {
namespace {

float grey(float value, ToneMap tone_map, float stops = 0) {
    const Image mapped = tone_mapped(Image{1, 1, 3, {value, value, value}}, tone_map, stops);
    EXPECT_NEAR(mapped.values[0], mapped.values[1], 2e-3f);
    EXPECT_NEAR(mapped.values[0], mapped.values[2], 2e-3f);
    return mapped.values[1];
}

constexpr ToneMap ALL[] = {ToneMap::linear, ToneMap::aces, ToneMap::agx};

TEST(ToneMapping, srgb_curve_is_that_of_the_standard_and_its_inverse) {
    EXPECT_NEAR(srgb_encoded(0.5f), 0.735357f, 1e-5f);
    EXPECT_NEAR(srgb_encoded(0.002f), 0.02584f, 1e-6f);
    EXPECT_NEAR(srgb_encoded(1.0f), 1.0f, 1e-6f);
    for (int i = 0; i <= 255; ++i) EXPECT_NEAR(srgb_encoded(srgb_decoded(float(i) / 255)) * 255, float(i), 1e-3f);
}

TEST(ToneMapping, every_curve_rises_from_black_to_white) {
    for (const ToneMap tone_map : ALL) {
        EXPECT_LT(grey(0, tone_map), 0.01f);
        EXPECT_GT(grey(1000, tone_map), 0.99f);
        float before = 0;
        for (float stops = -10; stops <= 8; stops += 0.25f) {
            const float value = grey(std::exp2(stops), tone_map);
            EXPECT_GE(value, before - 1e-4f) << int(tone_map) << " at " << stops << " stops";
            before = value;
        }
    }
}

TEST(ToneMapping, middle_grey_lands_where_the_transforms_put_it) {
    EXPECT_NEAR(grey(0.18f, ToneMap::linear), 0.4614f, 1e-3f);
    EXPECT_NEAR(grey(0.18f, ToneMap::aces), srgb_encoded(0.1055f),
                1e-2f);  // 0.18 of the fit without its exposure factor
    EXPECT_NEAR(grey(0.18f, ToneMap::agx), 0.5f,
                0.05f);  // AgX maps middle grey to the middle of the code values
}

TEST(ToneMapping, a_stop_is_a_factor_of_two) {
    for (const ToneMap tone_map : ALL) EXPECT_NEAR(grey(0.1f, tone_map, 1), grey(0.2f, tone_map), 1e-5f);
}

TEST(ToneMapping, whatever_comes_in_goes_out_between_0_and_1) {
    for (const ToneMap tone_map : ALL) {
        for (const float odd : {NAN, -NAN, -1.0f, -INFINITY, INFINITY, 3e38f, 1e-42f}) {
            const Image mapped = tone_mapped(Image{2, 1, 4, {odd, 0.5f, 0.0f, odd, 0.1f, odd, odd, 0.5f}}, tone_map, 3);
            for (const float value : mapped.values) EXPECT_TRUE(value >= 0.0f && value <= 1.0f) << odd;
        }
        EXPECT_GT(grey(INFINITY, tone_map), 0.99f);
        EXPECT_LT(grey(NAN, tone_map), 0.01f);
    }
}

TEST(ToneMapping, bright_red_turns_paler_in_the_filmic_curves_and_stays_red_in_the_linear_one) {
    const Image red{1, 1, 3, {50.0f, 0.0f, 0.0f}};
    EXPECT_EQ(tone_mapped(red, ToneMap::linear).values[1], 0.0f);
    EXPECT_GT(tone_mapped(red, ToneMap::aces).values[1], 0.3f);
    EXPECT_GT(tone_mapped(red, ToneMap::agx).values[1], 0.3f);
}

TEST(ToneMapping, alpha_and_single_channels_keep_their_meaning) {
    const Image with_alpha = tone_mapped(Image{1, 1, 4, {0.2f, 0.2f, 0.2f, 0.25f}}, ToneMap::agx, 2);
    EXPECT_EQ(with_alpha.values[3], 0.25f);
    const Image single = tone_mapped(Image{1, 1, 1, {0.2f}}, ToneMap::agx, 2);
    EXPECT_NEAR(single.values[0], with_alpha.values[1], 1e-6f);
}

}  // namespace
}  // namespace spinel::tone_map_test
