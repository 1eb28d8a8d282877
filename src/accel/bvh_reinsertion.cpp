// The binned tree made better: nodes are taken out and put back where they enlarge the others the least. Bittner,
// Hapala, Havran, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies", CGF 32(1), 2013; the search for
// the best place, from where a node stood, is Meister and Bittner's, "Parallel Reinsertion for Bounding Volume
// Hierarchy Optimization", CGF 37(2), 2018. One node after the other, so that the tree depends on the boxes alone.

#include <algorithm>
#include <numeric>

#include "accel/pair_tree.h"

namespace spinel::bvh {
namespace {

using Node = PairTree::Node;

constexpr int most_rounds = 12;
constexpr double least_gain = 0.005;  // of a round, as a part of the tree's cost
constexpr int most_candidates = 300;  // for one node: where everything overlaps, all places would be looked at

Bounds both(const Bounds& a, const Bounds& b) {
    Bounds c = a;
    c.extend(b);
    return c;
}

class Optimizer {
  public:
    explicit Optimizer(PairTree& tree) : tree_(tree) {}

    // In each round every node once, the large ones first: what is wrong with them costs the most.
    void run() {
        std::vector<std::uint32_t> nodes(tree_.nodes.size());
        std::iota(nodes.begin(), nodes.end(), 0u);
        double cost = interior_area();
        for (int round = 0; round < most_rounds; ++round) {
            std::vector<float> area(tree_.nodes.size());
            for (std::uint32_t i = 0; i < area.size(); ++i) area[i] = at(i).bounds.half_area();
            std::sort(nodes.begin(), nodes.end(),
                      [&](std::uint32_t a, std::uint32_t b) { return area[a] != area[b] ? area[a] > area[b] : a < b; });
            for (const std::uint32_t node : nodes) reinsert(node);
            const double now = interior_area();
            if (!(cost - now > least_gain * cost)) return;
            cost = now;
        }
    }

  private:
    Node& at(std::uint32_t i) { return tree_.nodes[i]; }

    double interior_area() {
        double sum = 0;
        for (const Node& node : tree_.nodes)
            if (!node.is_leaf()) sum += double(node.bounds.half_area());
        return sum;
    }

    std::uint32_t sibling(std::uint32_t i) {
        const Node& parent = at(at(i).parent);
        return parent.left == i ? parent.right : parent.left;
    }

    // Up from where the node stands, and from each step down into the other subtrees, as long as more may be saved than
    // was found so far. What is saved above is what ancestors shrink by without the node.
    void reinsert(std::uint32_t node) {
        const std::uint32_t parent = at(node).parent;
        if (parent == PairTree::none || at(parent).parent == PairTree::none) return;
        const Bounds box = at(node).bounds;
        const float area = box.half_area();
        float best_gain = 0;
        std::uint32_t best = PairTree::none;
        float saved = at(parent).bounds.half_area();  // the parent goes, and its sibling takes its place
        const std::uint32_t rest = sibling(node);
        Bounds shrunk = at(rest).bounds;  // of what the pivot holds without the node
        std::uint32_t pivot = parent, other = rest;
        for (int candidates = 0;;) {
            stack_.assign(1, {saved, other});
            for (; !stack_.empty() && candidates < most_candidates; ++candidates) {
                const Candidate c = stack_.back();
                stack_.pop_back();
                if (!(c.gain - area > best_gain)) continue;  // also where areas are beyond what floats hold
                const float merged = both(at(c.node).bounds, box).half_area();
                if (c.gain - merged > best_gain && c.node != rest) {
                    best_gain = c.gain - merged;
                    best = c.node;
                }
                if (at(c.node).is_leaf()) continue;
                const float below = c.gain + at(c.node).bounds.half_area() - merged;
                if (!(below - area > best_gain)) continue;
                stack_.push_back({below, at(c.node).right});
                stack_.push_back({below, at(c.node).left});
            }
            // Whoever holds the other subtree as well as this one holds the node in either; beyond it shrinks.
            if (pivot != parent) {
                shrunk.extend(at(other).bounds);
                saved += at(pivot).bounds.half_area() - shrunk.half_area();
            }
            if (at(pivot).parent == PairTree::none) break;
            other = sibling(pivot);
            pivot = at(pivot).parent;
        }
        if (best != PairTree::none) move(node, best);
    }

    void move(std::uint32_t node, std::uint32_t to) {
        const std::uint32_t parent = at(node).parent, rest = sibling(node), above = at(parent).parent;
        (at(above).left == parent ? at(above).left : at(above).right) = rest;
        at(rest).parent = above;
        // The parent's record is the new node, between `to` and its parent.
        const std::uint32_t target = at(to).parent;
        (at(target).left == to ? at(target).left : at(target).right) = parent;
        at(parent) = {both(at(to).bounds, at(node).bounds), target, to, node};
        at(to).parent = at(node).parent = parent;
        refit(above);
        refit(target);
    }

    void refit(std::uint32_t i) {
        for (; i != PairTree::none; i = at(i).parent)
            at(i).bounds = both(at(at(i).left).bounds, at(at(i).right).bounds);
    }

    struct Candidate {
        float gain;  // of going on here, before the new node's own area
        std::uint32_t node;
    };
    PairTree& tree_;
    std::vector<Candidate> stack_;
};

}  // namespace

void optimize(PairTree& tree) { Optimizer(tree).run(); }

}  // namespace spinel::bvh
