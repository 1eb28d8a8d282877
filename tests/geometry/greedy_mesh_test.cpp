#include "geometry/voxels/greedy_mesh.h"

#include <gtest/gtest.h>

#include <array>

#include "geometry/test_scene.h"

namespace spinel::greedy_mesh_test {
namespace {

using namespace test;

bool any_hides(std::uint16_t, std::uint16_t neighbour) { return neighbour != 0; }

// Doubled area by side and palette index, from the triangles.
std::array<std::array<double, 4>, 6> areas_of(const MeshGeometry& mesh) {
    std::array<std::array<double, 4>, 6> areas{};
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const uvec3 t = mesh.triangles[i];
        const vec3 n = glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
        for (int axis = 0; axis < 3; ++axis)
            if (n[axis] != 0) areas[std::size_t(2 * axis + (n[axis] > 0))][mesh.slots[i] + 1] += std::abs(n[axis]);
    }
    return areas;
}

TEST(GreedyMesh, has_the_area_of_the_faces_that_are_seen_of_each_side_and_colour) {
    Random random(11);
    for (int round = 0; round < 20; ++round) {
        const ivec3 size(1 + random.below(40), 1 + random.below(20), 1 + random.below(40));
        const std::uint32_t rare = 1 + random.below(6);
        std::vector<std::uint16_t> cells(std::size_t(size.x * size.y * size.z));
        for (std::uint16_t& c : cells)
            c = random.below(8) < rare ? std::uint16_t(1 + random.below(round % 2 ? 3 : 1)) : 0;
        cells[0] = 1;
        const auto tree = build_voxel_tree(size, cells);
        ASSERT_TRUE(tree);
        std::array<std::array<double, 4>, 6> expected{};
        (*tree)->for_each([&](ivec3 cell, std::uint16_t palette) {
            for (int side = 0; side < 6; ++side) {
                ivec3 across = cell;
                across[side / 2] += side % 2 ? 1 : -1;
                if ((*tree)->at(across) == 0) expected[std::size_t(side)][palette] += 2;
            }
        });
        const auto mesh = greedy_mesh(**tree, any_hides);
        ASSERT_TRUE(mesh);
        EXPECT_EQ(areas_of(*mesh), expected);
    }
}

TEST(GreedyMesh, a_block_of_one_colour_is_twelve_triangles) {
    const auto tree = build_voxel_tree({37, 16, 64}, {[](ivec3) { return std::uint16_t(2); }, {}});
    ASSERT_TRUE(tree);
    const auto mesh = greedy_mesh(**tree, any_hides);
    ASSERT_TRUE(mesh);
    EXPECT_EQ(mesh->triangles.size(), 12u);
    EXPECT_EQ(mesh->positions.size(), 8u);
    EXPECT_FALSE(greedy_mesh(*build_voxel_tree({2, 2, 2}, std::vector<VoxelPoint>{}).operator*(), any_hides));
}

TEST(GreedyMesh, what_is_behind_glass_is_seen) {
    const std::vector<std::uint16_t> cells = {1, 2};  // glass, then stone
    const auto tree = build_voxel_tree({2, 1, 1}, cells);
    const auto mesh = greedy_mesh(
        **tree, [](std::uint16_t own, std::uint16_t neighbour) { return neighbour == 2 || own == neighbour; });
    ASSERT_TRUE(mesh);
    EXPECT_EQ(areas_of(*mesh)[0][2], 2);  // of the stone, towards the glass
    EXPECT_EQ(areas_of(*mesh)[1][1], 0);  // of the glass, towards the stone
}

}  // namespace
}  // namespace spinel::greedy_mesh_test
