#include "accel/wide_plan.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <limits>

#include "core/huge_pages.h"
#include "core/parallel.h"

namespace spinel {
namespace {

using kernels::BvhNode;

constexpr std::uint32_t width = wide_width;

// For i = 1 … 8 children a lane each, in the compilers' own vector types; arguments by reference alone, since how they
// are passed by value hangs on the machine.
using FloatLanes = float __attribute__((vector_size(4 * width)));
using Lanes = std::uint32_t __attribute__((vector_size(4 * width)));

// What is the cheapest way to stand for a subtree of the binary tree as at most i children of a wide node (i = 1 … 7;
// as one child: a leaf or a wide node of its own)? What it costs, wanted until the parent's is known …
class Costs {
  public:
    std::uint32_t most;  // children that it can stand for, up to 7: more are as cheap

    // i = 1 … 8, the last of no meaning.
    float operator[](std::uint32_t i) const { return costs_[width - 1 + i]; }
    void fill(float cost) { std::fill(costs_.begin() + width, costs_.end(), cost); }
    void fill(const Lanes& costs) { std::memcpy(&costs_[width], &costs, sizeof costs); }
    // Lane i: the costs of i − `less` children; of none and fewer infinite.
    void load(std::uint32_t less, FloatLanes& lanes) const { std::memcpy(&lanes, &costs_[width - less], sizeof lanes); }

    Costs() { std::fill(costs_.begin(), costs_.begin() + width, std::numeric_limits<float>::infinity()); }

  private:
    alignas(32) std::array<float, 2 * width> costs_;
};

constexpr std::uint32_t scattered = ~0u;  // primitives that do not follow each other

// … and how that is reached.
class Choice {
  public:
    std::uint32_t first;  // of the subtree's primitives in the order of leaves, or scattered …
    std::uint32_t count;  // … and how many
    float promise;        // area for each of them
    // The first of the node's children, which is read from here where nodes are met in no order; of a leaf itself.
    std::uint32_t below;

    // Of i = 2 … 8 children those that stand for the left subtree; 0, also for i = 1: one child is as cheap.
    std::uint32_t left(std::uint32_t i) const { return choices_ >> (3 * (i - 1)) & 7u; }
    void set_left(const Lanes& children) {
        Lanes bits = (children & Lanes{0, 7, 7, 7, 7, 7, 7, 7}) << Lanes{0, 3, 6, 9, 12, 15, 18, 21};
        bits |= __builtin_shufflevector(bits, bits, 4, 5, 6, 7, 0, 1, 2, 3);
        bits |= __builtin_shufflevector(bits, bits, 2, 3, 0, 1, 6, 7, 4, 5);
        choices_ |= bits[0] | bits[1];
    }
    // As one child, a leaf is the cheapest.
    bool leaf() const { return choices_ & leaf_bit; }
    void set_leaf() { choices_ |= leaf_bit; }
    // It is a node that stands already.
    bool ready() const { return choices_ & ready_bit; }
    void set_ready() { choices_ |= ready_bit; }
    void clear() { choices_ = 0; }

  private:
    static constexpr std::uint32_t leaf_bit = 1u << 31, ready_bit = 1u << 30;
    std::uint32_t choices_;
};

constexpr std::uint32_t parallel_nodes = 4096;  // in a tree that is worth tasks …
constexpr std::uint32_t parallel_depth = 6;     // … for its subtrees up to this depth

class Planner {
  public:
    Planner(std::span<const BvhNode> binary, const WideBvhOptions& options, const WideLeaves& leaves)
        : binary_(binary), options_(options), leaves_(leaves), choices_(binary.size()) {}

    WidePlan run() {
        Costs root;
        choose(0, binary_.size() < parallel_nodes ? parallel_depth : 0, root);
        place();
        const double root_area = cost_area(binary_[0]);
        out_.sah_cost = root_area > 0 ? root[1] / root_area : 0;
        return std::move(out_);
    }

  private:
    void choose(std::uint32_t n, std::uint32_t depth, Costs& out) {
        const BvhNode& node = binary_[n];
        if (node.count > 0) {
            out.fill(choose_leaf(n));
            out.most = 1;
            return;
        }
        // The least costs for each i. The number of children on the left stands in the last bits, so that the least of
        // all is found without a branch; also where areas are beyond what floats hold, costs order like whole numbers.
        Lanes least;
        if (binary_[node.first].count > 0 && binary_[node.first + 1].count > 0) {
            const float both = choose_leaf(node.first) + choose_leaf(node.first + 1);
            least = Lanes{} + ((std::bit_cast<std::uint32_t>(both) & ~7u) | 1u);
            out.most = 2;
        } else {
            Costs left, right;
            choose_both(node.first, depth, left, right);
            least = Lanes{} + ~0u;
            for (std::uint32_t k = 1; k <= left.most; ++k) {
                FloatLanes sums;
                right.load(k, sums);
                sums += left[k];
                const Lanes packed = ((Lanes)sums & ~7u) | k;
                least = packed < least ? packed : least;
            }
            out.most = std::min(left.most + right.most, width - 1);
        }
        Choice& choice = choices_[n];
        choice.clear();
        join(choices_[node.first], choices_[node.first + 1], choice);
        const float area = cost_area(node);
        choice.promise = area / float(choice.count);
        choice.below = node.first;
        float single = area * options_.node_cost + std::bit_cast<float>(least[width - 1] & ~7u);
        if (choice.first != scattered && choice.count <= options_.max_leaf_blocks * leaves_.most) {
            const std::uint32_t blocks = leaves_.blocks(choice.first, choice.count);
            const float as_leaf = area * options_.block_cost * float(blocks);
            if (blocks <= options_.max_leaf_blocks && as_leaf <= single) {
                choice.set_leaf();
                single = as_leaf;
            }
        }
        // One child may be cheaper than several. Not of the node itself, which has all eight.
        Lanes one = Lanes{} + std::bit_cast<std::uint32_t>(single), several = least & ~7u;
        several[0] = ~0u;
        out.fill(one < several ? one : several);
        one[width - 1] = ~0u;
        choice.set_left(one <= several ? Lanes{} : least);
    }

    float choose_leaf(std::uint32_t n) {
        const BvhNode& node = binary_[n];
        const float area = cost_area(node);
        Choice& choice = choices_[n];
        choice.clear();
        choice.below = n;
        if (node.count == wide_ready) {
            choice.set_ready();
            const WideReady& ready = leaves_.ready[node.first];
            choice.first = scattered;
            choice.count = ready.primitives;
            choice.promise = area / float(ready.primitives);
            return ready.cost;
        }
        choice.set_leaf();
        choice.first = node.first;
        choice.count = node.count;
        choice.promise = area / float(node.count);
        return area * options_.block_cost * float(leaves_.blocks(node.first, node.count));
    }

    void choose_both(std::uint32_t n, std::uint32_t depth, Costs& left, Costs& right) {
        if (depth >= parallel_depth) {
            choose(n, depth, left);
            choose(n + 1, depth, right);
            return;
        }
        parallel_for(2, 1, [&](std::size_t begin, std::size_t end) {
            if (begin == 0) choose(n, depth + 1, left);
            if (end == 2) choose(n + 1, depth + 1, right);
        });
    }

    // Of a subtree those below both children.
    static void join(const Choice& left, const Choice& right, Choice& out) {
        out.count = left.count + right.count;
        out.first = scattered;
        if (left.first == scattered || right.first == scattered) return;
        if (left.first + left.count == right.first) out.first = left.first;
        else if (right.first + right.count == left.first) out.first = right.first;
    }

    // The binary nodes that become the children of node n's wide node.
    std::uint32_t children_of(std::uint32_t n, std::array<std::uint32_t, width>& children) const {
        std::uint32_t count = 0;
        if (choices_[n].leaf()) {  // the root alone
            children[count++] = n;
            return count;
        }
        struct Part {
            std::uint32_t node, slots;
        };
        std::array<Part, width> stack;
        std::uint32_t size = 0;
        stack[size++] = {n, width};
        while (size > 0) {
            const Part part = stack[--size];
            const Choice& c = choices_[part.node];
            const std::uint32_t left = c.left(part.slots);
            if (left == 0) {
                children[count++] = part.node;
                continue;
            }
            assert(left < part.slots && size + 2 <= width);
            stack[size++] = {c.below + 1, part.slots - left};
            stack[size++] = {c.below, left};
        }
        return count;
    }

    void place() {
        struct Pending {
            std::uint32_t node, depth;
            std::uint32_t parent, lane;  // in the plan; the root has none
        };
        std::vector<Pending> stack{{0, 0, 0, width}};
        out_.nodes.reserve(binary_.size() / 8 + 1);
        while (!stack.empty()) {
            const Pending pending = stack.back();
            stack.pop_back();
            out_.depth = std::max(out_.depth, pending.depth);
            const auto index = std::uint32_t(out_.nodes.size());
            if (pending.lane < width) out_.nodes[pending.parent].nodes[pending.lane] = index;
            WidePlanNode& node = out_.nodes.emplace_back();
            node.count = children_of(pending.node, node.children);
            std::array<float, width> promises;
            for (std::uint32_t i = 0; i < node.count; ++i) promises[i] = choices_[node.children[i]].promise;
            sort_by_promise(std::span(node.children).first(node.count), promises);
            for (std::uint32_t i = 0; i < node.count; ++i) {
                const Choice& c = choices_[node.children[i]];
                node.firsts[i] = c.first;
                node.counts[i] = c.leaf() ? c.count : 0;
                if (c.leaf() || c.ready()) out_.triangle_count += c.count;
                if (!c.ready()) continue;
                node.firsts[i] = binary_[node.children[i]].first;
                node.counts[i] = wide_ready;
                out_.depth = std::max(out_.depth, pending.depth + 1);
            }
            for (std::uint32_t i = node.count; i-- > 0;) {
                if (node.counts[i] > 0) continue;
                stack.push_back({node.children[i], pending.depth + 1, index, i});
                __builtin_prefetch(&choices_[choices_[node.children[i]].below]);
            }
        }
    }

    std::span<const BvhNode> binary_;
    const WideBvhOptions& options_;
    const WideLeaves& leaves_;
    HugeVector<Choice> choices_;
    WidePlan out_;
};

}  // namespace

float cost_area(const BvhNode& node) {
    const glm::vec3 e = node.upper - node.lower;
    const float area = e.x * e.y + e.y * e.z + e.z * e.x;
    return area >= 0 ? area : std::numeric_limits<float>::infinity();
}

WidePlan plan_wide_bvh(std::span<const BvhNode> binary, const WideBvhOptions& options, const WideLeaves& leaves) {
    assert(options.max_leaf_blocks >= 1 && options.max_leaf_blocks <= 15);
    return Planner(binary, options, leaves).run();
}

}  // namespace spinel
