#include "kernels/voxels.h"

#include <gtest/gtest.h>

#include "geometry/test_scene.h"
#include "render/reference.h"

namespace spinel {
namespace {

using namespace test;
using kernels::Hit;

constexpr std::uint32_t GLASS = 0, WATER = 1;
// Palette 1: stone, 2 and 3: glass of two materials and one interior, 4: water, 5: fog without a material, 6:
// nothing at all.
const std::vector<kernels::Slot> SLOTS = {{0, NO}, {1, GLASS}, {2, GLASS}, {3, WATER}, {NO, 2}, {NO, NO}};

struct Grid3 {
    explicit Grid3(ivec3 s) : size(s), cells(std::size_t(s.x) * std::size_t(s.y) * std::size_t(s.z), 0) {}
    std::uint16_t& at(int x, int y, int z) { return cells[std::size_t(x + size.x * (y + size.y * z))]; }
    operator VoxelGeometry() const { return voxels_of(size, cells); }

    ivec3 size;
    std::vector<std::uint16_t> cells;
};

Hit closest(const kernels::SceneView& scene, const kernels::Ray& r) {
    Hit hit = kernels::no_hit(r.t_max);
    kernels::voxels_closest(scene, 0, scene.instances.at[0].slot_first, r, hit);
    if (hit.t < r.t_max) hit.instance = 0;
    return hit;
}

// All interfaces along a ray, each found from just behind the one before.
std::vector<Hit> all_hits(const kernels::SceneView& scene, kernels::Ray r) {
    std::vector<Hit> hits;
    for (int i = 0; i < 1000; ++i) {
        const Hit hit = closest(scene, r);
        if (!kernels::is_hit(hit)) break;
        hits.push_back(hit);
        r.t_min = hit.t;
    }
    return hits;
}

TEST(VoxelWalk, a_block_of_glass_of_several_palette_entries_has_no_inner_faces) {
    Grid3 grid({6, 6, 6});
    Random random(1);
    for (std::uint16_t& cell : grid.cells) cell = std::uint16_t(2 + random.below(2));
    TestScene parts;
    parts.add(grid);
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
    const kernels::SceneView& scene = parts.view();
    for (int i = 0; i < 20000; ++i) {
        const vec3 target = vec3(3) + random.in_cube(2.9f);
        const vec3 direction = glm::normalize(random.awkward_direction());
        const std::vector<Hit> hits = all_hits(scene, ray(target - 20.0f * direction, direction));
        ASSERT_EQ(hits.size(), 2u);
        ASSERT_LT(glm::dot(hits[0].normal, direction), 0);  // in …
        ASSERT_GT(glm::dot(hits[1].normal, direction), 0);  // … and out
        // From inside there is the exit alone.
        ASSERT_EQ(all_hits(scene, ray(target, direction)).size(), 1u);
    }
}

TEST(VoxelWalk, glass_in_water_has_one_interface) {
    Grid3 grid({5, 1, 1});
    grid.at(0, 0, 0) = grid.at(1, 0, 0) = grid.at(4, 0, 0) = 4;
    grid.at(2, 0, 0) = 2;
    grid.at(3, 0, 0) = 3;
    TestScene parts;
    parts.add(grid);
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
    const std::vector<Hit> hits = all_hits(parts.view(), ray(vec3(-1, 0.25f, 0.5f), vec3(1, 0, -0.0f)));
    ASSERT_EQ(hits.size(), 4u);
    const int cells[] = {0, 2, 4, 4};  // the owner is what is entered; into air, what is left
    const float ts[] = {1, 3, 5, 6};
    const float normals[] = {-1, -1, -1, 1};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(hits[i].cell, ivec3(cells[i], 0, 0));
        EXPECT_EQ(hits[i].primitive, std::uint32_t(cells[i]));
        EXPECT_EQ(hits[i].t, ts[i]);
        EXPECT_EQ(hits[i].normal, vec3(normals[i], 0, 0));
        EXPECT_EQ(hits[i].face, normals[i] > 0 ? 1u : 0u);
        EXPECT_EQ(hits[i].uv, vec2(0.25f, 0.5f));
    }
}

TEST(VoxelWalk, stone_in_glass_stops_the_ray_and_a_slot_without_anything_is_air) {
    Grid3 grid({4, 1, 1});
    grid.at(0, 0, 0) = 6;
    grid.at(1, 0, 0) = 2;
    grid.at(2, 0, 0) = grid.at(3, 0, 0) = 1;
    TestScene parts;
    parts.add(grid);
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
    const kernels::SceneView& scene = parts.view();
    const kernels::Ray r = ray(vec3(-1, 0.5f, 0.5f), vec3(1, 0, 0));
    EXPECT_EQ(closest(scene, r).cell, ivec3(1, 0, 0));
    kernels::Ray behind = r;
    behind.t_min = 2.5f;
    EXPECT_EQ(closest(scene, behind).cell, ivec3(2, 0, 0));
    EXPECT_EQ(closest(scene, behind).t, 3.0f);
}

TEST(VoxelWalk, a_ray_that_starts_inside_stone_sees_it_at_once) {
    Grid3 grid({3, 3, 3});
    grid.at(1, 1, 1) = 1;
    TestScene parts;
    parts.add(grid);
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
    const kernels::SceneView& scene = parts.view();
    for (const float t_min : {0.0f, 0.25f}) {
        const Hit hit = closest(scene, ray(vec3(1.25f, 1.5f, 1.5f), vec3(1, 0.1f, 0), t_min));
        EXPECT_GT(hit.t, t_min);
        EXPECT_NEAR(hit.t, t_min, 1e-6);
        EXPECT_EQ(hit.cell, ivec3(1));
        EXPECT_EQ(hit.normal, vec3(-1, 0, 0));
    }
    // On a face the direction decides: inwards it is in the stone, outwards it is in the air.
    EXPECT_NEAR(closest(scene, ray(vec3(1, 1.5f, 1.5f), vec3(1, 0, 0))).t, 0, 1e-6);
    EXPECT_EQ(closest(scene, ray(vec3(1, 1.5f, 1.5f), vec3(1, 0, 0))).cell, ivec3(1));
    EXPECT_FALSE(kernels::is_hit(closest(scene, ray(vec3(1, 1.5f, 1.5f), vec3(-1, 0, 0)))));
    EXPECT_FALSE(kernels::is_hit(closest(scene, ray(vec3(2, 1.5f, 1.5f), vec3(1, 0, 0)))));
    EXPECT_EQ(closest(scene, ray(vec3(2, 1.5f, 1.5f), vec3(-1, 0, 0))).cell, ivec3(1));
    // Along a face, floor() decides: the plane y = 1 belongs to cell 1, y = 2 to cell 2.
    EXPECT_EQ(closest(scene, ray(vec3(-1, 1, 1.5f), vec3(1, 0, 0))).t, 2.0f);
    EXPECT_FALSE(kernels::is_hit(closest(scene, ray(vec3(-1, 2, 1.5f), vec3(1, -0.0f, 0)))));
}

// Random grids against all planes sorted, classes looked up at midpoints.
TEST(VoxelWalk, equals_the_naive_twin) {
    Random random(2);
    int hits = 0, ambiguous = 0, rays = 0;
    for (int round = 0; round < 40; ++round) {
        Grid3 grid(ivec3(1 + random.below(12), 1 + random.below(12), 1 + random.below(12)));
        const std::uint32_t density = 1 + random.below(10);
        for (std::uint16_t& cell : grid.cells) cell = random.below(10) < density ? std::uint16_t(random.below(7)) : 0;
        TestScene parts;
        parts.add(grid);
        parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
        const kernels::SceneView& scene = parts.view();
        for (int i = 0; i < 3000; ++i) {
            const vec3 size(grid.size);
            vec3 origin = 0.5f * size + random.in_cube() * size * (i % 2 ? 0.5f : 1.5f);
            // Aimed at corners and edges of cells, from points on the lattice: planes meet at the same t.
            if (i % 5 == 0) origin = glm::round(origin);
            vec3 direction = random.awkward_direction() * std::exp(random.uniform(-5, 5));
            if (i % 7 == 0) direction = glm::round(origin + random.in_cube(5)) - origin;
            if (kernels::is_black(direction)) continue;
            const kernels::Ray r = ray(origin, direction, i % 3 ? 0.0f : random.uniform(0, 1) / glm::length(direction));
            const Hit hit = closest(scene, r);
            const ReferenceHit expected = reference_hit(scene, r, kernels::TRACE_ALL);
            ++rays;
            const double tolerance =
                3e-6 * (glm::length(origin) + 12) / glm::length(direction) + 1e-5 * std::abs(expected.t);
            const bool found = kernels::is_hit(hit), wanted = expected.hit.instance == 0;
            if (found && wanted && std::abs(hit.t - expected.t) <= tolerance) {
                ++hits;
                if (hit.cell != expected.hit.cell || hit.face != expected.hit.face) ++ambiguous;  // edges, corners
                continue;
            }
            if (!found && !wanted) continue;
            // A ray through an edge or a corner, as exactly as floats can tell, may see either side of it:
            // then some ray beside it must.
            bool explained = false;
            for (int j = 0; j < 64 && !explained; ++j) {
                kernels::Ray beside = r;
                beside.origin += 4e-6f * (glm::abs(origin) + 1.0f) * random.in_cube();
                beside.direction += 1e-6f * glm::length(direction) * random.in_cube();
                const ReferenceHit other = reference_hit(scene, beside, kernels::TRACE_ALL);
                explained =
                    (other.hit.instance == 0) == found && (!found || std::abs(hit.t - other.t) <= 4 * tolerance);
            }
            ASSERT_TRUE(explained) << describe(r) << " round " << round << " hit " << hit.t << " expected "
                                   << expected.t;
            ++ambiguous;
        }
    }
    EXPECT_GT(hits, rays / 4);
    EXPECT_LT(ambiguous, rays / 8);
}

// However a ray crosses a closed shell of stone, it does not get through.
TEST(VoxelWalk, no_ray_leaves_a_closed_room) {
    Grid3 grid({16, 16, 16});
    for (int z = 0; z < 16; ++z) {
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) {
                const bool wall = std::min({x, y, z}) == 0 || std::max({x, y, z}) == 15;
                grid.at(x, y, z) = wall ? 1 : 0;
            }
        }
    }
    TestScene parts;
    parts.add(grid);
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
    const kernels::SceneView& scene = parts.view();
    Random random(3);
    for (int i = 0; i < 300000; ++i) {
        vec3 origin = vec3(8) + random.in_cube(6.9f);
        if (i % 3 == 0) origin = glm::round(origin);
        vec3 direction = random.awkward_direction();
        if (i % 2 == 0) direction = glm::round(vec3(8) + random.in_cube(8)) - origin;
        if (kernels::is_black(direction)) continue;
        const kernels::Ray r = ray(origin, direction);
        const Hit hit = closest(scene, r);
        ASSERT_TRUE(kernels::is_hit(hit)) << describe(r);
        ASSERT_TRUE(kernels::voxels_any(scene, 0, 0, r));
        const vec3 p = kernels::ray_at(r, hit.t);
        ASSERT_NEAR(kernels::max_component(glm::abs(p - vec3(8))), 7, 1e-4) << describe(r);
    }
}

}  // namespace
}  // namespace spinel
