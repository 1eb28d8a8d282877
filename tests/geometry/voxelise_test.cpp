#include "geometry/voxels/voxelise.h"

#include <gtest/gtest.h>

#include "geometry/test_scene.h"
#include "geometry/voxels/terrain.h"

namespace spinel::voxelise_test {
namespace {

using namespace test;

TEST(Terrain, is_the_formula_that_others_can_repeat) {
    const auto tree = build_terrain({256, 256, 256}, false);
    ASSERT_TRUE(tree);
    const Terrain terrain(256, 256);
    Random random(1);
    for (int i = 0; i < 20000; ++i) {
        const ivec3 cell(random.below(256), random.below(256), random.below(256));
        ASSERT_EQ((*tree)->at(cell), terrain.at(cell) != 0);
    }
    const auto strata = build_terrain({256, 256, 256});
    EXPECT_EQ((*strata)->voxel_count(), (*tree)->voxel_count());
    EXPECT_EQ((*strata)->palette_maximum(), TERRAIN_LEAVES);
}

TEST(Voxelise, every_point_of_the_surface_lies_in_a_voxel_and_no_voxel_is_far_from_it) {
    const MeshGeometry mesh = icosphere(2);
    const auto voxels = voxelise_surface(mesh, 40);
    ASSERT_TRUE(voxels);
    const mat4x3 to_cells(glm::inverse(glm::mat4(voxels->transform)));
    Random random(2);
    for (int i = 0; i < 50000; ++i) {
        const uvec3 t = mesh.triangles[random.below(std::uint32_t(mesh.triangles.size()))];
        float u = random.uniform(0, 1), v = random.uniform(0, 1);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const vec3 p = (1 - u - v) * mesh.positions[t.x] + u * mesh.positions[t.y] + v * mesh.positions[t.z];
        const vec3 q = to_cells * vec4(p, 1);
        const ivec3 cell = glm::clamp(ivec3(glm::floor(q)), ivec3(0), voxels->tree->size() - 1);
        const vec3 inside = glm::abs(q - vec3(cell) - 0.5f);
        if (kernels::max_component(inside) >= 0.4999f) continue;  // rounding may choose the neighbour
        ASSERT_EQ(voxels->tree->at(cell), 1);
    }
    voxels->tree->for_each([&](ivec3 cell, std::uint16_t) {
        const float radius = glm::length(voxels->transform * vec4(vec3(cell) + 0.5f, 1));
        ASSERT_GT(radius, 0.85f);
        ASSERT_LT(radius, 1.06f);
    });
    EXPECT_FALSE(voxelise_surface(mesh, 0));
    EXPECT_FALSE(voxelise_surface({}, 10));
}

}  // namespace
}  // namespace spinel::voxelise_test
