#pragma once
// Binary trees in the making: every leaf one primitive, nodes anywhere, linked both ways; what is built from below or
// rearranged is this before it becomes a Bvh.

#include "accel/bvh_bounds.h"

namespace spinel::bvh {

struct PairTree {
    static constexpr std::uint32_t none = ~0u;
    struct Node {
        Bounds bounds;
        std::uint32_t parent = none;
        std::uint32_t left = none;   // of a leaf: the primitive, by its place among those given
        std::uint32_t right = none;  // none: a leaf
        bool is_leaf() const { return right == none; }
    };
    std::vector<Node> nodes;
    std::uint32_t root = none;
};

// Of a tree whose leaves hold one primitive each; leaves name places in its order.
PairTree pair_tree(const Bvh& bvh);

// Moves nodes to where they cost less, until that gains little: bvh_reinsertion.cpp.
void optimize(PairTree& tree);

// Subtrees become leaves where that is cheaper. Below where it would get too deep, halves by number take the tree's
// place.
Bvh finish(const PairTree& tree, const std::vector<Primitive>& primitives, const BvhOptions& options);

}  // namespace spinel::bvh
