#include "accel/grain_bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "accel/morton_grains.h"
#include "accel/signed_bounds.h"
#include "accel/split_bvh.h"
#include "core/parallel.h"

namespace spinel::grain_bvh_test {
namespace {

std::vector<Box> random_boxes(std::size_t count, std::uint32_t seed, float size = 10) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<float> place(-size, size), edge(0, 0.03f * size);
    std::vector<Box> boxes(count);
    for (Box& box : boxes)
        for (int axis = 0; axis < 3; ++axis) {
            box.lower[axis] = place(engine);
            box.upper[axis] = box.lower[axis] + edge(engine);
        }
    return boxes;
}

// Each box in exactly one leaf, `usable` in all, inside of its ancestors; children behind their parents; boxes below
// a left child stand just before those below the right one, but for nodes above `groups`.
void check(const Bvh& bvh, const std::vector<Box>& boxes, std::size_t usable, std::uint32_t most, std::size_t groups) {
    ASSERT_EQ(bvh.order.size(), usable);
    std::vector<int> named(boxes.size()), held(bvh.order.size());
    std::vector<std::uint32_t> depth(bvh.nodes.size());
    for (std::uint32_t n = 0; n < bvh.nodes.size(); ++n) {
        const kernels::BvhNode& node = bvh.nodes[n];
        ASSERT_LE(depth[n], kernels::BVH_MAX_DEPTH);
        const auto holds = [&](const glm::vec3& lower, const glm::vec3& upper) {
            return glm::all(glm::lessThanEqual(node.lower, lower)) && glm::all(glm::lessThanEqual(upper, node.upper));
        };
        if (node.count == 0) {
            ASSERT_GT(node.first, n);
            for (std::uint32_t child : {node.first, node.first + 1}) {
                ASSERT_TRUE(holds(bvh.nodes.at(child).lower, bvh.nodes.at(child).upper));
                ASSERT_EQ(depth[child], 0u);
                depth[child] = depth[n] + 1;
            }
            continue;
        }
        ASSERT_LE(node.count, most);
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const std::uint32_t box = bvh.order.at(i);
            ASSERT_TRUE(holds(boxes.at(box).lower, boxes.at(box).upper));
            ASSERT_EQ(named[box]++, 0);
            ASSERT_EQ(held[i]++, 0);
        }
    }
    for (const int times : held) ASSERT_EQ(times, 1);
    struct Range {
        std::uint32_t first, end;
    };
    std::vector<Range> below(bvh.nodes.size());
    std::size_t scattered = 0;
    for (std::size_t n = bvh.nodes.size(); n-- > 0;) {
        const kernels::BvhNode& node = bvh.nodes[n];
        below[n] = {node.first, node.first + node.count};
        if (node.count > 0) continue;
        const Range &left = below[node.first], &right = below[node.first + 1];
        const bool together = left.end > 0 && right.end > 0 && left.end == right.first;
        below[n] = together ? Range{left.first, right.end} : Range{0, 0};
        scattered += !together;
    }
    EXPECT_LE(scattered, groups > 0 ? groups - 1 : 0);
}

// Of a tree of build_grain_bvh().
void check_grains(const Bvh& bvh, const std::vector<Box>& boxes, std::size_t usable, std::uint32_t most) {
    check(bvh, boxes, usable, most, morton_grains(boxes, 32).grains.size());
}

double area_of(const glm::vec3& e) { return double(e.x) * e.y + double(e.y) * e.z + double(e.z) * e.x; }

// Of a ray that meets a box of this extent, by nodes and leaves no larger than it, each at one.
double cost(const Bvh& bvh, const glm::vec3& extent) {
    double sum = 0;
    for (const kernels::BvhNode& n : bvh.nodes)
        if (const glm::vec3 e = n.upper - n.lower; glm::all(glm::lessThanEqual(e, extent))) sum += area_of(e);
    return sum / area_of(extent);
}

TEST(GrainBvh, every_box_lies_in_one_leaf_and_in_all_its_ancestors) {
    for (const std::size_t count : {0, 1, 2, 4, 5, 15, 16, 17, 33, 1000, 70000})
        for (const std::uint32_t leaf : {1u, 4u, kernels::BVH_MAX_LEAF}) {
            const std::vector<Box> boxes = random_boxes(count, 1);
            check_grains(build_grain_bvh(boxes, {.leaf = leaf}), boxes, count, leaf);
        }
}

TEST(GrainBvh, the_tree_does_not_depend_on_the_number_of_threads) {
    const std::vector<Box> boxes = random_boxes(200000, 2);
    Bvh first;
    for (const int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        Bvh tree = build_grain_bvh(boxes);
        if (threads == 1) first = tree;
        EXPECT_EQ(tree.order, first.order);
        ASSERT_EQ(tree.nodes.size(), first.nodes.size());
        EXPECT_EQ(std::memcmp(tree.nodes.data(), first.nodes.data(), tree.nodes.size() * sizeof(tree.nodes[0])), 0);
    }
}

// More boxes than are counted together; some of no use, in the first and third part of them.
TEST(GrainBvh, boxes_of_no_use_are_left_out_wherever_they_stand) {
    std::vector<Box> boxes = random_boxes(200000, 9);
    std::size_t usable = boxes.size();
    for (std::size_t i = 0; i < boxes.size(); i += 7) {
        if (i / 65536 % 2 == 1) continue;
        boxes[i].lower.y = i % 2 == 0 ? std::nanf("") : std::numeric_limits<float>::infinity();
        --usable;
    }
    MortonGrains first;
    for (const int threads : {1, 5}) {
        const ThreadLimit limit(threads);
        check_grains(build_grain_bvh(boxes), boxes, usable, 4);
        const MortonGrains grains = morton_grains(boxes, 32);
        if (threads == 1) first = grains;
        EXPECT_EQ(grains.order, first.order);
    }
}

TEST(GrainBvh, costs_little_more_than_the_heuristic_over_all_boxes_and_much_less_than_halving) {
    // Dense in the middle, sparse around it.
    std::vector<Box> boxes = random_boxes(20000, 3);
    for (const Box& box : random_boxes(30000, 8, 0.2f)) boxes.push_back(box);
    const glm::vec3 whole(21);
    const double fast = cost(build_grain_bvh(boxes), whole);
    EXPECT_LT(fast, 1.3 * cost(build_split_bvh(boxes, {}), whole));
    EXPECT_LT(fast, 0.9 * cost(build_bvh(boxes, {.method = BvhMethod::median}), whole));
}

TEST(GrainBvh, a_small_thing_in_a_large_scene_is_sorted_by_a_curve_of_its_own) {
    std::vector<Box> boxes = random_boxes(20000, 4, 0.001f);
    const glm::vec3 small(0.0021f);
    const double alone = cost(build_grain_bvh(boxes), small);
    boxes.push_back({glm::vec3(-1e4f), glm::vec3(-1e4f + 1)});
    boxes.push_back({glm::vec3(1e4f), glm::vec3(1e4f + 1)});
    const Bvh tree = build_grain_bvh(boxes);
    check_grains(tree, boxes, boxes.size(), 4);
    EXPECT_LT(cost(tree, small), 1.1 * alone);
}

TEST(GrainBvh, boxes_in_one_place_and_far_out_and_of_no_size_are_divided) {
    const std::vector<Box> same(10000, Box{glm::vec3(1), glm::vec3(2)});
    check_grains(build_grain_bvh(same), same, same.size(), 4);
    std::vector<Box> extreme = random_boxes(3000, 5);
    for (std::size_t i = 0; i < extreme.size(); ++i) {
        const float scale = i % 3 == 0 ? 3e37f : i % 3 == 1 ? 1e-38f : 1.0f;
        extreme[i].lower *= scale;
        extreme[i].upper *= scale;
    }
    check_grains(build_grain_bvh(extreme), extreme, extreme.size(), 4);
    check(build_split_bvh(extreme, {}), extreme, extreme.size(), 4, 0);
}

TEST(GrainBvh, boxes_that_are_not_finite_or_inverted_are_left_out) {
    const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
    std::vector<Box> boxes = random_boxes(1000, 6);
    boxes[10].lower.x = nan;
    boxes[20].upper.z = nan;
    boxes[30].upper.y = inf;
    boxes[40].lower.y = -inf;
    boxes[50] = {glm::vec3(1), glm::vec3(-1)};
    check_grains(build_grain_bvh(boxes), boxes, 995, 4);
    check_grains(build_grain_bvh(std::vector<Box>(7, Box{glm::vec3(nan), glm::vec3(nan)})), std::vector<Box>(7), 0, 4);
}

TEST(SplitBvh, every_box_lies_in_one_leaf_and_in_all_its_ancestors) {
    for (const std::size_t count : {1, 2, 5, 33, 1000, 70000})
        for (const std::uint32_t leaf : {1u, 4u}) {
            const std::vector<Box> boxes = random_boxes(count, 9);
            check(build_split_bvh(boxes, {.max_leaf = leaf, .min_leaf = leaf}), boxes, count, leaf, 0);
        }
}

std::vector<kernels::Triangle> random_triangles(std::size_t count, std::uint32_t seed) {
    std::vector<kernels::Triangle> triangles;
    for (const Box& box : random_boxes(count, seed))
        triangles.push_back(
            {box.lower, {box.upper.x, box.lower.y, box.upper.z}, {box.lower.x, box.upper.y, box.lower.z}});
    return triangles;
}

// What a walk over all of a wide hierarchy meets.
struct Walked {
    std::uint32_t nodes = 0, blocks = 0, depth = 0;
    double cost = 0;           // the areas of nodes and of blocks, the root's too
    std::vector<int> held;     // how often blocks name each triangle
    std::size_t outside = 0;   // vertices outside of a child's box, and boxes outside of their parents'
    std::size_t disorder = 0;  // children with more area for each block below them than the one before
};

// Of the node at a unit; returns how many blocks are below it.
std::uint32_t walk(const WideBvh& tree, std::uint32_t unit, const Box& box, std::uint32_t depth, Walked& out) {
    const auto inside = [](const Box& outer, const Box& inner) {
        return glm::all(glm::lessThanEqual(outer.lower, inner.lower)) &&
               glm::all(glm::lessThanEqual(inner.upper, outer.upper));
    };
    ++out.nodes;
    out.depth = std::max(out.depth, depth);
    out.cost += area_of(box.upper - box.lower);
    std::uint32_t below = 0;
    double promise = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < wide_width; ++i) {
        const kernels::WideUnit* const node = &tree.units[unit];
        const auto reference = std::bit_cast<std::uint32_t>(node[6].lanes[i]);
        if (reference == 0) continue;
        Box child;
        for (int axis = 0; axis < 3; ++axis) {
            child.lower[axis] = node[2 * axis].lanes[i];
            child.upper[axis] = node[2 * axis + 1].lanes[i];
        }
        out.outside += !inside(box, child);
        const std::uint32_t blocks = reference >> 28, first = reference & 0x0fffffffu;
        const std::uint32_t blocks_below = blocks == 0 ? walk(tree, first, child, depth + 1, out) : blocks;
        const double area = area_of(child.upper - child.lower);
        out.disorder += area / blocks_below > 1.0001 * promise;
        promise = area / blocks_below;
        below += blocks_below;
        out.cost += area * blocks;
        out.blocks += blocks;
        for (std::uint32_t b = 0; b < blocks; ++b) {
            const float* const rows = tree.units[first + b * kernels::WIDE_BLOCK_UNITS].lanes;
            std::vector<std::uint32_t> named;
            for (std::uint32_t lane = 0; lane < wide_block; ++lane) {
                named.push_back(std::bit_cast<std::uint32_t>(rows[9 * wide_block + lane]));
                for (std::uint32_t v = 0; v < 3; ++v) {
                    glm::vec3 p;
                    for (std::uint32_t axis = 0; axis < 3; ++axis)
                        p[int(axis)] = rows[(3 * v + axis) * wide_block + lane];
                    out.outside += !inside(child, {p, p});
                }
            }
            named.erase(std::unique(named.begin(), named.end()), named.end());  // the last stands in idle lanes too
            for (const std::uint32_t triangle : named) ++out.held.at(triangle);
        }
    }
    return below;
}

std::vector<Box> boxes_of(const std::vector<kernels::Triangle>& triangles) {
    std::vector<Box> boxes;
    for (const kernels::Triangle& t : triangles)
        boxes.push_back({glm::min(t.a, glm::min(t.b, t.c)), glm::max(t.a, glm::max(t.b, t.c))});
    return boxes;
}

// A few large triangles among many small ones.
std::vector<kernels::Triangle> triangles_of_all_sizes(std::size_t count, std::uint32_t seed) {
    std::vector<kernels::Triangle> triangles = random_triangles(count, seed);
    std::mt19937 engine(seed);
    for (kernels::Triangle& t : triangles) {
        const float size = std::pow(10.0f, std::uniform_real_distribution<float>(-3, 0.5f)(engine));
        t.b = t.a + (t.b - t.a) * size;
        t.c = t.a + (t.c - t.a) * size;
    }
    return triangles;
}

// Of a ball with bumps, `rows` of it from pole to pole and twice as many around.
std::vector<kernels::Triangle> bumpy_ball(int rows) {
    const auto point = [&](int row, int column) {
        const float v = 3.14159265f * float(row) / float(rows), u = 3.14159265f * float(column) / float(rows);
        return (3 + std::sin(7 * u) * std::sin(11 * v)) *
               glm::vec3(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), std::cos(v));
    };
    std::vector<kernels::Triangle> triangles;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < 2 * rows; ++column) {
            const glm::vec3 a = point(row, column), b = point(row + 1, column), c = point(row + 1, column + 1),
                            d = point(row, column + 1);
            triangles.push_back({a, b, c});
            triangles.push_back({a, c, d});
        }
    return triangles;
}

// Whose centres all lie on a line.
std::vector<kernels::Triangle> triangles_along_a_line(std::size_t count) {
    std::vector<kernels::Triangle> triangles = random_triangles(count, 14);
    float x = 0;
    for (kernels::Triangle& t : triangles) {
        const Box box = {glm::min(t.a, glm::min(t.b, t.c)), glm::max(t.a, glm::max(t.b, t.c))};
        const glm::vec3 to = glm::vec3(x += 0.01f, 0, 0) - 0.5f * (box.lower + box.upper);
        t = {t.a + to, t.b + to, t.c + to};
    }
    return triangles;
}

double planned_cost(const std::vector<kernels::Triangle>& triangles) {
    return collapse_bvh(build_grain_bvh(boxes_of(triangles)), triangles).statistics.sah_cost;
}

Walked check_wide_grains(const std::vector<kernels::Triangle>& triangles) {
    Box whole = {glm::vec3(1e30f), glm::vec3(-1e30f)};
    for (const Box& box : boxes_of(triangles))
        whole = {glm::min(whole.lower, box.lower), glm::max(whole.upper, box.upper)};
    const WideBvh wide = build_wide_grains(triangles);
    Walked walked;
    walked.held.resize(triangles.size());
    walk(wide, 0, whole, 0, walked);
    EXPECT_EQ(std::count(walked.held.begin(), walked.held.end(), 1), std::ptrdiff_t(triangles.size()));
    EXPECT_EQ(walked.outside, 0u);
    EXPECT_EQ(walked.disorder, 0u);
    EXPECT_EQ(walked.nodes, wide.statistics.node_count);
    EXPECT_EQ(walked.blocks, wide.statistics.block_count);
    EXPECT_EQ(walked.depth, wide.statistics.depth);
    EXPECT_EQ(wide.statistics.triangle_count, triangles.size());
    EXPECT_EQ(wide.units.size(), wide.statistics.node_count * kernels::WIDE_NODE_UNITS +
                                     wide.statistics.block_count * kernels::WIDE_BLOCK_UNITS);
    // A root with a leaf alone is not counted: a ray that meets its box is at the leaf.
    const bool leaf_alone = walked.nodes == 1 && std::bit_cast<std::uint32_t>(wide.units[6].lanes[1]) == 0;
    EXPECT_NEAR(wide.statistics.sah_cost, walked.cost / area_of(whole.upper - whole.lower) - (leaf_alone ? 1 : 0),
                1e-3 * wide.statistics.sah_cost);
    return walked;
}

TEST(WideGrains, hold_every_triangle_once_inside_of_all_boxes_above_and_cost_what_they_say) {
    for (const std::size_t count : {1, 3, 4, 5, 8, 9, 17, 32, 33, 40, 70, 1000, 5000, 70000}) {
        SCOPED_TRACE(count);
        check_wide_grains(random_triangles(count, 10));
        check_wide_grains(triangles_of_all_sizes(count, 10));
        check_wide_grains(triangles_along_a_line(count));
    }
    for (const int rows : {5, 20, 40, 90, 130}) {
        SCOPED_TRACE(rows);
        check_wide_grains(bumpy_ball(rows));
    }
    EXPECT_TRUE(build_wide_grains({}).units.empty());
}

// Three nodes that are ready, of forty that might have been, and one above them: the others' places are not kept.
TEST(WideParts, nodes_move_to_the_places_of_those_that_are_not_there) {
    std::vector<kernels::Triangle> triangles;
    for (int i = 0; i < 24; ++i) {
        const auto x = float(i);
        triangles.push_back({{x, 0, 0}, {x + 0.5f, 1, 0}, {x, 0, 1}});
    }
    const std::vector<Box> boxes = boxes_of(triangles);
    const auto hull = [&](std::size_t begin, std::size_t end) {
        kernels::BvhNode node = {boxes[begin].lower, 0, boxes[begin].upper, 0};
        for (std::size_t i = begin; i < end; ++i) {
            node.lower = glm::min(node.lower, boxes[i].lower);
            node.upper = glm::max(node.upper, boxes[i].upper);
        }
        return node;
    };
    WideParts parts(6, 40);
    std::vector<WideReady> ready(40, WideReady{0, 0});
    std::vector<kernels::BvhNode> leaves;
    for (const std::uint32_t number : {5u, 20u, 39u}) {
        const std::uint32_t first = 2 * std::uint32_t(leaves.size());
        std::array<kernels::BvhNode, 2> children;
        std::array<WideChild, 2> named;
        for (std::uint32_t i = 0; i < 2; ++i) {
            std::array<std::uint32_t, wide_block> indices;
            for (std::uint32_t k = 0; k < wide_block; ++k) indices[k] = wide_block * (first + i) + k;
            write_wide_block(triangles, indices, parts.block(first + i)->lanes);
            children[i] = hull(indices[0], indices[3] + 1);
            named[i] = {&children[i], WideParts::block_reference(first + i, 1)};
        }
        write_wide_node(named, parts.ready(number));
        leaves.push_back(hull(wide_block * first, wide_block * (first + 2)));
        leaves.back().first = number;
        leaves.back().count = wide_ready;
        ready[number] = {3, 2};
    }
    kernels::BvhNode root = hull(0, 24), right = hull(8, 24);
    root.first = 1;
    right.first = 3;
    const std::vector<kernels::BvhNode> binary = {root, leaves[0], right, leaves[1], leaves[2]};
    const WideBvh wide = collapse_parts(binary, std::move(parts), ready);
    Walked walked;
    walked.held.resize(triangles.size());
    walk(wide, 0, {root.lower, root.upper}, 0, walked);
    EXPECT_EQ(std::count(walked.held.begin(), walked.held.end(), 1), 24);
    EXPECT_EQ(walked.outside, 0u);
    EXPECT_EQ(walked.nodes, 4u);
    EXPECT_EQ(wide.statistics.node_count, 4u);
    EXPECT_EQ(wide.statistics.block_count, 6u);
    EXPECT_EQ(wide.statistics.depth, 1u);
    EXPECT_EQ(wide.units.size(), 4 * kernels::WIDE_NODE_UNITS + 6 * kernels::WIDE_BLOCK_UNITS);
}

TEST(WideGrains, of_few_cost_what_the_best_hierarchy_over_the_same_binary_tree_costs) {
    for (const std::size_t count : {1, 8, 33, 40, 70, 500, 2500}) {
        const std::vector<kernels::Triangle> triangles = random_triangles(count, 12);
        const double best = planned_cost(triangles);
        EXPECT_NEAR(build_wide_grains(triangles).statistics.sah_cost, best, 0.005 * best);
    }
}

// What is decided before the whole is known costs little, whether triangles are of one size or of many. That it is
// decided is seen by the nodes, which are more.
TEST(WideGrains, cost_little_more_than_the_best_hierarchy_over_the_same_binary_tree) {
    for (const std::vector<kernels::Triangle>& triangles :
         {bumpy_ball(130), triangles_of_all_sizes(70000, 12), triangles_along_a_line(30000)}) {
        const WideBvh wide = build_wide_grains(triangles),
                      planned = collapse_bvh(build_grain_bvh(boxes_of(triangles)), triangles);
        EXPECT_LT(wide.statistics.sah_cost, 1.09 * planned.statistics.sah_cost);
        EXPECT_GT(wide.statistics.sah_cost, 1.0001 * planned.statistics.sah_cost);
        EXPECT_LT(wide.statistics.node_count, planned.statistics.node_count * 5 / 4);
        EXPECT_GT(wide.statistics.node_count, planned.statistics.node_count);
    }
}

// What it costs more than planned, times the root's area, is as much with something large and far around.
TEST(WideGrains, do_not_lose_by_what_is_large_and_far) {
    const std::vector<kernels::Triangle> ball = bumpy_ball(100);
    const auto excess = [](const std::vector<kernels::Triangle>& triangles) {
        Box whole = boxes_of(triangles)[0];
        for (const Box& box : boxes_of(triangles))
            whole = {glm::min(whole.lower, box.lower), glm::max(whole.upper, box.upper)};
        return (build_wide_grains(triangles).statistics.sah_cost - planned_cost(triangles)) *
               area_of(whole.upper - whole.lower);
    };
    std::vector<kernels::Triangle> outdoors = ball;
    outdoors.push_back({glm::vec3(-80, -80, -5), glm::vec3(80, -80, -4), glm::vec3(0, 80, 60)});
    EXPECT_GT(excess(ball), 0);
    EXPECT_LT(excess(outdoors), 2 * excess(ball));
}

// Boxes beyond what floats hold, and of no size: costs are infinite or nothing, and all is there.
TEST(WideGrains, hold_every_triangle_where_areas_are_infinite_or_nothing) {
    for (const float scale : {3e37f, 1e-38f, 0.0f}) {
        std::vector<kernels::Triangle> triangles = random_triangles(5000, 13);
        for (std::size_t i = 0; i < triangles.size(); ++i)
            for (glm::vec3* const p : {&triangles[i].a, &triangles[i].b, &triangles[i].c})
                *p *= i % 3 == 0 ? glm::vec3(scale, 0, scale) : glm::vec3(scale);
        const WideBvh wide = build_wide_grains(triangles);
        Walked walked;
        walked.held.resize(triangles.size());
        walk(wide, 0, {glm::vec3(-3.4e38f), glm::vec3(3.4e38f)}, 0, walked);
        for (const int times : walked.held) ASSERT_EQ(times, 1);
        EXPECT_EQ(walked.outside, 0u);
    }
}

TEST(WideGrains, the_tree_does_not_depend_on_the_number_of_threads) {
    const std::vector<kernels::Triangle> triangles = bumpy_ball(220);
    WideBvh first;
    for (const int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        WideBvh tree = build_wide_grains(triangles);
        if (threads == 1) first = std::move(tree);
        else {
            ASSERT_EQ(tree.units.size(), first.units.size());
            EXPECT_EQ(std::memcmp(tree.units.data(), first.units.data(), tree.units.size() * sizeof(tree.units[0])), 0);
        }
    }
}

TEST(SignedBounds, are_usable_where_both_corners_are_finite_and_ordered) {
    const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity(),
                most = std::numeric_limits<float>::max();
    const auto usable = [](const glm::vec3& lower, const glm::vec3& upper) {
        return is_usable(signed_bounds(Box{lower, upper}));
    };
    EXPECT_TRUE(usable(glm::vec3(-most), glm::vec3(most)));
    EXPECT_TRUE(usable(glm::vec3(1), glm::vec3(1)));
    for (int axis = 0; axis < 3; ++axis)
        for (const float bad : {nan, inf, -inf}) {
            glm::vec3 p(0);
            p[axis] = bad;
            EXPECT_FALSE(usable(p, glm::vec3(1)));
            EXPECT_FALSE(usable(glm::vec3(-1), p));
        }
    EXPECT_FALSE(usable(glm::vec3(0), glm::vec3(1, -1, 1)));
}

TEST(MortonGrains, follow_each_other_and_hold_no_more_than_asked_for) {
    const std::vector<Box> boxes = random_boxes(30000, 7);
    for (const std::uint32_t most : {1u, 16u, 100u}) {
        const MortonGrains found = morton_grains(boxes, most);
        std::uint32_t next = 0;
        for (const MortonGrain& grain : found.grains) {
            ASSERT_EQ(grain.begin, next);
            ASSERT_GT(grain.end, grain.begin);
            ASSERT_LE(grain.end - grain.begin, most);
            next = grain.end;
        }
        EXPECT_EQ(next, boxes.size());
    }
}

}  // namespace
}  // namespace spinel::grain_bvh_test
