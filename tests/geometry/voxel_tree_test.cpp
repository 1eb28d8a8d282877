#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <map>
#include <set>
#include <tuple>

#include "geometry/test_scene.h"
#include "geometry/voxels/terrain.h"
#include "spinel/voxels.h"

namespace spinel::voxel_tree_test {
namespace {

using namespace test;

constexpr VoxelTreeOptions plain{}, shared{.share = true};

std::vector<std::uint16_t> random_cells(Random& random, ivec3 size, std::uint32_t palette_maximum) {
    std::vector<std::uint16_t> cells(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
    // Blocks of equal cells, so that solid nodes of several sizes arise, and noise.
    const int block = 1 << random.below(6);
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const ivec3 cell(int(i) % size.x, int(i) / size.x % size.y, int(i) / size.x / size.y);
        const ivec3 b = cell / block;
        const std::uint32_t h = std::uint32_t(b.x * 7919 + b.y * 104729 + b.z * 1299709) * 2654435761u >> 16;
        cells[i] = h % 3 == 0   ? 0
                   : h % 3 == 1 ? std::uint16_t(1 + h % palette_maximum)
                                : std::uint16_t(random.below(palette_maximum + 1));
    }
    return cells;
}

void expect_equals_cells(const VoxelTree& tree, ivec3 size, const std::vector<std::uint16_t>& cells) {
    ASSERT_EQ(tree.size(), size);
    std::size_t i = 0, count = 0;
    std::uint16_t maximum = 0;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x, ++i) {
                ASSERT_EQ(tree.at({x, y, z}), cells[i]) << x << ' ' << y << ' ' << z;
                count += cells[i] != 0;
                maximum = std::max(maximum, cells[i]);
            }
    EXPECT_EQ(tree.voxel_count(), count);
    EXPECT_EQ(tree.palette_maximum(), maximum);
    std::size_t visited = 0;
    tree.for_each([&](ivec3 c, std::uint16_t palette) {
        ++visited;
        ASSERT_NE(palette, 0);
        ASSERT_EQ(palette, cells[std::size_t(c.x + size.x * (c.y + size.y * c.z))]);
    });
    EXPECT_EQ(visited, count);
}

TEST(VoxelTree, dense_slabs_points_and_functions_give_the_same_set) {
    Random random(1);
    for (int round = 0; round < 30; ++round) {
        const ivec3 size(1 + random.below(90), 1 + random.below(40), 1 + random.below(90));
        const auto cells = random_cells(random, size, round % 2 ? 200 : 65535);
        std::vector<VoxelPoint> points;
        VoxelFunction function;
        function.palette = [&](ivec3 c) { return cells[std::size_t(c.x + size.x * (c.y + size.y * c.z))]; };
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    if (random.below(5) == 0) points.push_back({{x, y, z}, std::uint16_t(random.below(65536))});
                    points.push_back({{x, y, z}, function.palette({x, y, z})});  // the last one counts
                }
        for (const VoxelTreeOptions& options : {plain, shared}) {
            const auto dense = build_voxel_tree(size, cells, options);
            const auto listed = build_voxel_tree(size, points, options);
            const auto computed = build_voxel_tree(size, function, options);
            for (const auto& tree : {dense, listed, computed}) {
                ASSERT_TRUE(tree) << tree.error().message;
                expect_equals_cells(**tree, size, cells);
            }
            EXPECT_EQ((*dense)->memory().node_bytes, (*listed)->memory().node_bytes);
            EXPECT_EQ((*dense)->memory().node_bytes, (*computed)->memory().node_bytes);
        }
    }
}

TEST(VoxelTree, boxes_are_believed_and_give_the_same_tree) {
    const ivec3 size(300, 200, 260);
    int asked = 0;
    VoxelFunction function;
    function.palette = [&](ivec3 c) { return std::uint16_t(c.y < 100 ? 7 : c.y < 130 && c.x > 250 ? 9 : 0); };
    const auto slow = build_voxel_tree(size, function);
    function.box = [&](ivec3 lower, ivec3 upper) -> std::optional<std::uint16_t> {
        ++asked;
        if (upper.y <= 100) return std::uint16_t(7);
        if (lower.y >= 130) return std::uint16_t(0);
        return std::nullopt;
    };
    const auto fast = build_voxel_tree(size, function);
    ASSERT_TRUE(slow && fast);
    EXPECT_GT(asked, 0);
    EXPECT_EQ((*fast)->voxel_count(), (*slow)->voxel_count());
    EXPECT_EQ((*fast)->voxel_count(), 300u * 100u * 260u + 49u * 30u * 260u);
    EXPECT_EQ((*fast)->memory().node_bytes, (*slow)->memory().node_bytes);
    Random random(2);
    for (int i = 0; i < 10000; ++i) {
        const ivec3 c(random.below(300), random.below(200), random.below(260));
        ASSERT_EQ((*fast)->at(c), function.palette(c));
    }
}

TEST(VoxelTree, a_few_points_in_a_huge_set_take_a_few_nodes) {
    const int n = VoxelTree::max_edge;
    const auto tree = build_voxel_tree({n, n, n}, {{{0, 0, 0}, 1}, {{n - 1, n - 1, n - 1}, 2}, {{n - 1, 0, 5}, 300}});
    ASSERT_TRUE(tree);
    EXPECT_EQ((*tree)->voxel_count(), 3u);
    EXPECT_EQ((*tree)->at({0, 0, 0}), 1);
    EXPECT_EQ((*tree)->at({n - 1, n - 1, n - 1}), 2);
    EXPECT_EQ((*tree)->at({n - 1, 0, 5}), 300);
    EXPECT_EQ((*tree)->at({n - 1, 0, 6}), 0);
    EXPECT_EQ((*tree)->at({n, 0, 0}), 0);
    EXPECT_EQ((*tree)->at({-1, 0, 0}), 0);
    EXPECT_LT((*tree)->memory().node_bytes, 500u);
    // A solid one as well: the boxes say so.
    VoxelFunction solid{[](ivec3) { return std::uint16_t(4); },
                        [](ivec3, ivec3) { return std::optional<std::uint16_t>(4); }};
    const auto full = build_voxel_tree({n, n, n}, solid);
    ASSERT_TRUE(full);
    EXPECT_EQ((*full)->voxel_count(), std::uint64_t(1) << 60);
    EXPECT_EQ((*full)->memory().node_bytes, 12u);
}

TEST(VoxelTree, cubes_cover_each_voxel_once) {
    Random random(3);
    const ivec3 size(70, 65, 33);
    const auto cells = random_cells(random, size, 3);
    const auto tree = build_voxel_tree(size, cells);
    std::vector<std::uint16_t> seen(cells.size(), 0);
    (*tree)->for_each_cube([&](ivec3 lower, int edge, std::uint16_t palette) {
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y)
                for (int x = 0; x < edge; ++x) {
                    const ivec3 c = lower + ivec3(x, y, z);
                    std::uint16_t& s = seen.at(std::size_t(c.x + size.x * (c.y + size.y * c.z)));
                    ASSERT_EQ(s, 0);
                    s = palette;
                }
    });
    EXPECT_EQ(seen, cells);
}

TEST(VoxelTree, sharing_keeps_a_repeated_subtree_once) {
    // The same 16³ pattern 64 times.
    VoxelFunction function;
    function.palette = [](ivec3 c) {
        const ivec3 p = c & 15;
        return std::uint16_t((p.x * 31 + p.y * 17 + p.z * 7) % 5 % 3);
    };
    const auto whole = build_voxel_tree({64, 64, 64}, function),
               once = build_voxel_tree({64, 64, 64}, function, shared);
    ASSERT_TRUE(whole && once);
    const auto bytes = [](const VoxelTreeMemory& m) { return m.node_bytes + m.reference_bytes + m.palette_bytes; };
    EXPECT_LT(bytes((*once)->memory()) * 20, bytes((*whole)->memory()));
}

TEST(VoxelTree, shared_rows_of_references_overlap) {
    const auto whole = build_terrain({256, 128, 256}), once = build_terrain({256, 128, 256}, true, shared);
    ASSERT_TRUE(whole && once);
    const auto cubes = [](const VoxelTree& tree) {
        std::vector<std::array<int, 5>> list;
        tree.for_each_cube([&](ivec3 lower, int edge, std::uint16_t palette) {
            list.push_back({lower.x, lower.y, lower.z, edge, palette});
        });
        return list;
    };
    EXPECT_EQ(cubes(**once), cubes(**whole));

    const VoxelTree::Arrays& arrays = (*once)->arrays();
    std::map<std::uint32_t, int> rows;
    for (const kernels::VoxelNode& n : arrays.nodes)
        if ((n.link & kernels::VOXEL_LINK_KIND) == kernels::VOXEL_LINK_CHILDREN)
            rows[n.link] = std::popcount(n.mask_low) + std::popcount(n.mask_high);
    std::size_t words = 0;
    for (const auto& [start, count] : rows) words += std::size_t(count);
    EXPECT_LT(double(arrays.references.size()), 0.92 * double(words));
}

TEST(VoxelTree, an_empty_set_is_a_set) {
    const auto tree = build_voxel_tree({5, 5, 5}, std::vector<VoxelPoint>{{{1, 1, 1}, 3}, {{1, 1, 1}, 0}});
    ASSERT_TRUE(tree);
    EXPECT_EQ((*tree)->voxel_count(), 0u);
    EXPECT_EQ((*tree)->palette_maximum(), 0);  // of what is left
    (*tree)->for_each([](ivec3, std::uint16_t) { FAIL(); });
}

TEST(VoxelTree, bad_input_is_refused) {
    const std::vector<VoxelPoint> none;
    const auto message = [](const auto& result) { return result ? std::string() : result.error().message; };
    EXPECT_EQ(message(build_voxel_tree({0, 1, 1}, none)),
              "voxel set has size 0×1×1; every edge must be from 1 to 1048576");
    EXPECT_EQ(message(build_voxel_tree({2, -1, 1}, none)),
              "voxel set has size 2×-1×1; every edge must be from 1 to 1048576");
    EXPECT_NE(message(build_voxel_tree(ivec3(0x7fffffff), none)), "");
    EXPECT_EQ(message(build_voxel_tree({2, 2, 2}, std::vector<std::uint8_t>(7))),
              "voxel set of size 2×2×2 has 7 cells instead of 8");
    EXPECT_EQ(message(build_voxel_tree({2, 2, 2}, {{{0, 2, 0}, 1}})),
              "voxel (0, 2, 0) lies outside of its set of size 2×2×2");
    EXPECT_EQ(message(build_voxel_tree({2, 2, 2}, {{{0, 0, -1}, 1}})),
              "voxel (0, 0, -1) lies outside of its set of size 2×2×2");
    VoxelFunction everywhere{[](ivec3) { return std::uint16_t(1); }, {}};
    EXPECT_NE(message(build_voxel_tree(ivec3(1 << 18), everywhere)).find("function that answers for boxes"),
              std::string::npos);
}

}  // namespace
}  // namespace spinel::voxel_tree_test
