#include "kernels/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "sampling_statistics.h"

namespace spinel::random_test {
namespace {

using namespace kernels;
using glm::uvec2;
using glm::vec2;

vec2 draw(uvec2 pixel, uint index, uint dimension, uint seed = 0) {
    Sampler s = make_sampler(pixel, index, seed);
    s.dimension = dimension;
    return sampler_2d(s);
}

TEST(Sobol, butterfly_equals_direction_numbers) {
    uint direction[32] = {0x80000000u};  // of the second Sobol dimension: v' = v ⊕ v/2
    for (int k = 1; k < 32; ++k) direction[k] = direction[k - 1] ^ (direction[k - 1] >> 1);
    for (uint n = 0; n < 20000; ++n) {
        const uint index = n < 4096 ? n : hash_uint(n);
        uint expected = 0;
        for (int k = 0; k < 32; ++k) {
            if ((index >> k) & 1u) expected ^= direction[k];
        }
        ASSERT_EQ(reverse_bits32(sobol_reversed_1(index)), expected) << "index " << index;
    }
}

TEST(Sobol, scrambling_is_a_bijection_that_flips_a_bit_by_lower_bits_only) {
    for (uint seed : {0u, 1u, 0xdeadbeefu, 0xffffffffu}) {
        for (uint x : {0u, 1u, 12345u, 0x80000000u, 0xfffffffeu}) {
            const uint y = laine_karras_permutation(x, seed);
            for (int bit = 0; bit < 32; ++bit) {
                // A change at `bit` must flip that bit of the result and leave those below alone.
                const uint difference = y ^ laine_karras_permutation(x ^ (1u << bit), seed);
                EXPECT_EQ(difference & ((1u << bit) - 1u), 0u) << "bit " << bit;
                EXPECT_NE(difference & (1u << bit), 0u) << "bit " << bit;
            }
        }
    }
}

TEST(Sampler, powers_of_two_are_nets_in_every_pair) {
    for (uvec2 pixel : {uvec2(0, 0), uvec2(1, 0), uvec2(1919, 1079)}) {
        for (uint dimension : {0u, 1u, 2u, 7u, 63u}) {
            for (uint m = 1; m <= 9; ++m) {
                for (uint start : {0u, 1u, 5u}) {
                    const uint count = 1u << m;
                    for (uint a = 0; a <= m; ++a) {  // elementary intervals of 2^-a × 2^-(m-a)
                        std::vector<int> hits(count, 0);
                        for (uint i = 0; i < count; ++i) {
                            const vec2 p = draw(pixel, start * count + i, dimension, 17);
                            const uint x = uint(p.x * float(1u << a)), y = uint(p.y * float(1u << (m - a)));
                            ++hits[(x << (m - a)) + y];
                        }
                        for (int h : hits) ASSERT_EQ(h, 1) << "m " << m << ", a " << a << ", dimension " << dimension;
                    }
                }
            }
        }
    }
}

TEST(Sampler, one_dimension_is_stratified) {
    for (uint dimension = 0; dimension < 32; ++dimension) {
        std::vector<int> hits(256, 0);
        for (uint i = 0; i < 256; ++i) {
            Sampler s = make_sampler(uvec2(3, 4), i, 5);
            s.dimension = dimension;
            const float u = sampler_1d(s);
            ASSERT_EQ(s.dimension, dimension + 1);
            ++hits[std::size_t(u * 256.0f)];
        }
        for (int h : hits) ASSERT_EQ(h, 1);
    }
}

TEST(Sampler, values_lie_below_one) {
    EXPECT_EQ(uint_to_unit_float(0xffffffffu), ONE_MINUS_EPSILON);
    EXPECT_EQ(uint_to_unit_float(0u), 0.0f);
    for (uint i = 0; i < 100000; ++i) {
        const vec2 p = draw(uvec2(i, 2 * i), hash_uint(i), i & 15u);
        ASSERT_TRUE(p.x >= 0.0f && p.x <= ONE_MINUS_EPSILON && p.y >= 0.0f && p.y <= ONE_MINUS_EPSILON);
    }
}

TEST(Sampler, is_a_pure_function_of_pixel_index_dimension_and_seed) {
    const vec2 p = draw(uvec2(10, 20), 30, 4, 5);
    EXPECT_EQ(p, draw(uvec2(10, 20), 30, 4, 5));
    EXPECT_NE(p, draw(uvec2(11, 20), 30, 4, 5));
    EXPECT_NE(p, draw(uvec2(20, 10), 30, 4, 5));
    EXPECT_NE(p, draw(uvec2(10, 20), 31, 4, 5));
    EXPECT_NE(p, draw(uvec2(10, 20), 30, 5, 5));
    EXPECT_NE(p, draw(uvec2(10, 20), 30, 4, 6));
}

// Correlation of two families of numbers that should be independent, in units of its standard deviation.
template <class F>
double correlation_sigmas(F pair, uint count) {
    double sum = 0;
    for (uint i = 0; i < count; ++i) {
        const vec2 p = pair(i);
        sum += (double(p.x) - 0.5) * (double(p.y) - 0.5) * 12;
    }
    return std::abs(sum) / std::sqrt(double(count));
}

TEST(Sampler, neighbouring_pixels_seeds_and_dimensions_do_not_correlate) {
    const uint n = 1 << 16;
    auto pixel = [](uint i) { return uvec2(i & 255u, i >> 8); };
    for (uint d = 0; d < 4; ++d) {
        EXPECT_LT(correlation_sigmas(
                      [&](uint i) { return vec2(draw(pixel(i), 0, d).x, draw(pixel(i) + uvec2(1, 0), 0, d).x); }, n),
                  4.5);
        EXPECT_LT(correlation_sigmas(
                      [&](uint i) { return vec2(draw(pixel(i), 0, d).x, draw(pixel(i) + uvec2(0, 1), 0, d).x); }, n),
                  4.5);
        EXPECT_LT(
            correlation_sigmas([&](uint i) { return vec2(draw(pixel(i), 0, d).x, draw(pixel(i), 0, d + 1).x); }, n),
            4.5);
        EXPECT_LT(
            correlation_sigmas([&](uint i) { return vec2(draw(pixel(i), 0, d).y, draw(pixel(i), 0, d + 1).x); }, n),
            4.5);
        EXPECT_LT(
            correlation_sigmas([&](uint i) { return vec2(draw(pixel(i), 7, d, 1).x, draw(pixel(i), 7, d, 2).x); }, n),
            4.5);
        EXPECT_LT(correlation_sigmas([&](uint i) { return draw(pixel(i), 3, d); }, n), 4.5);
    }
}

// Padding: within a pixel the points of two pairs of dimensions must be joined as if at random.
TEST(Sampler, pairs_of_dimensions_are_uniform_jointly) {
    const int bins = 8, per_pixel = 64, pixels = 400;
    std::vector<double> observed(bins * bins, 0.0), expected(bins * bins, double(per_pixel) * pixels / (bins * bins));
    for (uint p = 0; p < pixels; ++p) {
        for (uint i = 0; i < per_pixel; ++i) {
            const int x = int(draw(uvec2(p, 9), i, 2).x * bins), y = int(draw(uvec2(p, 9), i, 3).x * bins);
            observed[std::size_t(x * bins + y)] += 1;
        }
    }
    EXPECT_GT(test::chi_square_test(observed, expected), 1e-3);
}

TEST(Rng, is_uniform_and_streams_differ) {
    Sampler s = make_sampler(uvec2(5, 6), 7, 8);
    Rng a = make_rng(s, 0), b = make_rng(s, 1);
    std::vector<double> observed(32 * 32, 0.0), expected(32 * 32, 200.0);
    double correlation = 0;
    for (int i = 0; i < 32 * 32 * 200; ++i) {
        const float x = rng_1d(a), y = rng_1d(b);
        ASSERT_TRUE(x >= 0.0f && x <= ONE_MINUS_EPSILON);
        observed[std::size_t(x * 32) * 32 + std::size_t(y * 32)] += 1;
        correlation += (double(x) - 0.5) * (double(y) - 0.5) * 12;
    }
    EXPECT_GT(test::chi_square_test(observed, expected), 1e-3);
    EXPECT_LT(std::abs(correlation) / std::sqrt(32.0 * 32 * 200), 4.5);
}

TEST(Rng, does_not_depend_on_the_samplers_dimension) {
    Sampler s = make_sampler(uvec2(5, 6), 7, 8);
    const uint state = make_rng(s, 3).key;
    sampler_2d(s);
    EXPECT_EQ(make_rng(s, 3).key, state);
    EXPECT_NE(make_rng(s, 4).key, state);
    EXPECT_NE(make_rng(make_sampler(uvec2(5, 6), 8, 8), 3).key, state);
    EXPECT_NE(make_rng(make_sampler(uvec2(6, 6), 7, 8), 3).key, state);
}

TEST(Hash, changes_half_the_bits) {
    double flipped = 0;
    const int count = 2000;
    for (uint i = 0; i < count; ++i) {
        for (int bit = 0; bit < 32; ++bit) flipped += popcount32(hash_uint(i) ^ hash_uint(i ^ (1u << bit)));
    }
    EXPECT_NEAR(flipped / (count * 32.0), 16.0, 0.1);
}

}  // namespace
}  // namespace spinel::random_test
