#include "accel/grain_bvh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "accel/morton_grains.h"
#include "accel/signed_bounds.h"
#include "accel/split_bvh.h"
#include "core/huge_pages.h"
#include "core/parallel.h"

namespace spinel {
namespace {

using kernels::BvhNode;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr std::uint32_t grain_most = 32;  // primitives
static_assert(grain_most <= wide_width * wide_block, "a grain has to fit into a node");
static_assert(grain_most % 4 == 0, "areas are worked out four at a time");

void prefetch(const Box& box) { __builtin_prefetch(&box); }
void prefetch(const kernels::Triangle& triangle) {
    const char* bytes = reinterpret_cast<const char*>(&triangle);
    __builtin_prefetch(bytes);
    __builtin_prefetch(bytes + sizeof triangle - 1);
}

// How many leaves hold so many primitives.
class LeafCounts {
  public:
    explicit LeafCounts(std::uint32_t leaf) {
        for (std::uint32_t i = 0; i <= grain_most; ++i) counts_[i] = (i + leaf - 1) / leaf;
    }
    std::size_t operator()(std::size_t primitives) const { return counts_[primitives]; }
    std::size_t operator()(const MortonGrain& grain) const { return counts_[grain.end - grain.begin]; }

  private:
    std::array<std::uint32_t, grain_most + 1> counts_;
};

// Divides grains into trees.
template <class Primitive>
class Divider {
  public:
    Divider(std::span<const Primitive> primitives, std::span<const std::uint32_t> order, const LeafCounts& leaves_for,
            std::uint32_t leaf)
        : primitives_(primitives), order_(order), leaves_for_(leaves_for), leaf_(leaf) {}

    // Of the boxes of a grain from where the part that is divided begins up to each of them, and from each to where it
    // ends, the hull and half its area.
    struct Scratch {
        std::array<SignedBounds, grain_most> boxes, before, from;
        alignas(16) std::array<float, grain_most> area_before, area_from;
    };

    // Primitives are wanted in another order than they stand in.
    void prefetch(const MortonGrain& grain) const {
        for (const std::uint32_t index : order_.subspan(grain.begin, grain.end - grain.begin))
            spinel::prefetch(primitives_[index]);
    }

    SignedBounds bounds(const MortonGrain& grain) const {
        SignedBounds all;
        for (const std::uint32_t index : order_.subspan(grain.begin, grain.end - grain.begin))
            all.extend(signed_bounds(primitives_[index]));
        return all;
    }

    // Nodes below the root stand from `nodes[free]` on, two for each leaf but one. Leaves, which are as few as can hold
    // the primitives, are made in order by make_leaf(where its indices begin, indices, node).
    template <class MakeLeaf>
    void divide(const MortonGrain& grain, BvhNode& root, BvhNode* nodes, std::size_t free, const MakeLeaf& make_leaf,
                Scratch& scratch) const {
        const auto indices = order_.subspan(grain.begin, grain.end - grain.begin);
        SignedBounds all;
        for (std::size_t i = 0; i < indices.size(); ++i) {
            scratch.boxes[i] = signed_bounds(primitives_[indices[i]]);
            all.extend(scratch.boxes[i]);
        }
        sweep_before(0, indices.size(), scratch);
        sweep_from(0, indices.size(), scratch);
        divide({grain.begin, 0, indices.size(), free}, all, root, nodes, make_leaf, scratch);
    }

  private:
    // What is below a node.
    struct Part {
        std::size_t place;       // where the indices of the grain begin
        std::size_t begin, end;  // of its primitives, from there on
        std::size_t free;        // where its nodes begin
    };

    // Both sweeps have been made for the part.
    template <class MakeLeaf>
    void divide(const Part& part, SignedBounds all, BvhNode& node, BvhNode* nodes, const MakeLeaf& make_leaf,
                Scratch& scratch) const {
        put_bounds(all, node);
        const auto [place, begin, end, free] = part;
        if (end - begin <= leaf_) {
            make_leaf(place + begin, order_.subspan(place + begin, end - begin), node);
            return;
        }
        node.first = std::uint32_t(free);
        node.count = 0;
        const std::size_t middle = best_cut(begin, end, scratch), leaves = leaves_for_(middle - begin);
        const SignedBounds before = scratch.before[middle], from = scratch.from[middle];
        // The sweep from a part's other end is that of its parent, as far as it goes.
        sweep_from(begin, middle, scratch);
        divide({place, begin, middle, free + 2}, before, nodes[free], nodes, make_leaf, scratch);
        sweep_before(middle, end, scratch);
        divide({place, middle, end, free + 2 * leaves}, from, nodes[free + 1], nodes, make_leaf, scratch);
    }

    void sweep_before(std::size_t begin, std::size_t end, Scratch& scratch) const {
        if (end - begin <= leaf_) return;
        SignedBounds hull;
        for (std::size_t i = begin + 1; i < end; ++i) {
            hull.extend(scratch.boxes[i - 1]);
            scratch.before[i] = hull;
        }
        measure(begin + 1, end, scratch.before, scratch.area_before);
    }
    void sweep_from(std::size_t begin, std::size_t end, Scratch& scratch) const {
        if (end - begin <= leaf_) return;
        SignedBounds hull;
        for (std::size_t i = end - 1; i > begin; --i) {
            hull.extend(scratch.boxes[i]);
            scratch.from[i] = hull;
        }
        measure(begin + 1, end, scratch.from, scratch.area_from);
    }
    // Four at once; those beside them come out as they were.
    static void measure(std::size_t begin, std::size_t end, const std::array<SignedBounds, grain_most>& hulls,
                        std::array<float, grain_most>& areas) {
        for (std::size_t i = begin / 4 * 4; i < end; i += 4)
            half_areas(hulls[i], hulls[i + 1], hulls[i + 2], hulls[i + 3]).store(&areas[i]);
    }

    // The cut with the least area for each leaf, of those that make no more leaves: where the right part begins.
    std::size_t best_cut(std::size_t begin, std::size_t end, const Scratch& scratch) const {
        const std::size_t leaves = leaves_for_(end - begin);
        std::size_t best = begin + leaf_;
        float least = infinity;
        for (std::size_t cut = begin + 1; cut < end; ++cut) {
            const std::size_t left = leaves_for_(cut - begin), right = leaves_for_(end - cut);
            if (left + right > leaves) continue;
            const float cost = scratch.area_before[cut] * float(left) + scratch.area_from[cut] * float(right);
            if (cost < least) {  // NaN never wins
                least = cost;
                best = cut;
            }
        }
        return best;
    }

    std::span<const Primitive> primitives_;
    std::span<const std::uint32_t> order_;
    const LeafCounts& leaves_for_;
    std::uint32_t leaf_;
};

// The tree over the roots of grains by the heuristic, which is 2 · roots − 1 nodes; its leaves are the roots.
void put_top(std::span<const BvhNode> roots, std::uint32_t depth_of_grains, std::span<BvhNode> nodes) {
    HugeVector<Box> boxes(roots.size());
    for (std::size_t g = 0; g < roots.size(); ++g) boxes[g] = {roots[g].lower, roots[g].upper};
    SplitBvhOptions over;
    over.block = over.max_leaf = over.min_leaf = 1;
    over.bin_count = 8;
    over.max_depth = int(kernels::BVH_MAX_DEPTH) - int(depth_of_grains);
    const Bvh top = build_split_bvh(boxes, over);
    for (std::size_t n = 0; n < top.nodes.size(); ++n)
        nodes[n] = top.nodes[n].count > 0 ? roots[top.order[top.nodes[n].first]] : top.nodes[n];
}

constexpr std::size_t grains_together = 1024;  // that are divided by one task

// The work on each grain, in order within a task.
template <class Primitive, class Body>
void for_grains(std::span<const MortonGrain> grains, const Divider<Primitive>& divider, const Body& body) {
    parallel_for(grains.size(), grains_together, [&](std::size_t begin, std::size_t end) {
        typename Divider<Primitive>::Scratch scratch;
        for (std::size_t g = begin; g < end; ++g) {
            if (g + 2 < end) divider.prefetch(grains[g + 2]);
            body(g, scratch);
        }
    });
}

}  // namespace

Bvh build_grain_bvh(std::span<const Box> boxes, const GrainBvhOptions& options) {
    assert(options.leaf >= 1 && options.leaf <= kernels::BVH_MAX_LEAF);
    MortonGrains sorted = morton_grains(boxes, grain_most);
    const std::vector<MortonGrain>& grains = sorted.grains;
    if (grains.empty()) return {};
    const LeafCounts leaves_for(options.leaf);
    // Nodes below the roots of grains stand behind those of the top, in the order of grains.
    std::size_t next = 2 * grains.size() - 1;
    std::vector<std::size_t> free(grains.size());
    for (std::size_t g = 0; g < grains.size(); ++g) {
        free[g] = next;
        next += 2 * (leaves_for(grains[g]) - 1);
    }
    Bvh out;
    out.nodes.resize(next);
    HugeVector<BvhNode> roots(grains.size());
    const Divider divider(boxes, sorted.order, leaves_for, options.leaf);
    for_grains(grains, divider, [&](std::size_t g, auto& scratch) {
        const auto make_leaf = [](std::size_t place, std::span<const std::uint32_t> indices, BvhNode& node) {
            node.first = std::uint32_t(place);
            node.count = std::uint32_t(indices.size());
        };
        divider.divide(grains[g], roots[g], out.nodes.data(), free[g], make_leaf, scratch);
    });
    put_top(roots, std::uint32_t(leaves_for(grain_most)), out.nodes);
    out.order = std::move(sorted.order);
    return out;
}

namespace {

constexpr std::size_t least_blocks = 4;    // in a grain that becomes a node
constexpr std::size_t least_grains = 256;  // below which all are planned: there is little time to be saved

// From triangles to a wide hierarchy: grains become nodes of it as they are divided, their blocks the children. Only
// those of few blocks, and the largest, are parts of the binary tree that is planned over all: an eighth to a
// quarter of the time is saved. The largest are what most rays meet, so where their blocks stand in the hierarchy is
// worth it.
class WideGrains {
  public:
    WideGrains(std::span<const kernels::Triangle> triangles, const MortonGrains& sorted, const WideBvhOptions& options)
        : triangles_(triangles),
          grains_(sorted.grains),
          options_(options),
          divider_(triangles, sorted.order, leaves_for_, wide_block),
          places_(grains_.size()) {
        std::uint32_t blocks = 0, ready = 0;
        for (std::size_t g = 0; g < grains_.size(); ++g) {
            places_[g] = {blocks, ready};
            blocks += std::uint32_t(leaves_for_(grains_[g]));
            ready += may_be_ready(grains_[g]);
        }
        if (ready > 0) largest_ready_area_ = area_of_large();
        next_node_ = 2 * grains_.size() - 1;
        nodes_.resize(next_node_ + 2 * (blocks - grains_.size()));
        ready_.resize(ready);
        parts_ = WideParts(blocks, ready);
    }

    WideBvh run() {
        HugeVector<BvhNode> roots(grains_.size());
        for_grains(grains_, divider_, [&](std::size_t g, auto& scratch) { roots[g] = divide(g, scratch); });
        put_top(roots, std::uint32_t(leaves_for_(grain_most)), nodes_);
        return collapse_parts(std::span(nodes_).first(next_node_), std::move(parts_), ready_, options_);
    }

  private:
    // Of a grain its first block, and its node if it may become one.
    struct Place {
        std::uint32_t block, ready;
    };

    bool may_be_ready(const MortonGrain& grain) const {
        return leaves_for_(grain) >= least_blocks && grains_.size() >= least_grains;
    }

    // What about an eighth of the grains is larger than, as far as some of them tell: one of each of equal runs, at
    // places in it that do not repeat as the curve does.
    float area_of_large() const {
        constexpr std::size_t count = 256;
        static_assert(count <= least_grains);
        const auto grain = [&](std::size_t i) {
            const double within = double(i) * 0.6180339887498949;
            const double place = (double(i) + within - std::floor(within)) / double(count);
            return grains_[std::min(std::size_t(place * double(grains_.size())), grains_.size() - 1)];
        };
        std::vector<float> areas;
        areas.reserve(count);
        for (std::size_t i = 0; i < count; ++i) {
            if (i + 4 < count) divider_.prefetch(grain(i + 4));
            const SignedBounds bounds = divider_.bounds(grain(i));
            areas.push_back(cost_area({lower_of(bounds), 0, upper_of(bounds), 0}));
        }
        const auto at = areas.begin() + std::ptrdiff_t(count - 1 - count / 8);
        std::nth_element(areas.begin(), at, areas.end());
        return *at;
    }

    // Returns its root in the binary tree.
    BvhNode divide(std::size_t g, Divider<kernels::Triangle>::Scratch& scratch) {
        const Place place = places_[g];
        BvhNode root;
        std::array<BvhNode, 2 * wide_width> nodes;  // below the root
        std::array<WideChild, wide_width> children;
        std::array<float, wide_width> areas;
        std::uint32_t count = 0;
        float cost = 0;
        divider_.divide(
            grains_[g], root, nodes.data(), 0,
            [&](std::size_t, std::span<const std::uint32_t> indices, BvhNode& node) {
                const std::uint32_t block = place.block + count;
                write_wide_block(triangles_, indices, parts_.block(block)->lanes);
                node.first = block;
                node.count = 1;
                areas[count] = cost_area(node);
                cost += areas[count] * options_.block_cost;
                children[count++] = {&node, WideParts::block_reference(block, 1)};
            },
            scratch);
        if (!may_be_ready(grains_[g])) return in_binary_tree(root, nodes, count);
        const float area = cost_area(root);
        if (area > largest_ready_area_) {
            ready_[place.ready].primitives = 0;
            return in_binary_tree(root, nodes, count);
        }
        sort_by_promise(std::span(children).first(count), areas);
        write_wide_node(std::span(children).first(count), parts_.ready(place.ready));
        ready_[place.ready] = {cost + area * options_.node_cost, count};
        root.first = place.ready;
        root.count = wide_ready;
        return root;
    }

    // Puts the nodes below a root where there is room: where that is does not show in the wide hierarchy.
    BvhNode in_binary_tree(BvhNode root, std::span<BvhNode> nodes, std::uint32_t leaves) {
        if (leaves == 1) return root;
        nodes = nodes.first(2 * (leaves - 1));
        const std::size_t place = next_node_.fetch_add(nodes.size(), std::memory_order_relaxed);
        for (BvhNode& node : nodes)
            if (node.count == 0) node.first += std::uint32_t(place);
        std::copy(nodes.begin(), nodes.end(), &nodes_[place]);
        root.first += std::uint32_t(place);
        return root;
    }

    std::span<const kernels::Triangle> triangles_;
    const std::vector<MortonGrain>& grains_;
    const WideBvhOptions& options_;
    const LeafCounts leaves_for_{wide_block};
    Divider<kernels::Triangle> divider_;
    HugeVector<Place> places_;
    float largest_ready_area_ = 0;
    HugeVector<BvhNode> nodes_;  // of the binary tree, as many as there can be, those of the top first
    std::atomic<std::size_t> next_node_;
    HugeVector<WideReady> ready_;
    WideParts parts_;
};

}  // namespace

WideBvh build_wide_grains(std::span<const kernels::Triangle> triangles, const WideBvhOptions& options) {
    const MortonGrains sorted = morton_grains(triangles, grain_most);
    if (sorted.grains.empty()) return {};
    WideBvh out = WideGrains(triangles, sorted, options).run();
    out.statistics.triangle_count = std::uint32_t(sorted.order.size());
    return out;
}

}  // namespace spinel
