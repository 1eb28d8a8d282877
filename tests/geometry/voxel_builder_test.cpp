#include "geometry/voxels/voxel_builder.h"

#include <gtest/gtest.h>

#include "geometry/test_scene.h"

namespace spinel {
namespace {

TEST(VoxelBuilder, four_cells_to_a_word_little_end_first) {
    const auto built = build_voxels(test::voxels_of({3, 2, 1}, {1, 2, 3, 4, 5, 200}));
    ASSERT_TRUE(built);
    EXPECT_EQ(built->words, (std::vector<std::uint32_t>{0x04030201u, 0x0000c805u}));
    EXPECT_EQ(built->grid.size, ivec3(3, 2, 1));
    EXPECT_EQ(built->grid.word_first, 0u);
    EXPECT_EQ(built->slot_count, 200u);
}

TEST(VoxelBuilder, what_does_not_fit_is_refused) {
    const auto tree = build_voxel_tree({2048, 2048, 1024}, {{{0, 0, 0}, 1}});
    ASSERT_TRUE(tree);
    EXPECT_EQ(build_voxels({*tree}).error().message,
              "voxel grid of size 2048×2048×1024 is too large: at most 715827882 cells");
    EXPECT_EQ(build_voxels(test::voxels_of({1, 1, 1}, {256})).error().message,
              "voxel grid has palette index 256; at most 255 is allowed");
}

}  // namespace
}  // namespace spinel
