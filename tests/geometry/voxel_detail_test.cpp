// Coarser sets: what becomes of cubes, what stays.

#include <gtest/gtest.h>

#include <array>
#include <cstring>

#include "geometry/test_scene.h"
#include "geometry/voxels/voxel_detail.h"
#include "geometry/voxels/voxel_mips.h"

namespace spinel::voxel_detail_test {
namespace {

using namespace test;

bool always(ivec3, int edge) { return edge <= 4; }
bool every(std::uint16_t) { return true; }

VoxelTreePointer random_tree(Random& random, ivec3 size, int one_in) {
    std::vector<std::uint16_t> cells(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
    for (std::uint16_t& cell : cells) cell = random.below(one_in) == 0 ? std::uint16_t(1 + random.below(4)) : 0;
    return *build_voxel_tree(size, cells);
}

std::vector<std::uint16_t> cube_cells(const VoxelTree& tree, ivec3 lower, int edge) {
    std::vector<std::uint16_t> cells;
    for (int z = 0; z < edge; ++z)
        for (int y = 0; y < edge; ++y)
            for (int x = 0; x < edge; ++x) cells.push_back(tree.at(lower + ivec3(x, y, z)));
    return cells;
}

TEST(VoxelDetail, cubes_become_what_most_of_their_voxels_are_and_the_others_stay) {
    Random random(5);
    const ivec3 size(39, 20, 33);  // not a multiple of 4 everywhere
    for (const int one_in : {2, 20, 200}) {
        const VoxelTreePointer tree = random_tree(random, size, one_in);
        // Only the lower half along x is far off; palette index 4 must not change.
        const auto coarse = [](ivec3 lower, int edge) { return edge <= 4 && lower.x < 16; };
        const VoxelTreePointer reduced = with_less_detail(*tree, {coarse, [](std::uint16_t p) { return p != 4; }});
        ASSERT_EQ(reduced->size(), size);
        int filled = 0, kept = 0;
        for (int z = 0; z < size.z; z += 4)
            for (int y = 0; y < size.y; y += 4)
                for (int x = 0; x < size.x; x += 4) {
                    const ivec3 lower(x, y, z);
                    const std::vector<std::uint16_t> before = cube_cells(*tree, lower, 4),
                                                     after = cube_cells(*reduced, lower, 4);
                    std::array<int, 5> counts{};
                    for (const std::uint16_t p : before) ++counts[p];
                    const bool inside = x + 4 <= size.x && y + 4 <= size.y && z + 4 <= size.z;
                    if (inside && x < 16 && counts[4] == 0 && counts[0] < 64) {
                        int most = 1;
                        for (int p = 2; p <= 3; ++p)
                            if (counts[std::size_t(p)] > counts[std::size_t(most)]) most = p;
                        ASSERT_EQ(after, std::vector<std::uint16_t>(64, std::uint16_t(most)))
                            << x << ' ' << y << ' ' << z;
                        ++filled;
                    } else {
                        ASSERT_EQ(after, before) << x << ' ' << y << ' ' << z;
                        ++kept;
                    }
                }
        if (one_in > 2) { EXPECT_GT(filled, 10); }
        EXPECT_GT(kept, 10);
    }
}

TEST(VoxelDetail, without_a_coarse_cube_the_tree_is_the_same_to_the_last_bit) {
    Random random(6);
    const VoxelTreePointer tree = random_tree(random, {70, 30, 65}, 9);
    const VoxelTreePointer same = with_less_detail(*tree, {[](ivec3, int) { return false; }, every});
    const auto& a = tree->arrays();
    const auto& b = same->arrays();
    ASSERT_EQ(a.nodes.size(), b.nodes.size());
    EXPECT_EQ(std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof a.nodes[0]), 0);
    EXPECT_EQ(std::memcmp(&a.root, &b.root, sizeof a.root), 0);
    EXPECT_EQ(a.palettes, b.palettes);
}

TEST(VoxelDetail, a_coarse_set_takes_less_room) {
    Random random(7);
    const VoxelTreePointer tree = random_tree(random, {64, 64, 64}, 3);
    const VoxelTreePointer coarse = with_less_detail(*tree, {always, every});
    EXPECT_LT(coarse->memory().palette_bytes + coarse->memory().node_bytes,
              (tree->memory().palette_bytes + tree->memory().node_bytes) / 2);
}

// ------------------------------------------------------------------------------------------------------------ mips
kernels::VoxelLook look(float opacity, vec3 albedo, vec3 emission = vec3(0)) {
    kernels::VoxelLook l = kernels::no_voxel_look();
    l.coverage = vec3(opacity);
    l.albedo = albedo;
    l.emission = emission;
    l.share = l.emitting = emission != vec3(0) ? 1.0f : 0.0f;
    return l;
}

kernels::VoxelLook root_look(const VoxelTreePointer& tree, const std::vector<kernels::VoxelLook>& looks) {
    return kernels::unpack_voxel_look(build_voxel_mips(*tree, looks).palette[0]);
}

TEST(VoxelMips, a_wall_of_one_voxel_covers_its_cube_from_the_front_and_much_less_from_the_side) {
    std::vector<VoxelPoint> points;
    for (int x = 0; x < 64; ++x)
        for (int y = 0; y < 64; ++y) points.push_back({{x, y, 21}, 1});
    const auto l = root_look(*build_voxel_tree({64, 64, 64}, points), {look(1, vec3(0.5f, 0.25f, 0))});
    EXPECT_NEAR(l.coverage.z, 1, 0.003);
    // 1/64 in truth: cubes in a row count as if they knew nothing of each other.
    EXPECT_LT(l.coverage.x, 0.15);
    EXPECT_LT(l.coverage.y, 0.15);
    EXPECT_GT(l.coverage.x, 1 / 64.0);
    EXPECT_NEAR(l.albedo.x, 0.5, 0.005);
    EXPECT_NEAR(l.albedo.y, 0.25, 0.005);
}

TEST(VoxelMips, what_emits_keeps_its_power_up_to_the_root) {
    Random random(8);
    std::vector<VoxelPoint> points;
    double emitting = 0;
    for (int i = 0; i < 500; ++i) {
        const ivec3 cell(random.below(256), random.below(256), random.below(256));
        points.push_back({cell, std::uint16_t(1 + i % 2)});
    }
    const VoxelTreePointer tree = *build_voxel_tree({256, 256, 256}, points);
    tree->for_each([&](ivec3, std::uint16_t p) { emitting += p == 2; });
    const auto l = root_look(tree, {look(1, vec3(0.8f)), look(1, vec3(0), vec3(3, 2, 1))});
    EXPECT_NEAR(double(l.emitting) * 256 * 256 * 256, emitting, 0.01);
    EXPECT_NEAR(l.emission.x, 3, 1e-4);
    EXPECT_NEAR(l.emission.z, 1, 1e-4);
}

TEST(VoxelMips, shared_subtrees_have_the_same_mips) {
    const VoxelFunction function{[](ivec3 c) { return std::uint16_t((c.x & 3) == 1 && (c.y & 7) < 3 ? 1 : 0); }, {}};
    const VoxelTreePointer apart = *build_voxel_tree({128, 128, 128}, function),
                           shared = *build_voxel_tree({128, 128, 128}, function, {.share = true});
    const std::vector<kernels::VoxelLook> looks = {look(0.5f, vec3(0.3f))};
    EXPECT_LT(build_voxel_mips(*shared, looks).nodes.size(), build_voxel_mips(*apart, looks).nodes.size() / 10);
    const auto a = root_look(apart, looks), b = root_look(shared, looks);
    EXPECT_EQ(a.coverage, b.coverage);
    EXPECT_EQ(a.albedo, b.albedo);
}

TEST(VoxelMips, what_shows_decides_the_colour) {
    // Earth with a layer of grass.
    const VoxelFunction function{[](ivec3 c) { return std::uint16_t(c.y < 6 ? 1 : c.y == 6 ? 2 : 0); }, {}};
    const auto l =
        root_look(*build_voxel_tree({16, 16, 16}, function), {look(1, vec3(1, 0, 0)), look(1, vec3(0, 1, 0))});
    EXPECT_GT(l.albedo.y, 2 * l.albedo.x);
}

}  // namespace
}  // namespace spinel::voxel_detail_test
