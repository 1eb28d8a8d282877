#include "geometry/voxels/voxel_builder.h"

#include <gtest/gtest.h>

namespace spinel {
namespace {

TEST(VoxelBuilder, four_cells_to_a_word_little_end_first) {
    VoxelGeometry voxels;
    voxels.size = {3, 2, 1};
    voxels.cells = {1, 2, 3, 4, 5, 200};
    const auto built = build_voxels(voxels);
    ASSERT_TRUE(built);
    EXPECT_EQ(built->words, (std::vector<std::uint32_t>{0x04030201u, 0x0000c805u}));
    EXPECT_EQ(built->grid.size, ivec3(3, 2, 1));
    EXPECT_EQ(built->grid.word_first, 0u);
    EXPECT_EQ(built->slot_count, 200u);
}

TEST(VoxelBuilder, bad_grids_are_refused) {
    const auto error_of = [](ivec3 size, std::size_t cells) {
        VoxelGeometry voxels;
        voxels.size = size;
        voxels.cells.resize(cells);
        const auto built = build_voxels(voxels);
        return built ? std::string() : built.error().message;
    };
    EXPECT_EQ(error_of({0, 1, 1}, 0), "voxel grid has size 0×1×1; every edge must be at least 1");
    EXPECT_EQ(error_of({2, -1, 1}, 0), "voxel grid has size 2×-1×1; every edge must be at least 1");
    EXPECT_EQ(error_of({2, 2, 2}, 7), "voxel grid of size 2×2×2 has 7 cells instead of 8");
    EXPECT_EQ(error_of({2048, 2048, 1024}, 1),
              "voxel grid of size 2048×2048×1024 is too large: at most 715827882 cells");
    EXPECT_NE(error_of(ivec3(0x7fffffff), 1), "");
}

}  // namespace
}  // namespace spinel
