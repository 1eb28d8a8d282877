// Bricks of volumes: what goes in comes out, within what each precision promises; look-ups equal plain ones over dense
// samples; bounds hold.

#include "geometry/volume/grid_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "geometry/volume/noise_bounds.h"
#include "kernels/density.h"

namespace spinel::grid_test {
namespace {

using kernels::uint;

// A blob of noise in the middle, 0 around it, a solid of 2 in a corner.
std::vector<float> blob(ivec3 size) {
    std::vector<float> values;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const vec3 p(x, y, z);
                const bool inside = glm::length(p / vec3(size) - 0.5f) < 0.3f;
                const bool solid = x > size.x * 3 / 4 && y > size.y * 3 / 4;
                values.push_back(solid ? 2.0f : inside ? 3 * kernels::value_noise(p * 0.37f) - 1 : 0.0f);
            }
    return values;
}

// The compiled arrays of one grid.
struct Compiled {
    std::vector<std::uint32_t> words = {1, 2, 3};
    std::vector<float> floats = {1};
    kernels::DensityGrid record = {};
    kernels::SceneView view = {};

    explicit Compiled(const Grid& grid) {
        const auto built = append_grid(grid, words, floats);
        EXPECT_TRUE(built) << built.error().message;
        record = *built;
        view.words.at = words.data();
        view.floats.at = floats.data();
    }
};

// Plain interpolation over dense samples, in doubles.
double plain_value(const std::vector<float>& values, ivec3 size, Filter filter, vec3 p) {
    const auto at = [&](ivec3 i) {
        i = glm::clamp(i, ivec3(0), size - 1);
        return double(values[std::size_t(i.x + size.x * (i.y + size.y * i.z))]);
    };
    if (filter == Filter::nearest) return at(ivec3(glm::floor(p)));
    const auto weight = [&](double x) {
        x = std::abs(x);
        if (filter == Filter::linear) return std::max(0.0, 1 - x);
        return x < 1 ? 2.0 / 3 - x * x + x * x * x / 2 : x < 2 ? std::pow(2 - x, 3) / 6 : 0.0;
    };
    double sum = 0;
    const ivec3 base(glm::floor(p));
    for (int z = -3; z <= 3; ++z)
        for (int y = -3; y <= 3; ++y)
            for (int x = -3; x <= 3; ++x) {
                const ivec3 i = base + ivec3(x, y, z);
                const glm::dvec3 d = glm::dvec3(p) - glm::dvec3(i) - 0.5;
                const double w = weight(d.x) * weight(d.y) * weight(d.z);
                if (w > 0) sum += w * at(i);
            }
    return sum;
}

TEST(Grid, samples_come_back_and_uniform_bricks_are_shared) {
    const ivec3 size(61, 40, 33);
    const std::vector<float> values = blob(size);
    const auto grid = build_grid(size, values);
    ASSERT_TRUE(grid) << grid.error().message;
    EXPECT_EQ((*grid)->dense(), values);
    EXPECT_EQ((*grid)->table().size(), std::size_t(8 * 5 * 5));
    EXPECT_LT((*grid)->stored_count(), 120u) << "empty bricks share one";
    EXPECT_EQ((*grid)->minimum(), *std::min_element(values.begin(), values.end()));
    EXPECT_EQ((*grid)->maximum(), *std::max_element(values.begin(), values.end()));

    const auto empty = build_grid({1 << 9, 1 << 9, 1 << 8}, 1, [](ivec3, std::span<float> s) {
        std::fill(s.begin(), s.end(), 0.5f);
        return 0;
    });
    ASSERT_TRUE(empty) << empty.error().message;
    EXPECT_EQ((*empty)->stored_count(), 1u);
    EXPECT_FALSE(build_grid({1 << 20, 1 << 20, 1 << 20}, 1, [](ivec3, std::span<float>) { return 0; }));
    EXPECT_FALSE(build_grid({0, 1, 1}, std::vector<float>{}));
    EXPECT_FALSE(build_grid({2, 1, 1}, std::vector<float>{1}));
    EXPECT_FALSE(build_grid({1, 1, 1}, std::vector<float>{NAN}));
}

TEST(Grid, look_ups_equal_plain_interpolation_in_every_filter_and_precision) {
    std::mt19937 random(7);
    for (const ivec3 size : {ivec3(61, 40, 33), ivec3(1, 1, 1), ivec3(8, 8, 8), ivec3(9, 1, 20)}) {
        const std::vector<float> values = blob(size);
        Grid grid;
        grid.samples = *build_grid(size, values);
        grid.background = -5;
        const auto [low, high] = std::minmax_element(values.begin(), values.end());
        for (const Filter filter : {Filter::nearest, Filter::linear, Filter::cubic})
            for (const GridPrecision precision :
                 {GridPrecision::full, GridPrecision::half, GridPrecision::bits16, GridPrecision::bits8}) {
                grid.filter = filter;
                grid.precision = precision;
                const Compiled c(grid);
                const double spread = double(*high) - double(*low);
                const double error = precision == GridPrecision::half     ? 3.0 / 2048
                                     : precision == GridPrecision::bits16 ? spread / 131070
                                     : precision == GridPrecision::bits8  ? spread / 510
                                                                          : 0;
                for (int i = 0; i < 4000; ++i) {
                    vec3 p;
                    for (int a = 0; a < 3; ++a)
                        p[a] = std::uniform_real_distribution<float>(-1, float(size[a]) + 1)(random);
                    if (i % 5 == 0) p = glm::floor(p) + 0.5f;
                    const float found = kernels::grid_density(c.view, c.record, p);
                    const bool inside = kernels::grid_contains(c.record, p);
                    const double expected = inside ? plain_value(values, size, filter, p) : -5.0;
                    ASSERT_NEAR(found, expected, error + 4e-6)
                        << "size " << size.x << " filter " << int(filter) << " precision " << int(precision);
                    if (!inside) continue;
                    const ivec3 cell = ivec3(p) / c.record.majorant_cell;
                    const auto m =
                        std::size_t(cell.x + c.record.majorant_size.x * (cell.y + c.record.majorant_size.y * cell.z));
                    ASSERT_LE(found, c.floats[c.record.majorant_first + m] + 1e-6f);
                    ASSERT_GE(found, c.floats[c.record.minorant_first + m] - 1e-6f);
                }
            }
    }
}

TEST(Grid, what_is_no_place_is_outside) {
    const ivec3 size(8, 9, 10);
    Grid grid;
    grid.samples = *build_grid(size, blob(size));
    grid.background = -5;
    const Compiled c(grid);
    EXPECT_TRUE(kernels::grid_contains(c.record, vec3(0.0f)));
    EXPECT_TRUE(kernels::grid_contains(c.record, vec3(7.9f, 8.9f, 9.9f)));
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float bad : {NAN, -NAN, infinity, -infinity, -1e-30f, 10.0f, 3e38f, -3e38f})
        for (int a = 1; a < 8; ++a) {  // on some axes or all
            const vec3 p(a & 1 ? bad : 4.0f, a & 2 ? bad : 4.0f, a & 4 ? bad : 4.0f);
            EXPECT_FALSE(kernels::grid_contains(c.record, p)) << bad << " " << a;
            EXPECT_EQ(kernels::grid_density(c.view, c.record, p), -5.0f);
        }
}

TEST(Grid, vectors_have_three_channels) {
    std::vector<float> values;
    for (int i = 0; i < 3 * 17 * 2; ++i) values.push_back(float(i));
    Grid grid;
    grid.samples = *build_grid({17, 2, 1}, values, 3);
    for (const GridPrecision precision : {GridPrecision::full, GridPrecision::half}) {
        grid.precision = precision;
        const Compiled c(grid);
        EXPECT_EQ(kernels::grid_vector(c.view, c.record, {10.5f, 1.5f, 0.5f}), vec3(81, 82, 83));
        EXPECT_EQ(kernels::grid_vector(c.view, c.record, {11, 1.5f, 0.5f}), vec3(82.5f, 83.5f, 84.5f));
    }
}

TEST(Grid, halves_that_would_be_infinite_are_refused) {
    Grid grid;
    grid.samples = *build_grid({1, 1, 1}, std::vector<float>{70000});
    grid.precision = GridPrecision::half;
    std::vector<std::uint32_t> words;
    std::vector<float> floats;
    EXPECT_FALSE(append_grid(grid, words, floats));
}

TEST(NoiseBounds, hold_for_every_noise_and_are_of_use) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0, 1);
    for (const uint kind : {kernels::NOISE_VALUE, kernels::NOISE_PERLIN, kernels::NOISE_SIMPLEX})
        for (const uint octaves : {1u, 4u}) {
            double found = 0, bound = 0;
            for (int box = 0; box < 2000; ++box) {
                const float edge = box % 4 == 0 ? 0.9f * unit(random) : 0.3f * unit(random);
                vec3 lower;
                for (int a = 0; a < 3; ++a) lower[a] = 200 * unit(random) - 100;
                if (box % 7 == 0) lower = glm::floor(lower);
                const vec3 upper = lower + edge;
                const Interval b = noise_bounds(kind, lower, upper, octaves, 0.5f, 2);
                float low = 1, high = -1;
                for (int i = 0; i < 60; ++i) {
                    vec3 p;
                    for (int a = 0; a < 3; ++a)
                        p[a] = glm::mix(lower[a], upper[a], i < 8 ? float(i >> a & 1) : unit(random));
                    const float n = kernels::fractal_noise(kind, p, octaves, 0.5f, 2);
                    ASSERT_GE(n, b.low) << kind << " " << octaves << " box " << box;
                    ASSERT_LE(n, b.high) << kind << " " << octaves << " box " << box;
                    low = std::min(low, n), high = std::max(high, n);
                }
                if (box % 4 != 0) found += high - low, bound += b.high - b.low;
            }
            // How much wider than what is there: value noise is bounded closely, the others by intervals.
            EXPECT_LT(bound, found * (kind == kernels::NOISE_VALUE    ? 2.5
                                      : kind == kernels::NOISE_PERLIN ? 4
                                                                      : 8))
                << kind << " " << octaves;
        }
}

TEST(NoiseBounds, far_away_and_wide_are_still_sound) {
    for (const vec3 p : {vec3(3e8f), vec3(-1e12f), vec3(1e6f, 0, 0)})
        for (const uint kind : {kernels::NOISE_VALUE, kernels::NOISE_PERLIN, kernels::NOISE_SIMPLEX}) {
            const Interval b = noise_bounds(kind, p, p + 0.5f, 3, 0.5f, 2);
            EXPECT_GE(kernels::fractal_noise(kind, p, 3, 0.5f, 2), b.low);
            EXPECT_LE(kernels::fractal_noise(kind, p, 3, 0.5f, 2), b.high);
        }
}

}  // namespace
}  // namespace spinel::grid_test
