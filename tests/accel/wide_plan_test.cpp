// The plan of a wide hierarchy against the same choice made by plain recursion in doubles.

#include "accel/wide_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace spinel::wide_plan_test {
namespace {

constexpr std::uint32_t block = 4;  // primitives

std::uint32_t blocks_for(std::uint32_t, std::uint32_t count) { return (count + block - 1) / block; }

// A random tree over boxes of random sizes; its primitives stand in the order of the leaves, but for the children that
// were swapped. Some leaves are nodes that are ready.
class RandomTree {
  public:
    RandomTree(std::uint32_t seed, std::uint32_t leaf_count, float extreme, float ready_part)
        : engine_(seed), extreme_(extreme), ready_part_(ready_part) {
        tree.nodes.resize(1);
        grow(0, leaf_count);
        for (std::uint32_t i = 0; i < primitives_; ++i) tree.order.push_back(i);
    }

    Bvh tree;
    std::vector<WideReady> ready;

    WidePlan plan(const WideBvhOptions& options) const {
        return plan_wide_bvh(tree.nodes, options, {block, blocks_for, ready});
    }

  private:
    float random(float lower, float upper) { return std::uniform_real_distribution<float>(lower, upper)(engine_); }

    void grow(std::uint32_t n, std::uint32_t leaf_count) {
        kernels::BvhNode node = {};
        if (leaf_count == 1) {
            if (random(0, 1) < ready_part_) {
                node.count = wide_ready;
                node.first = std::uint32_t(ready.size());
                ready.push_back({random(0, 10), 1 + std::uint32_t(random(0, 8))});
            } else {
                node.count = 1 + std::uint32_t(random(0, 3.99f));
                node.first = primitives_;
                primitives_ += node.count;
            }
            for (int axis = 0; axis < 3; ++axis) {
                const float size = random(0, 1) < 0.2f ? 0.0f : random(0, 1) < 0.2f ? extreme_ : 1.0f;
                const float a = random(-size, size), b = random(-size, size);
                node.lower[axis] = std::min(a, b);
                node.upper[axis] = std::max(a, b);
            }
            tree.nodes[n] = node;
            return;
        }
        node.first = std::uint32_t(tree.nodes.size());
        tree.nodes.resize(tree.nodes.size() + 2);
        const std::uint32_t left = 1 + std::uint32_t(random(0, float(leaf_count - 1) - 0.01f));
        const bool swapped = random(0, 1) < 0.2f;
        if (swapped) grow(node.first + 1, leaf_count - left);
        grow(node.first, left);
        if (!swapped) grow(node.first + 1, leaf_count - left);
        const kernels::BvhNode &a = tree.nodes[node.first], &b = tree.nodes[node.first + 1];
        node.lower = glm::min(a.lower, b.lower);
        node.upper = glm::max(a.upper, b.upper);
        tree.nodes[n] = node;
    }

    std::mt19937 engine_;
    float extreme_, ready_part_;
    std::uint32_t primitives_ = 0;
};

double area(const kernels::BvhNode& n) {
    const glm::dvec3 e = glm::dvec3(n.upper) - glm::dvec3(n.lower);
    return e.x * e.y + e.y * e.z + e.z * e.x;
}

struct Twin {
    std::uint32_t first, end;     // of its primitives; 0, 0: they do not follow each other
    std::uint32_t count;          // of them
    std::array<double, 9> costs;  // of standing for it as at most i children
};

Twin twin(const RandomTree& random, const WideBvhOptions& options, std::uint32_t n) {
    const kernels::BvhNode& node = random.tree.nodes[n];
    const auto as_leaf = [&](std::uint32_t count) {
        return area(node) * double(options.block_cost) * blocks_for(0, count);
    };
    Twin out = {};
    if (node.count == wide_ready) {
        const WideReady& ready = random.ready.at(node.first);
        out.count = ready.primitives;
        out.costs.fill(double(ready.cost));
        return out;
    }
    if (node.count > 0) {
        out = {node.first, node.first + node.count, node.count, {}};
        out.costs.fill(as_leaf(node.count));
        return out;
    }
    const Twin left = twin(random, options, node.first), right = twin(random, options, node.first + 1);
    out.count = left.count + right.count;
    if (left.end > 0 && right.end > 0) {
        if (left.end == right.first) out.first = left.first, out.end = right.end;
        if (right.end == left.first) out.first = right.first, out.end = left.end;
    }
    const auto split = [&](std::size_t children) {
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 1; k < children; ++k) least = std::min(least, left.costs[k] + right.costs[children - k]);
        return least;
    };
    out.costs[1] = area(node) * double(options.node_cost) + split(8);
    if (out.end > 0 && blocks_for(0, out.count) <= options.max_leaf_blocks)
        out.costs[1] = std::min(out.costs[1], as_leaf(out.count));
    for (std::size_t i = 2; i <= 8; ++i) out.costs[i] = std::min(out.costs[1], split(i));
    return out;
}

// Each primitive in one leaf, each node but the root below one; what they cost together.
double check(const RandomTree& random, const WideBvhOptions& options, const WidePlan& plan) {
    const Bvh& tree = random.tree;
    std::vector<int> held(tree.order.size()), met(plan.nodes.size()), met_ready(random.ready.size());
    double sum = plan.nodes.size() > 1 || plan.nodes[0].count > 1 || plan.nodes[0].counts[0] == 0
                     ? area(tree.nodes[0]) * double(options.node_cost)
                     : 0;
    for (const WidePlanNode& node : plan.nodes) {
        EXPECT_GE(node.count, 1u);
        EXPECT_LE(node.count, wide_width);
        for (std::uint32_t i = 0; i < std::min(node.count, wide_width); ++i) {
            const kernels::BvhNode& child = tree.nodes.at(node.children[i]);
            if (node.counts[i] == wide_ready) {
                ++met_ready.at(node.firsts[i]);
                sum += double(random.ready[node.firsts[i]].cost);
                continue;
            }
            if (node.counts[i] == 0) {
                ++met.at(node.nodes[i]);
                sum += area(child) * double(options.node_cost);
                continue;
            }
            const std::uint32_t blocks = blocks_for(node.firsts[i], node.counts[i]);
            EXPECT_LE(blocks, options.max_leaf_blocks);
            sum += area(child) * double(options.block_cost) * blocks;
            for (std::uint32_t k = 0; k < node.counts[i]; ++k) ++held.at(node.firsts[i] + k);
        }
    }
    for (const int times : held) EXPECT_EQ(times, 1);
    for (std::size_t n = 0; n < met.size(); ++n) EXPECT_EQ(met[n], n > 0 ? 1 : 0);
    for (const int times : met_ready) EXPECT_EQ(times, 1);
    std::size_t primitives = tree.order.size();
    for (const WideReady& ready : random.ready) primitives += ready.primitives;
    EXPECT_EQ(plan.triangle_count, primitives);
    return sum / area(tree.nodes[0]);
}

TEST(WidePlan, costs_what_the_best_of_all_plans_costs) {
    for (std::uint32_t seed = 0; seed < 600; ++seed) {
        const RandomTree random(seed, 1 + seed % 40, 10, seed % 3 == 0 ? 0.4f : 0.0f);
        const WideBvhOptions options{1 + seed % 3, seed % 2 == 0 ? 1.0f : 0.3f, 1.0f};
        SCOPED_TRACE(seed);
        const kernels::BvhNode& root = random.tree.nodes[0];
        if (root.count == wide_ready || area(root) == 0) continue;  // no plan, or no cost of it, is wanted
        const WidePlan plan = random.plan(options);
        const double least = twin(random, options, 0).costs[1] / area(root);
        // Each level drops three bits of a float.
        EXPECT_NEAR(plan.sah_cost, least, 2e-5 * least);
        EXPECT_NEAR(check(random, options, plan), least, 2e-5 * least);
    }
}

TEST(WidePlan, holds_every_primitive_where_areas_are_beyond_what_floats_hold) {
    for (std::uint32_t seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE(seed);
        const RandomTree random(seed, 2 + seed % 40, 3e38f, 0.2f);
        check(random, {}, random.plan({}));
    }
}

}  // namespace
}  // namespace spinel::wide_plan_test
