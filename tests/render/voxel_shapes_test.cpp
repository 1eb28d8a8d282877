#include "kernels/voxel_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "geometry/test_scene.h"
#include "kernels/locate.h"
#include "kernels/surface.h"
#include "kernels/traverse.h"
#include "render/pictures.h"
#include "render/reference.h"

namespace spinel::voxel_shapes_test {
namespace {

using namespace test;
using kernels::Hit;

constexpr char WATER[] = R"("waves": {"palette": [2], "height": 0.6, "length": 3, "count": 5})";
constexpr char ROUND[] = R"("rounding": [0.3, 0, 0.5, 0.12])";

// Stone (1, 3, 4) and water (2) at random, as a compiled scene. `looks`: keys of the geometry.
CompiledScene random_scene(Random& random, const std::string& looks, ivec3 size, bool water) {
    std::string cells;
    for (int i = 0; i < size.x * size.y * size.z; ++i) {
        const std::uint32_t k = random.below(9);
        cells += (i ? "," : "") + std::to_string(k < 4 ? 0 : k == 4 ? 1 : k < 7 ? (water ? 2 : 1) : k == 7 ? 3 : 4);
    }
    const auto compiled = compile_text(
        R"({"version": 1, "camera": {"from": [9, 9, 20]}, "materials": {"a": {"type": "diffuse"}, "b": {"type": "dielectric", "ior": 1.33}},
            "objects": [{"geometry": {"type": "voxels", "size": [)" +
        std::to_string(size.x) + "," + std::to_string(size.y) + "," + std::to_string(size.z) + R"(], "cells": [)" +
        cells + "], " + looks + R"(}, "material": ["a", ")" + (water ? "b" : "a") + R"(", "a", "a"]}]})");
    if (!compiled) throw std::runtime_error(compiled.error().message);
    return *compiled;
}

kernels::Ray random_ray(Random& random, ivec3 size, bool awkward) {
    const vec3 centre = 0.5f * vec3(size);
    vec3 from = centre + random.in_cube(1.5f) * vec3(size), d = random.direction();
    if (random.below(3)) d = centre + 0.5f * random.in_cube() * vec3(size) - from;
    if (awkward) {
        d = random.awkward_direction();
        from = glm::floor(from) + (random.below(2) ? vec3(0.5f, 0.25f, 0.5f) : vec3(0));
    }
    return ray(from, d * random.uniform(0.1f, 10));
}

// Hits of the kernel walk against those of the naive twin, which takes small steps in double precision. Grazing rays
// may be told apart: a few.
void expect_the_naive_twin(const std::string& looks, bool water, bool awkward, double allowed) {
    Random random(awkward ? 5 : 4);
    int differing = 0, inner = 0, count = 0;
    for (int round = 0; round < 8; ++round) {
        const ivec3 size(2 + random.below(6), 2 + random.below(6), 2 + random.below(6));
        const CompiledScene compiled = random_scene(random, looks, size, water);
        const kernels::SceneView scene = compiled.view();
        ASSERT_EQ(scene.voxel_grids.at[0].walk, kernels::VOXEL_WALK_SHAPES);
        for (int i = 0; i < 400; ++i, ++count) {
            const kernels::Ray r = random_ray(random, size, awkward);
            const Hit a = kernels::trace_closest(scene, r, kernels::TRACE_ALL);
            const Hit b = brute_force_closest(scene, r, kernels::TRACE_ALL);
            ASSERT_EQ(kernels::trace_any(scene, r, kernels::TRACE_ALL), kernels::is_hit(a)) << describe(r);
            if (!kernels::is_hit(a) && !kernels::is_hit(b)) continue;
            const float speed = glm::length(r.direction);
            if (a.instance != b.instance || a.cell != b.cell || !(std::abs(a.t - b.t) * speed < 2e-4f)) {
                ++differing;
                continue;
            }
            EXPECT_EQ(a.primitive, b.primitive);
            if ((a.face & kernels::VOXEL_FACE_INNER) != (b.face & kernels::VOXEL_FACE_INNER)) continue;
            inner += (a.face & kernels::VOXEL_FACE_INNER) ? 1 : 0;
            EXPECT_GT(glm::dot(glm::normalize(a.normal), glm::normalize(b.normal)), 0.995f) << describe(r);
        }
    }
    EXPECT_LE(differing, allowed * count);
    EXPECT_GT(inner, count / 80);  // else nothing was tested
}

TEST(VoxelShapes, rounded_voxels_are_those_of_the_naive_twin) { expect_the_naive_twin(ROUND, false, false, 0.002); }
TEST(VoxelShapes, waves_are_those_of_the_naive_twin) { expect_the_naive_twin(WATER, true, false, 0.003); }
TEST(VoxelShapes, both_together_on_awkward_rays) {
    expect_the_naive_twin(std::string(ROUND) + ", " + WATER, true, true, 0.02);
}

// A ray that leaves a rounded surface is outside, wherever it goes.
TEST(VoxelShapes, nothing_shadows_the_outside_of_a_single_rounded_voxel) {
    for (const float radius : {0.05f, 0.3f, 0.5f}) {
        const auto compiled = compile_text(
            R"({"version": 1, "camera": {}, "materials": {"a": {"type": "diffuse"}}, "objects": [{"geometry": {"type": "voxels",
                "size": [1, 1, 1], "cells": [1], "rounding": )" +
            std::to_string(radius) +
            R"(}, "material": "a", "transform": [{"scale": 3}, {"translate": [100, 20, -7]}]}]})");
        ASSERT_TRUE(compiled) << compiled.error().message;
        const kernels::SceneView scene = compiled->view();
        Random random(9);
        int found = 0;
        for (int i = 0; i < 4000; ++i) {
            const vec3 middle(101.5f, 21.5f, -5.5f);
            const vec3 from = middle + 20.0f * random.direction();
            const kernels::Ray r = ray(from, middle + random.in_cube(1.6f) - from);
            const Hit hit = kernels::trace_closest(scene, r, kernels::TRACE_ALL);
            if (!kernels::is_hit(hit)) continue;
            ++found;
            const kernels::Surface s = kernels::surface_at(scene, r, hit);
            EXPECT_TRUE(s.entering) << describe(r);
            // On the rounded box: its distance is that of a box less the radius.
            const vec3 q = glm::abs(s.position - middle) - (1.5f - 3 * radius);
            EXPECT_NEAR(glm::length(glm::max(q, vec3(0))), 3 * radius, 1e-4f);
            for (int k = 0; k < 4; ++k) {
                vec3 d = random.direction();
                if (glm::dot(d, s.geometric_normal) < 0) d = -d;
                const kernels::Ray onward = ray(kernels::leave_surface(scene, s, d), d);
                ASSERT_FALSE(kernels::trace_occluded(scene, onward)) << describe(r) << " then " << describe(onward);
            }
        }
        EXPECT_GT(found, 2000);
    }
}

// Voxels in a row are one bar: no notch between them, to the accuracy of floats.
TEST(VoxelShapes, equal_neighbours_join_smoothly) {
    const auto compiled = compile_text(
        R"({"version": 1, "camera": {}, "materials": {"a": {"type": "diffuse"}}, "objects": [{"geometry": {"type": "voxels",
            "size": [5, 1, 1], "cells": [1, 1, 1, 1, 1], "rounding": 0.3}, "material": "a"}]})");
    ASSERT_TRUE(compiled);
    const kernels::SceneView scene = compiled->view();
    Random random(2);
    for (int i = 0; i < 2000; ++i) {
        const float x = random.uniform(0.35f, 4.65f), z = random.uniform(0.01f, 0.99f);
        const Hit hit = kernels::trace_closest(scene, ray({x, 3, z}, {0, -1, 0}), kernels::TRACE_ALL);
        ASSERT_TRUE(kernels::is_hit(hit));
        const float aside = std::max({0.3f - z, z - 0.7f, 0.0f});
        EXPECT_NEAR(3 - hit.t, 0.7f + std::sqrt(0.09f - aside * aside), 2e-5f);
        EXPECT_EQ(hit.normal.x, 0.0f);
    }
}

// What a path is inside of stays known: from above into the water and out of it again, whatever the way.
TEST(VoxelShapes, every_way_into_the_water_has_a_way_out) {
    Random random(3);
    const ivec3 size(9, 5, 9);
    const CompiledScene compiled = random_scene(random, WATER, size, true);
    const kernels::SceneView scene = compiled.view();
    int crossed = 0;
    for (int i = 0; i < 4000; ++i) {
        kernels::Ray r = random_ray(random, size, false);
        r.direction = glm::normalize(r.direction);
        kernels::Inside inside = kernels::inside_nothing();
        if (kernels::interiors_at(scene, r.origin).count > 0) continue;
        for (int k = 0; k < 64; ++k) {
            const Hit hit = kernels::trace_closest(scene, r, kernels::TRACE_ALL);
            if (!kernels::is_hit(hit)) {
                EXPECT_EQ(inside.count, 0u) << describe(r);
                break;
            }
            const kernels::Surface s = kernels::surface_at(scene, r, hit);
            if (hit.primitive != 2) break;  // stone
            if (s.leaves != NO) {
                ASSERT_TRUE(kernels::inside_contains(inside, s.leaves)) << describe(r);
                kernels::inside_leave(inside, s.leaves);
            }
            kernels::inside_enter(inside, s.enters);
            EXPECT_LE(inside.count, 1u) << describe(r);
            ++crossed;
            r.origin = kernels::leave_surface(scene, s, r.direction);
        }
    }
    EXPECT_GT(crossed, 1000);
}

// White stone and clear water in white light are unseen: light is neither lost at edges nor made by waves.
TEST(VoxelShapes, waves_and_round_edges_pass_a_furnace) {
    const auto compiled = compile_text(
        R"({"version": 1, "camera": {"from": [3, 4, 9], "at": [3, 1, 3]}, "film": {"size": [24, 16]}, "environment": {"type": "constant"},
            "materials": {"a": {"type": "diffuse", "color": 1}, "b": {"type": "dielectric", "ior": 1.33}},
            "objects": [{"geometry": {"type": "voxels", "layers": [["111111", "122221", "122221", "122321", "122221", "111111"],
              ["......", ".2222.", ".2222.", ".2232.", ".2222.", "......"]], "rounding": [0.25, 0, 0.4],
              "waves": {"palette": [2], "height": 0.7, "length": 2.5}}, "material": ["a", "b", "a"]}]})");
    ASSERT_TRUE(compiled) << compiled.error().message;
    const TestPicture picture = render_scene(*compiled, 32);
    const Estimate mean = picture.mean();
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(mean.mean[k], 1, 0.004);
}

}  // namespace
}  // namespace spinel::voxel_shapes_test
