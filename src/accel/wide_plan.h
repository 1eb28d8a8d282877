#pragma once
// Which nodes of a binary hierarchy become children of one eight-wide node, and which subtrees become leaves: chosen
// for the least expected cost by dynamic programming over the binary tree. Ylitie, Karras, Laine, "Efficient Incoherent
// Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 2.2. How nodes and leaves are stored is for
// those who ask (wide_bvh.h, compact_bvh.h).

#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "accel/bvh_builder.h"

namespace spinel {

constexpr std::uint32_t wide_width = 8;

struct WideBvhOptions {
    std::uint32_t max_leaf_blocks = 2;  // of triangles that are tested at once, at most 15
    float node_cost = 1.0f;             // of eight boxes at once …
    float block_cost = 1.0f;            // … and of a block
};

struct WidePlanNode {
    std::uint32_t count;                             // of children
    std::array<std::uint32_t, wide_width> children;  // in the binary tree
    std::array<std::uint32_t, wide_width> firsts;    // of leaves, primitives in the order of the binary tree …
    std::array<std::uint32_t, wide_width> counts;    // … and how many (wide_ready: which node stands); 0: a node …
    std::array<std::uint32_t, wide_width> nodes;     // … which is this one of the plan
};

struct WidePlan {
    std::vector<WidePlanNode> nodes;  // in depth-first order, the root first
    double sah_cost = 0;  // expected cost of a ray that meets the root's box, in units of the options' costs
    std::uint32_t depth = 0;
    std::uint32_t triangle_count = 0;  // in leaves, those that stand in several of them counted as often
};

// A wide node that stands before the plan is made, in place of a subtree of the binary tree: a leaf of it whose `count`
// is `wide_ready`, and whose `first` says which it is.
struct WideReady {
    float cost;  // of a ray that meets its box, times half the area of that, in units of the options' costs
    std::uint32_t primitives;  // below it
};
constexpr std::uint32_t wide_ready = ~0u;

// How many blocks the primitives [first, first + count) of the binary tree's order take. Asked for each of its nodes
// whose primitives are no more than `most` for each block that a leaf may have.
struct WideLeaves {
    std::uint32_t most;
    std::function<std::uint32_t(std::uint32_t first, std::uint32_t count)> blocks;
    std::span<const WideReady> ready = {};
};

// Half the area of a node's box, by which costs are weighted. Infinite for boxes beyond what floats hold, flat ones
// (∞ · 0) too: costs have to order.
float cost_area(const kernels::BvhNode& node);

// Walks that ask for any hit take children in the order in which they stand: first those with the largest area for each
// triangle, where one is met soonest. (Measured against the binary tree's order: 1.1 to 1.9 times as fast in rooms.)
template <class Child>
void sort_by_promise(std::span<Child> children, const std::array<float, wide_width>& promises) {
    // Positive floats order like whole numbers; the last bits tell those apart that are as large.
    std::array<std::uint32_t, wide_width> keys{}, ranks{};
    for (std::uint32_t i = 0; i < children.size(); ++i)
        keys[i] = (std::bit_cast<std::uint32_t>(promises[i]) & ~7u) | (wide_width - 1 - i);
    for (const std::uint32_t key : keys)
        for (std::uint32_t i = 0; i < wide_width; ++i) ranks[i] += key > keys[i];
    std::array<Child, wide_width> sorted;
    for (std::uint32_t i = 0; i < children.size(); ++i) sorted[ranks[i]] = children[i];
    for (std::uint32_t i = 0; i < children.size(); ++i) children[i] = sorted[i];
}

// Of a tree that is not empty. Leaves are made of subtrees whose primitives follow each other in its order. Children
// whose boxes have the largest area for each triangle stand first.
WidePlan plan_wide_bvh(std::span<const kernels::BvhNode> binary, const WideBvhOptions& options,
                       const WideLeaves& leaves);

}  // namespace spinel
