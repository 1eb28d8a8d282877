#include "geometry/volume/surface_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "geometry/sdf_test_scene.h"
#include "geometry/volume/grid_builder.h"
#include "geometry/volume/level_set_fog.h"
#include "geometry/volume/surface_reference.h"
#include "kernels/sdf.h"

namespace spinel::surface_builder_test {
namespace {

using glm::dvec3;
using kernels::Hit;
using kernels::INFINITE;
using kernels::Ray;

// A volume and its surface as kernels see it, in index space.
struct SurfaceScene {
    VolumeGeometry volume;
    Grid grid;
    std::vector<std::uint32_t> words;
    std::vector<float> floats;
    kernels::DensityGrid record;
    SdfData data;
    kernels::SceneView view = {};

    SurfaceScene(Grid from, VolumeGeometry shown) : volume(shown), grid(std::move(from)) {
        const Result<kernels::DensityGrid> appended = append_grid(grid, words, floats);
        if (!appended) throw std::runtime_error(appended.error().message);
        record = *appended;
        Result<SdfData> built = build_surface(volume, record, 0, words, floats);
        if (!built) throw std::runtime_error(built.error().message);
        data = *std::move(built);
        view.words.at = words.data();
        view.floats.at = floats.data();
        view.grids.at = &record;
        view.sdf_ops.at = data.ops.data();
        view.sdfs.at = &data.sdf;
    }
    SurfaceScene(const SurfaceScene&) = delete;

    // The twin, cut off at the outermost samples as the surface is.
    double twin(dvec3 p) const {
        const dvec3 q = glm::max(dvec3(0.5) - p, p - (dvec3(grid.samples->size()) - 0.5));
        const double beyond = std::max({q.x, q.y, q.z});
        return beyond > 0 ? beyond : surface_reference(volume, grid, p);
    }
    bool solid(dvec3 p) const { return twin(p) < 0; }
    float distance(vec3 p) const { return kernels::sdf_distance(view, 0, p); }
    Hit closest(const Ray& ray) const {
        Hit hit = kernels::no_hit(ray.t_max);
        kernels::sdf_closest(view, 0, ray, hit);
        return hit;
    }
    vec3 random_place(SdfRandom& random) const { return random.in_box(vec3(-2), vec3(grid.samples->size()) + 2.0f); }
};

Grid grid_of(ivec3 size, const std::function<float(ivec3)>& value, Filter filter = Filter::linear) {
    std::vector<float> values;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) values.push_back(value({x, y, z}));
    Grid grid;
    grid.name = "test";
    grid.samples = *build_grid(size, values);
    grid.filter = filter;
    return grid;
}

// Lumps a few samples wide: neither a distance nor anything like it, and solid at some of the box's faces.
Grid lumps(Filter filter) {
    return grid_of(
        {37, 21, 30},
        [](ivec3 i) {
            const vec3 p = 0.45f * vec3(i);
            return std::sin(p.x) * std::cos(0.7f * p.y + 0.3f * p.z) + 0.6f * std::sin(p.z - 0.4f * p.x) - 0.35f +
                   (i.x > 24 ? 3.0f : 0.0f);
        },
        filter);
}

struct Case {
    Filter filter;
    VolumeGeometry volume;
};
const Case cases[] = {{Filter::linear, {0, true, 0, false}},
                      {Filter::cubic, {0, true, 0, false}},
                      {Filter::linear, {0, true, 0.4f, true}},
                      {Filter::cubic, {0, true, 0.4f, true}}};

TEST(VolumeSurface, values_and_gradients_near_the_surface_equal_those_of_the_double_precision_twin) {
    for (const Case& c : cases) {
        const SurfaceScene scene(lumps(c.filter), c.volume);
        const double unit = std::abs(double(scene.data.ops[0].data0.y));
        SdfRandom random(1);
        int near = 0;
        for (int i = 0; i < 8000; ++i) {
            const vec3 p = random.in_box(vec3(0.6f), vec3(scene.grid.samples->size()) - 0.6f);
            const float value = kernels::sdf_grid(scene.view, scene.data.ops[0].b, p, vec2(scene.data.ops[0].data0));
            EXPECT_EQ(value < 0, scene.solid(dvec3(p))) << "at " << p.x << " " << p.y << " " << p.z;
            const double expected = unit * surface_reference(scene.volume, scene.grid, dvec3(p));
            if (std::abs(double(value) - expected) > 1e-5) {  // of the table: a whole number of coarse cells
                EXPECT_EQ(std::fmod(std::abs(value), 4.0f), 0.0f);
                continue;
            }
            ++near;
            const vec4 g =
                kernels::sdf_grid_gradient(scene.view, scene.data.ops[0].b, p, vec2(scene.data.ops[0].data0));
            EXPECT_NEAR(double(g.w), expected, 1e-5);
            const dvec3 inside = glm::fract(dvec3(p) - 0.5);
            for (int axis = 0; axis < 3; ++axis) {
                constexpr double h = 1e-4;
                if (inside[axis] < h || inside[axis] > 1 - h) continue;  // linear look-ups bend there
                dvec3 step(0);
                step[axis] = h;
                const double slope = (surface_reference(scene.volume, scene.grid, dvec3(p) + step) -
                                      surface_reference(scene.volume, scene.grid, dvec3(p) - step)) /
                                     (2 * h);
                EXPECT_NEAR(double(g[axis]), unit * slope, 2e-5);
            }
        }
        EXPECT_GT(near, 2000);
    }
}

TEST(VolumeSurface, no_point_of_the_surface_is_nearer_than_the_value) {
    for (const Case& c : cases) {
        const SurfaceScene scene(lumps(c.filter), c.volume);
        SdfRandom random(2);
        int inside = 0;
        for (int i = 0; i < 2000; ++i) {
            const vec3 p = random.in_box(scene.data.sdf.lower, scene.data.sdf.upper);
            const float value = scene.distance(p);
            inside += value < 0;
            for (int k = 0; k < 25; ++k) {
                const dvec3 q = dvec3(p) + 0.9999 * double(std::abs(value)) * double(random.uniform(0, 1)) *
                                               dvec3(random.direction());
                ASSERT_EQ(scene.solid(q), value < 0) << "value " << value;
            }
        }
        EXPECT_GT(inside, 200);
        EXPECT_LT(inside, 1800);
    }
}

TEST(VolumeSurface, hits_are_the_first_changes_of_sign_that_the_twin_finds_in_small_steps) {
    for (const Case& c : cases) {
        const SurfaceScene scene(lumps(c.filter), c.volume);
        SdfRandom random(3);
        int hits = 0;
        for (int i = 0; i < 300; ++i) {
            const vec3 o = scene.random_place(random);
            const vec3 d = random.direction();
            const auto solid_at = [&](double t) { return scene.solid(dvec3(o) + t * dvec3(d)); };
            const bool start = solid_at(0);
            double before = 0, expected = -1;
            for (double t = 0; t < 60; before = t, t += 1.0 / 64) {
                if (solid_at(t) == start) continue;
                double after = t;
                for (int j = 0; j < 50; ++j) {
                    const double middle = 0.5 * (before + after);
                    (solid_at(middle) == start ? before : after) = middle;
                }
                expected = after;
                break;
            }
            const Hit hit = scene.closest(Ray(o, 0, d, INFINITE));
            const double found = hit.t < INFINITE ? double(hit.t) : -1;
            if (expected < 0.01 || std::abs(found - expected) < 1e-3) {
                hits += found > 0;
                continue;
            }
            // Or one that the twin steps over, or that merely grazes: the sign changes there all the same.
            ASSERT_GT(found, 0) << "ray " << i << ", twin " << expected;
            ASSERT_LT(found, expected);
            bool changes = false;
            for (int k = 1; k <= 100; ++k) changes = changes || solid_at(found + 1e-4 * k) != start;
            EXPECT_TRUE(changes) << "ray " << i << ": " << found << ", twin " << expected;
        }
        EXPECT_GT(hits, 120);
    }
}

// Distances to a sphere, cut off at a band of three samples as level sets have it, or not.
Grid sphere_grid(float band, Filter filter) {
    Grid grid = grid_of(
        {50, 50, 50}, [=](ivec3 i) { return std::clamp(glm::length(vec3(i) + 0.5f - 25.2f) - 19.3f, -band, band); },
        filter);
    grid.background = band;
    grid.level_set = true;
    return grid;
}

TEST(VolumeSurface, a_level_set_of_a_sphere_is_the_sphere) {
    for (const Filter filter : {Filter::linear, Filter::cubic}) {
        const SurfaceScene scene(sphere_grid(3, filter), {0, true});
        const SurfaceScene whole(sphere_grid(1e3f, filter), {0, true});
        // Interpolation across a sample's width: 1/8 of the curvature, of both principal directions, and 1/3 of them
        // for what the B-spline smooths.
        const double close = filter == Filter::cubic ? 0.025 : 0.015;
        SdfRandom random(4);
        int hits = 0;
        for (int i = 0; i < 2500; ++i) {
            const dvec3 centre(25.2), o(scene.random_place(random));
            const dvec3 d(random.direction()), m = o - centre;
            const double b = glm::dot(d, m), c = glm::dot(m, m) - 19.3 * 19.3, discriminant = b * b - c;
            if (std::abs(discriminant) < 40 || std::abs(glm::length(m) - 19.3) < 0.5)
                continue;  // grazes, or starts there
            const Hit hit = scene.closest(Ray(vec3(o), 0, vec3(d), INFINITE));
            const double t = c < 0 ? -b + std::sqrt(discriminant) : -b - std::sqrt(discriminant);
            if (discriminant < 0 || t < 0) {
                EXPECT_EQ(hit.t, INFINITE);
                continue;
            }
            ++hits;
            ASSERT_LT(hit.t, INFINITE);
            EXPECT_NEAR(glm::length(o + double(hit.t) * d - centre), 19.3, close);
            EXPECT_GT(glm::dot(dvec3(hit.normal), glm::normalize(o + t * d - centre)), 0.998);
            EXPECT_NEAR(hit.t, whole.closest(Ray(vec3(o), 0, vec3(d), INFINITE)).t, 1e-3);
        }
        EXPECT_GT(hits, 600);
        EXPECT_LT(1 / scene.data.ops[0].data0.y, 1.4f) << "a distance is hardly divided";
    }
}

TEST(VolumeSurface, quantised_samples_have_the_surface_of_what_is_stored) {
    for (const GridPrecision precision : {GridPrecision::half, GridPrecision::bits16, GridPrecision::bits8}) {
        Grid grid = sphere_grid(3, Filter::linear);
        grid.precision = precision;
        const SurfaceScene scene(std::move(grid), {0, true});
        const Hit hit = scene.closest(Ray(vec3(25, 25, -5), 0, vec3(0, 0, 1), INFINITE));
        EXPECT_NEAR(hit.t, 25.2f - 19.3f + 5, 0.03f);
    }
}

TEST(VolumeSurface, a_solid_without_an_end_ends_at_the_outermost_samples) {
    const SurfaceScene scene(grid_of({9, 6, 5}, [](ivec3) { return -2.0f; }), {0, true});
    EXPECT_NEAR(scene.closest(Ray(vec3(-3, 3, 2.5f), 0, vec3(1, 0, 0), INFINITE)).t, 3.5f, 1e-5f);
    EXPECT_NEAR(scene.closest(Ray(vec3(4, 3, 2.5f), 0, vec3(0, 0, -2), INFINITE)).t, 1, 1e-5f);
}

// A long floor with a wall across its far end, of one layer of samples. Rays that graze the floor crawl, half a sample
// at a time at most; none may step over the wall.
TEST(VolumeSurface, walls_of_one_layer_stop_rays_that_graze_a_floor) {
    const SurfaceScene scene(grid_of({900, 40, 6},
                                     [](ivec3 i) {
                                         const float floor = float(i.y) - 9.0f;
                                         return i.x == 850 ? std::min(floor, -0.3f) : floor;
                                     }),
                             {0, true});
    SdfRandom random(5);
    for (int i = 0; i < 400; ++i) {
        const vec3 o(20, 9.5f + random.uniform(1e-4f, 2e-3f), random.uniform(1, 5));
        const Hit hit = scene.closest(Ray(o, 0, vec3(1, 0, 0), INFINITE));
        const float x = o.x + hit.t;
        EXPECT_TRUE(x > 849.5f && x < 850.5f) << "ray " << i << " from height " << o.y << " hits at " << x;
        EXPECT_LT(hit.normal.x, -0.1f);
    }
}

// So long a floor that a crawl by half samples would come to the bound on steps.
TEST(VolumeSurface, walls_at_the_far_end_of_a_very_long_floor_stop_rays_that_graze_it) {
    const SurfaceScene scene(grid_of({15000, 20, 4},
                                     [](ivec3 i) {
                                         const float floor = float(i.y) - 9.0f;
                                         return i.x >= 14980 && i.x < 14985 ? std::min(floor, -0.3f) : floor;
                                     }),
                             {0, true});
    SdfRandom random(6);
    for (int i = 0; i < 100; ++i) {
        const vec3 o(20, 9.5f + random.uniform(1e-4f, 2e-3f), random.uniform(1, 3));
        const float x = o.x + scene.closest(Ray(o, 0, vec3(1, 0, 0), INFINITE)).t;
        EXPECT_TRUE(x > 14979 && x < 14981) << "ray " << i << " from height " << o.y << " hits at " << x;
    }
}

// Values fall off slowly, so that near the box's face the grid seems nearer to its surface than the face is.
TEST(VolumeSurface, faces_that_cut_a_solid_have_the_normals_of_the_box) {
    for (const Filter filter : {Filter::linear, Filter::cubic}) {
        const SurfaceScene scene(
            grid_of(
                {40, 40, 40}, [](ivec3 i) { return i.x == 39 && i.y == 39 ? 1.0f : -1e-9f; }, filter),
            {0, true});
        SdfRandom random(6);
        for (int i = 0; i < 400; ++i) {
            const vec3 o(random.uniform(2, 30), random.uniform(2, 30), -4);
            const Hit hit = scene.closest(Ray(o, 0, vec3(0, 0, 1), INFINITE));
            EXPECT_NEAR(hit.t, 4.5f, 1e-4f);
            EXPECT_NEAR(hit.normal.z, -1, 1e-5f) << "at " << o.x << " " << o.y;
        }
    }
}

TEST(VolumeSurface, values_may_be_very_large_or_small) {
    for (const float unit : {1e-30f, 1e25f}) {
        const SurfaceScene scene(
            grid_of({20, 20, 20}, [=](ivec3 i) { return unit * (glm::length(vec3(i) - 9.5f) - 6.0f); }), {0, true});
        const Hit hit = scene.closest(Ray(vec3(-5, 10, 10), 0, vec3(1, 0, 0), INFINITE));
        EXPECT_NEAR(hit.t, 15 - 6, 0.05f);
        EXPECT_LT(hit.normal.x, -0.99f);
    }
}

TEST(VolumeSurface, what_has_no_surface_is_refused) {
    const Grid grid = grid_of({9, 6, 5}, [](ivec3 i) { return 1.0f + float(i.x); });
    std::vector<std::uint32_t> words;
    std::vector<float> floats;
    const kernels::DensityGrid record = *append_grid(grid, words, floats);
    EXPECT_EQ(build_surface({0, true}, record, 0, words, floats).error().message,
              "has no sample below its level, 0, and so no surface");
    EXPECT_EQ(build_surface({0, true, 20, true}, record, 0, words, floats).error().message,
              "has no sample above its level, 20, and so no surface");
    EXPECT_TRUE(build_surface({0, true, 1.5f, false}, record, 0, words, floats));

    kernels::DensityGrid huge = record;
    huge.majorant_size = ivec3(1024, 1024, 129);
    EXPECT_EQ(build_surface({0, true}, huge, 0, words, floats).error().message,
              "has 135266304 coarse cells; a surface may have up to 134217728");
    const Grid faint = grid_of({9, 6, 5}, [](ivec3 i) { return 1e-42f * (float(i.x) - 4.5f); });
    const kernels::DensityGrid faint_record = *append_grid(faint, words, floats);
    EXPECT_EQ(build_surface({0, true}, faint_record, 0, words, floats).error().message,
              "differs too little or too much between samples to have a surface");
}

TEST(VolumeSurface, a_level_set_as_fog_falls_to_nothing_at_its_surface) {
    const Grid level_set = sphere_grid(3, Filter::cubic), fog = fog_of_level_set(level_set);
    EXPECT_EQ(fog.samples->minimum(), 0);
    EXPECT_EQ(fog.samples->maximum(), 1);
    EXPECT_EQ(fog.background, 0);
    EXPECT_FALSE(fog.level_set);
    for (const ivec3 i : {ivec3(25), ivec3(25, 25, 6), ivec3(25, 25, 8), ivec3(0)})
        EXPECT_EQ(fog.samples->at(i), std::clamp(-level_set.samples->at(i) / 3, 0.0f, 1.0f));
}

}  // namespace
}  // namespace spinel::surface_builder_test
