#include "geometry/voxels/sparse_cells.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace spinel::sparse_cells_test {
namespace {

// Cells at random within `extent` of a corner that is no multiple of anything, some set twice, some solid cubes.
struct Cells {
    SparseCells sparse;
    std::vector<VoxelPoint> points;

    void set(ivec3 cell, std::uint16_t palette) {
        ASSERT_TRUE(sparse.set(cell, palette));
        points.push_back({cell, palette});
    }
};

Cells random_cells(ivec3 corner, int extent, int count, std::uint32_t seed) {
    std::mt19937 random(seed);
    const auto below = [&](int n) { return int(random() % std::uint32_t(n)); };
    Cells cells;
    for (int i = 0; i < count; ++i)
        cells.set(corner + ivec3(below(extent), below(extent), below(extent)), std::uint16_t(1 + below(400)));
    for (int cube = 0; cube < 3; ++cube) {
        const ivec3 at = corner + ivec3(below(extent), below(extent), below(extent));
        for (int i = 0; i < 4096; ++i) cells.set(at + ivec3(i & 15, i >> 4 & 15, i >> 8), 7);
    }
    return cells;
}

void expect_equal_to_points(const Cells& cells) {
    const auto [lower, upper] = cells.sparse.bounds();
    std::vector<VoxelPoint> points = cells.points;
    for (VoxelPoint& p : points) p.cell -= lower;
    const Result<VoxelTreePointer> expected = build_voxel_tree(upper - lower + 1, points);
    const Result<VoxelTreePointer> tree = cells.sparse.tree(lower, upper - lower + 1);
    ASSERT_TRUE(expected);
    ASSERT_TRUE(tree);
    EXPECT_EQ((*tree)->size(), (*expected)->size());
    EXPECT_EQ((*tree)->voxel_count(), (*expected)->voxel_count());
    EXPECT_EQ((*tree)->palette_maximum(), (*expected)->palette_maximum());
    const VoxelTree::Arrays &a = (*tree)->arrays(), &b = (*expected)->arrays();
    const auto same = [](const kernels::VoxelNode& x, const kernels::VoxelNode& y) {
        return x.mask_low == y.mask_low && x.mask_high == y.mask_high && x.link == y.link;
    };
    EXPECT_TRUE(same(a.root, b.root));
    EXPECT_TRUE(std::equal(a.nodes.begin(), a.nodes.end(), b.nodes.begin(), b.nodes.end(), same));
    EXPECT_EQ(a.palettes, b.palettes);
}

TEST(SparseCells, give_the_same_tree_as_a_list_of_points) {
    // Within a node of cells, of several; within a chunk, across chunks, across many levels; below zero.
    std::uint32_t seed = 1;
    for (const int extent : {1, 3, 14, 50, 200, 1500, 70000})
        for (const ivec3 corner : {ivec3(0), ivec3(-37, 5, -1000003)}) {
            SCOPED_TRACE("extent " + std::to_string(extent) + ", seed " + std::to_string(seed));
            expect_equal_to_points(random_cells(corner, extent, 2000, seed++));
        }
}

TEST(SparseCells, hold_what_was_set_last_and_tell_their_bounds) {
    SparseCells cells;
    EXPECT_TRUE(cells.empty());
    ASSERT_TRUE(cells.set({-1, 2, 300}, 3));
    ASSERT_TRUE(cells.set({5, -20, 300}, 4));
    ASSERT_TRUE(cells.set({-1, 2, 300}, 5));
    EXPECT_FALSE(cells.empty());
    EXPECT_EQ(cells.bounds(), std::pair(ivec3(-1, -20, 300), ivec3(5, 2, 300)));
    std::map<std::array<int, 3>, int> found;
    cells.for_each([&](ivec3 c, std::uint16_t palette) { found[{c.x, c.y, c.z}] = palette; });
    EXPECT_EQ(found, (std::map<std::array<int, 3>, int>{{{-1, 2, 300}, 5}, {{5, -20, 300}, 4}}));
}

TEST(SparseCells, stay_within_their_memory) {
    SparseCells cells(100);
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(cells.set({i * 16, 0, 0}, 1));
    EXPECT_FALSE(cells.set({-1, 0, 0}, 1));
    EXPECT_TRUE(cells.set({1, 0, 0}, 1));  // where there is a cube
}

}  // namespace
}  // namespace spinel::sparse_cells_test
