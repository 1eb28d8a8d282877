#include "kernels/noise.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace spinel::noise_test {
namespace {

using namespace kernels;
using glm::ivec3;
using glm::vec3;

TEST(Noise, stays_within_one_and_uses_the_range) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(-1000, 1000);
    float low = 1, high = -1, fbm_low = 1, fbm_high = -1;
    double mean = 0;
    for (int i = 0; i < 300000; ++i) {
        const float x = uniform(random), y = uniform(random);
        const vec3 p(x, y, uniform(random));
        const float v = value_noise(p), f = fbm_noise(p, 5u);
        ASSERT_LE(std::abs(v), 1.0f);
        ASSERT_LE(std::abs(f), 1.0f);
        low = std::min(low, v), high = std::max(high, v);
        fbm_low = std::min(fbm_low, f), fbm_high = std::max(fbm_high, f);
        mean += v / 300000;
    }
    EXPECT_LT(low, -0.95f);
    EXPECT_GT(high, 0.95f);
    EXPECT_LT(fbm_low, -0.5f);
    EXPECT_GT(fbm_high, 0.5f);
    EXPECT_NEAR(mean, 0, 0.01);
}

TEST(Noise, has_its_lattice_values_and_is_flat_there) {
    for (int i = -20; i < 20; ++i) {
        const ivec3 c(i, 3 * i - 7, -i * i);
        const vec3 p(c);
        const float v = lattice_value(c);
        EXPECT_EQ(value_noise(p), v);
        // Quintic weights: first and second derivatives vanish on the lattice.
        EXPECT_NEAR(value_noise(p + vec3(0.01f, 0, 0)), v, 1e-4f);
        EXPECT_NEAR(value_noise(p - vec3(0, 0.01f, 0)), v, 1e-4f);
    }
}

TEST(Noise, is_continuous) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> uniform(-10, 10);
    for (int i = 0; i < 100000; ++i) {
        const float x = uniform(random), y = uniform(random);
        vec3 p(x, y, uniform(random));
        if ((i & 1) != 0) p.x = std::round(p.x);  // across a cell's face
        const vec3 step(2e-4f, 1e-4f, -1e-4f);
        // Quintic weights have slope ≤ 1.875, values differ by ≤ 2.
        ASSERT_LE(std::abs(value_noise(p + step) - value_noise(p - step)), 2 * 1.875f * 8e-4f + 1e-6f);
    }
}

TEST(Noise, lattice_values_do_not_repeat_or_correlate) {
    std::set<float> values;
    double along[3] = {0, 0, 0};
    const int n = 24;
    for (int x = 0; x < n; ++x) {
        for (int y = 0; y < n; ++y) {
            for (int z = 0; z < n; ++z) {
                const ivec3 c(x - n / 2, y - n / 2, z - n / 2);
                const float v = lattice_value(c);
                values.insert(v);
                for (int axis = 0; axis < 3; ++axis) {
                    ivec3 d = c;
                    d[axis] += 1;
                    along[axis] += 3.0 * v * lattice_value(d);
                }
            }
        }
    }
    EXPECT_GT(values.size(), std::size_t(n * n * n - 30));  // 2^24 values: a few meet by chance
    for (double sum : along) EXPECT_LT(std::abs(sum) / std::sqrt(double(n * n * n)), 4.5);
}

TEST(Noise, octaves_add_detail) {
    const vec3 p(0.3f, 1.7f, -2.2f);
    EXPECT_FLOAT_EQ(fbm_noise(p, 1u), value_noise(p));  // contraction may differ
    EXPECT_FLOAT_EQ(fbm_noise(p, 0u), value_noise(p));
    EXPECT_NE(fbm_noise(p, 2u), value_noise(p));
    EXPECT_EQ(fbm_noise(p, 1000u), fbm_noise(p, FBM_MAX_OCTAVES));
    // Two octaves, written out.
    const float expected = (value_noise(p) + 0.5f * value_noise(2.0f * p + vec3(17.17f, 31.73f, 5.39f))) / 1.5f;
    EXPECT_NEAR(fbm_noise(p, 2u), expected, 1e-6f);
}

TEST(Noise, far_away_is_safe) {
    for (float x : {1e9f, -1e9f, 1e20f, -3e38f}) {
        EXPECT_LE(std::abs(value_noise(vec3(x, -x, x))), 1.0f);
        EXPECT_LE(std::abs(fbm_noise(vec3(x, -x, x), 24u)), 1.0f);
    }
}

}  // namespace
}  // namespace spinel::noise_test
