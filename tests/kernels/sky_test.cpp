#include "kernels/sky.h"

#include <gtest/gtest.h>

#include <random>

#include "kernels/warp.h"

namespace spinel::sky_test {
namespace {

using namespace kernels;
using glm::vec2;
using glm::vec3;

vec3 sun_at(float degrees) {
    const float e = degrees * PI / 180;
    return vec3(std::cos(e), std::sin(e), 0);
}

vec3 sky_irradiance(vec3 to_sun, float haze) {
    const int n = 40;
    vec3 sum(0);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const vec3 d = square_to_cosine_hemisphere(vec2((i + 0.5f) / n, (j + 0.5f) / n));
            sum += sky_radiance(vec3(d.x, d.z, d.y), to_sun, haze) * PI / float(n * n);
        }
    }
    return sum;
}

TEST(Sky, few_steps_agree_with_many) {
    for (float elevation : {0.0f, 5.0f, 40.0f, 90.0f}) {
        for (vec3 d : {vec3(0, 1, 0), vec3(0.6f, 0.8f, 0), vec3(-0.9f, 0.1f, 0.424f), vec3(0, 0, 1)}) {
            const vec3 direction = glm::normalize(d);
            const vec3 fine = sky_single_scattering(direction, sun_at(elevation), 1, 400u, 200u);
            const vec3 coarse = sky_radiance(direction, sun_at(elevation), 1);
            EXPECT_LT(glm::length(coarse - fine), 0.03f * glm::length(fine)) << elevation;
        }
    }
}

TEST(Sky, a_white_surface_under_a_high_sun_is_near_one) {
    const vec3 to_sun = sun_at(40);
    const vec3 radiance = (sun_irradiance(to_sun, 1) * to_sun.y + sky_irradiance(to_sun, 1)) * INV_PI;
    EXPECT_GT(luminance(radiance), 0.8f);
    EXPECT_LT(luminance(radiance), 1.1f);
}

TEST(Sky, is_blue_above_and_the_sun_reddens_as_it_sets) {
    const vec3 zenith = sky_radiance(vec3(0, 1, 0), sun_at(40), 1);
    EXPECT_GT(zenith.z, 1.5f * zenith.y);
    EXPECT_GT(zenith.y, 1.5f * zenith.x);
    const vec3 high = sun_irradiance(sun_at(60), 1), low = sun_irradiance(sun_at(3), 1);
    EXPECT_LT(high.x / high.z, 1.5f);
    EXPECT_GT(low.x / low.z, 10.0f);
    for (float e = 1; e < 90; e += 1) {  // higher is brighter
        EXPECT_GE(luminance(sun_irradiance(sun_at(e + 1), 1)), luminance(sun_irradiance(sun_at(e), 1)));
    }
}

TEST(Sky, is_dimmer_than_its_sun_by_the_physical_ratio) {
    const vec3 to_sun = sun_at(40);
    const float sky = luminance(sky_irradiance(to_sun, 1)), sun = luminance(sun_irradiance(to_sun, 1)) * to_sun.y;
    // Clear skies give a tenth to a fifth of the light on the ground; single scattering is at the low end.
    EXPECT_GT(sky / (sky + sun), 0.05f);
    EXPECT_LT(sky / (sky + sun), 0.25f);
}

// Without absorption all of a thin atmosphere's scattered light must come out: compare with the optical
// depth.
TEST(Sky, transmittance_at_the_zenith_is_that_of_the_tables) {
    // Vertical optical depths: Rayleigh 8 km · βs, haze 1.2 km · (σs + σa), ozone 15 km · σa.
    const vec3 depth = 8.0f * sky_air_scattering() + vec3(1.2f * (SKY_HAZE_SCATTERING + SKY_HAZE_ABSORPTION)) +
                       15.0f * sky_ozone_absorption();
    const vec3 expected = SKY_SUN_IRRADIANCE * exp(-depth);
    EXPECT_LT(glm::length(sun_irradiance(vec3(0, 1, 0), 1) - expected), 0.01f * glm::length(expected));
}

TEST(Sky, passes_the_horizon_without_a_step) {
    for (float elevation : {2.0f, 40.0f}) {
        for (float azimuth : {0.1f, 1.5f, 3.0f}) {
            vec3 before(0), horizon(0);
            for (float y = 0.004f; y > -0.3f; y -= 0.002f) {
                const float r = std::sqrt(1 - y * y);
                const vec3 here =
                    sky_radiance(vec3(r * std::cos(azimuth), y, r * std::sin(azimuth)), sun_at(elevation), 1);
                if (y < 0.003f) { EXPECT_LT(glm::length(here - before), 0.08f * glm::length(horizon) + 1e-4f) << y; }
                if (is_black(horizon)) horizon = here;
                before = here;
            }
        }
    }
}

TEST(Sky, night_is_dark_and_the_sun_sets_gradually) {
    EXPECT_EQ(sun_irradiance(sun_at(-5), 1), vec3(0));
    EXPECT_LT(luminance(sky_radiance(vec3(0, 1, 0), sun_at(-20), 1)), 1e-6f);
    EXPECT_GT(luminance(sky_radiance(vec3(0, 1, 0), sun_at(-2), 1)), 0.0f);  // dusk
    for (float e = -1; e < 1; e += 0.02f) {
        EXPECT_LT(std::abs(sun_irradiance(sun_at(e + 0.02f), 1).x - sun_irradiance(sun_at(e), 1).x), 0.08f) << e;
    }
}

TEST(Sky, haze_brightens_the_sky_about_the_sun_and_dims_the_sun) {
    const vec3 to_sun = sun_at(40), near_sun = glm::normalize(to_sun + vec3(0, 0.08f, 0));
    EXPECT_GT(sky_radiance(near_sun, to_sun, 4).x, 2 * sky_radiance(near_sun, to_sun, 1).x);
    EXPECT_LT(sun_irradiance(to_sun, 4).x, sun_irradiance(to_sun, 1).x);
    EXPECT_GT(sun_irradiance(to_sun, 0).x, sun_irradiance(to_sun, 1).x);
}

TEST(Sky, is_finite_and_not_negative_everywhere) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0, ONE_MINUS_EPSILON);
    for (int i = 0; i < 4000; ++i) {
        const float u = uniform(random), v = uniform(random);
        vec3 d = square_to_sphere(vec2(u, uniform(random)));
        if (i == 0) d = vec3(0, -1, 0);
        if (i == 1) d = vec3(0, 1, 0);
        if (i == 2) d = vec3(1, 0, 0);
        const vec3 to_sun = square_to_sphere(vec2(v, uniform(random)));
        const vec3 sky = sky_radiance(d, to_sun, 10 * uniform(random));
        ASSERT_TRUE(std::isfinite(sky.x + sky.y + sky.z));
        ASSERT_GE(min_component(sky), 0.0f);
    }
    const vec3 at_sun = sky_radiance(vec3(0, 1, 0), vec3(0, 1, 0), 1);
    EXPECT_TRUE(std::isfinite(at_sun.x + at_sun.y + at_sun.z));
}

}  // namespace
}  // namespace spinel::sky_test
