#include "accel/bvh_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "core/parallel.h"

namespace spinel::bvh_builder_test {
namespace {

std::vector<Box> random_boxes(std::size_t count, std::uint32_t seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<float> place(-10, 10), edge(0, 0.3f);
    std::vector<Box> boxes(count);
    for (Box& box : boxes) {
        for (int axis = 0; axis < 3; ++axis) {
            box.lower[axis] = place(engine);
            box.upper[axis] = box.lower[axis] + edge(engine);
        }
    }
    return boxes;
}

constexpr BvhMethod all_methods[] = {BvhMethod::binned, BvhMethod::sweep, BvhMethod::reinsertion, BvhMethod::median};

bool contains(const kernels::BvhNode& outer, const glm::vec3& lower, const glm::vec3& upper) {
    return glm::all(glm::lessThanEqual(outer.lower, lower)) && glm::all(glm::greaterThanEqual(outer.upper, upper));
}

// Every box in exactly one leaf, inside of all its ancestors; leaves small enough; depth as the statistics
// say.
void check(const Bvh& bvh, const std::vector<Box>& boxes, std::size_t usable, std::uint32_t max_leaf) {
    ASSERT_EQ(bvh.order.size(), usable);
    std::vector<int> seen(boxes.size(), 0);
    if (usable == 0) {
        ASSERT_TRUE(bvh.nodes.empty());
        return;
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> stack{{0, 0}};
    std::uint32_t depth = 0, leaves = 0;
    std::size_t visited = 0;
    while (!stack.empty()) {
        const auto [index, level] = stack.back();
        stack.pop_back();
        ++visited;
        ASSERT_LE(visited, bvh.nodes.size());
        const kernels::BvhNode& node = bvh.nodes[index];
        depth = std::max(depth, level);
        if (node.count > 0) {
            ++leaves;
            ASSERT_LE(node.count, max_leaf);
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                const std::uint32_t box = bvh.order.at(i);
                ++seen.at(box);
                ASSERT_TRUE(contains(node, boxes[box].lower, boxes[box].upper));
            }
            continue;
        }
        for (std::uint32_t child = node.first; child < node.first + 2; ++child) {
            ASSERT_TRUE(contains(node, bvh.nodes.at(child).lower, bvh.nodes.at(child).upper));
            stack.push_back({child, level + 1});
        }
    }
    EXPECT_EQ(visited, bvh.nodes.size());
    EXPECT_EQ(depth, bvh.statistics.depth);
    EXPECT_EQ(leaves, bvh.statistics.leaf_count);
    EXPECT_LE(depth, kernels::BVH_MAX_DEPTH);
    std::size_t total = 0;
    for (const int times : seen) {
        ASSERT_LE(times, 1);
        total += std::size_t(times);
    }
    EXPECT_EQ(total, usable);
}

TEST(BvhBuilder, every_box_lies_in_one_leaf_and_in_all_its_ancestors) {
    for (const std::size_t count : {0, 1, 2, 3, 4, 5, 17, 1000, 20000}) {
        for (const std::uint32_t max_leaf : {1u, 4u, kernels::BVH_MAX_LEAF}) {
            const std::vector<Box> boxes = random_boxes(count, 1);
            for (const BvhMethod method : all_methods)
                check(build_bvh(boxes, {.max_leaf = max_leaf, .method = method}), boxes, count, max_leaf);
        }
    }
}

TEST(BvhBuilder, the_tree_does_not_depend_on_the_number_of_threads) {
    const std::vector<Box> boxes = random_boxes(40000, 2);
    for (const BvhMethod method : all_methods) {
        std::vector<Bvh> trees;
        for (const int threads : {1, 2, 4}) {
            const ThreadLimit limit(threads);
            trees.push_back(build_bvh(boxes, {.method = method}));
        }
        for (const Bvh& tree : trees) {
            ASSERT_EQ(tree.nodes.size(), trees[0].nodes.size());
            EXPECT_EQ(
                std::memcmp(tree.nodes.data(), trees[0].nodes.data(), tree.nodes.size() * sizeof(kernels::BvhNode)), 0);
            EXPECT_EQ(tree.order, trees[0].order);
        }
    }
}

TEST(BvhBuilder, more_work_buys_a_better_tree) {
    const std::vector<Box> boxes = random_boxes(20000, 6);
    const double median = build_bvh(boxes, {.method = BvhMethod::median}).statistics.sah_cost;
    const double binned = build_bvh(boxes, {.method = BvhMethod::binned}).statistics.sah_cost;
    const double sweep = build_bvh(boxes, {.method = BvhMethod::sweep}).statistics.sah_cost;
    EXPECT_LT(binned, median);
    EXPECT_LT(sweep, 1.01 * binned);
    EXPECT_LT(build_bvh(boxes, {.method = BvhMethod::reinsertion}).statistics.sah_cost, binned);
}

// Long and short boxes along all axes, as beams and furniture of a room are: a tree from above has to cut through some.
TEST(BvhBuilder, moving_nodes_pays_where_large_and_small_boxes_overlap) {
    std::vector<Box> boxes = random_boxes(8000, 8);
    for (std::size_t i = 0; i < boxes.size(); i += 5) boxes[i].upper[int(i / 5 % 3)] += 6;
    const double binned = build_bvh(boxes, {.method = BvhMethod::binned}).statistics.sah_cost;
    const Bvh moved = build_bvh(boxes, {.method = BvhMethod::reinsertion});
    check(moved, boxes, boxes.size(), 4);
    EXPECT_LT(moved.statistics.sah_cost, 0.85 * binned);
}

TEST(BvhBuilder, a_refitted_tree_holds_what_moved_and_nothing_more) {
    std::vector<Box> boxes = random_boxes(3000, 7);
    Bvh bvh = build_bvh(boxes);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const glm::vec3 by(std::sin(float(i)), 0.5f * std::cos(float(i)), 2);
        boxes[i].lower += by;
        boxes[i].upper += by;
    }
    std::vector<Box> in_order;
    for (const std::uint32_t i : bvh.order) in_order.push_back(boxes[i]);
    refit_bvh(bvh.nodes, in_order);
    bvh.statistics = bvh_statistics(bvh.nodes, 2);
    check(bvh, boxes, boxes.size(), 4);
    glm::vec3 lower = boxes[0].lower, upper = boxes[0].upper;
    for (const Box& box : boxes) lower = glm::min(lower, box.lower), upper = glm::max(upper, box.upper);
    EXPECT_EQ(bvh.nodes[0].lower, lower);
    EXPECT_EQ(bvh.nodes[0].upper, upper);
}

TEST(BvhBuilder, boxes_in_one_place_are_halved) {
    const std::vector<Box> boxes(10000, Box{glm::vec3(1), glm::vec3(2)});
    for (const BvhMethod method : {BvhMethod::binned, BvhMethod::reinsertion, BvhMethod::median}) {
        const Bvh bvh = build_bvh(boxes, {.method = method});
        check(bvh, boxes, boxes.size(), 4);
        EXPECT_LE(bvh.statistics.depth, 14u);
    }
}

TEST(BvhBuilder, depth_is_bounded_where_the_heuristic_would_peel_boxes_off_one_by_one) {
    std::vector<Box> boxes;
    for (int i = -120; i < 120; ++i) {
        const float size = std::ldexp(1.0f, i);
        for (int copy = 0; copy < 50; ++copy) boxes.push_back({glm::vec3(size), glm::vec3(size * 1.5f)});
    }
    for (const BvhMethod method : all_methods) check(build_bvh(boxes, {.method = method}), boxes, boxes.size(), 4);
}

TEST(BvhBuilder, boxes_that_are_not_finite_or_inverted_are_left_out) {
    const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
    std::vector<Box> boxes = random_boxes(1000, 3);
    boxes[10].lower.x = nan;
    boxes[20].upper.z = nan;
    boxes[30].upper.y = inf;
    boxes[40].lower.y = -inf;
    boxes[50] = {glm::vec3(1), glm::vec3(-1)};
    check(build_bvh(boxes), boxes, 995, 4);
    check(build_bvh(std::vector<Box>(7, Box{glm::vec3(nan), glm::vec3(nan)})), std::vector<Box>(7), 0, 4);
}

TEST(BvhBuilder, extreme_sizes_do_not_overflow_into_nonsense) {
    std::vector<Box> boxes = random_boxes(1000, 4);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const float scale = i % 3 == 0 ? 3e37f / 11 : i % 3 == 1 ? 1e-38f : 1.0f;
        boxes[i].lower *= scale;
        boxes[i].upper *= scale;
    }
    for (const BvhMethod method : all_methods) check(build_bvh(boxes, {.method = method}), boxes, boxes.size(), 4);
}

TEST(BvhBuilder, the_heuristic_beats_halving) {
    // A dense cluster in a sparse hall: halving by number would cut through both.
    std::vector<Box> boxes = random_boxes(5000, 5);
    for (std::size_t i = 0; i < 4000; ++i) {
        boxes[i].lower *= 0.01f;
        boxes[i].upper *= 0.01f;
    }
    const Bvh bvh = build_bvh(boxes);
    check(bvh, boxes, boxes.size(), 4);
    EXPECT_LT(bvh.statistics.sah_cost, 60);
    EXPECT_GT(bvh.statistics.sah_cost, 1);
}

}  // namespace
}  // namespace spinel::bvh_builder_test
