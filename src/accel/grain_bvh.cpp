#include "accel/grain_bvh.h"

#include <array>
#include <cassert>
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

// Primitives that are boxes alone: leaves own ranges of the order.
class Boxes {
  public:
    explicit Boxes(std::span<const Box> boxes) : boxes_(boxes) {}

    SignedBounds operator[](std::uint32_t index) const { return signed_bounds(boxes_[index]); }
    void prefetch(std::uint32_t index) const { __builtin_prefetch(&boxes_[index]); }
    // The `number`th leaf.
    void make_leaf(std::size_t, std::size_t place, std::span<const std::uint32_t> indices, BvhNode& node) const {
        node.first = std::uint32_t(place);
        node.count = std::uint32_t(indices.size());
    }

  private:
    std::span<const Box> boxes_;
};

// Triangles: leaves are blocks, which are written as they are made.
class Blocks {
  public:
    Blocks(std::span<const kernels::Triangle> triangles, std::span<kernels::WideUnit> units)
        : triangles_(triangles), units_(units) {}

    SignedBounds operator[](std::uint32_t index) const { return signed_bounds(triangles_[index]); }
    void prefetch(std::uint32_t index) const {
        const char* triangle = reinterpret_cast<const char*>(&triangles_[index]);
        __builtin_prefetch(triangle);
        __builtin_prefetch(triangle + sizeof(kernels::Triangle) - 1);
    }
    void make_leaf(std::size_t number, std::size_t, std::span<const std::uint32_t> indices, BvhNode& node) const {
        write_wide_block(triangles_, indices, units_[number * kernels::WIDE_BLOCK_UNITS].lanes);
        node.first = std::uint32_t(number);
        node.count = 1;
    }

  private:
    std::span<const kernels::Triangle> triangles_;
    std::span<kernels::WideUnit> units_;
};

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

std::size_t leaves_of(std::span<const MortonGrain> grains, const LeafCounts& leaves_for) {
    std::size_t sum = 0;
    for (const MortonGrain& grain : grains) sum += leaves_for(grain);
    return sum;
}

template <class Primitives>
class Builder {
  public:
    Builder(const Primitives& primitives, const GrainBvhOptions& options)
        : primitives_(primitives), options_(options), leaves_for_(options.leaf) {}

    // Grains must not be empty.
    Bvh run(MortonGrains sorted) {
        const std::vector<MortonGrain>& grains = sorted.grains;
        bvh_.order = std::move(sorted.order);

        // Nodes below the roots of grains stand behind those of the top, in the order of grains.
        const std::size_t top_size = 2 * grains.size() - 1;
        std::vector<std::size_t> leaves(grains.size());  // before those of a grain
        std::size_t leaf_count = 0;
        for (std::size_t g = 0; g < grains.size(); ++g) {
            leaves[g] = leaf_count;
            leaf_count += leaves_for_(grains[g]);
        }
        bvh_.nodes.resize(top_size + 2 * (leaf_count - grains.size()));
        HugeVector<BvhNode> roots(grains.size());
        HugeVector<Box> root_boxes(grains.size());
        parallel_for(grains.size(), 1024, [&](std::size_t begin, std::size_t end) {
            Scratch scratch;
            for (std::size_t g = begin; g < end; ++g) {
                // Primitives are wanted in another order than they stand in.
                if (g + 2 < end)
                    for (const std::uint32_t index : indices_of(grains[g + 2])) primitives_.prefetch(index);
                divide_grain(grains[g], leaves[g], top_size + 2 * (leaves[g] - g), roots[g], scratch);
                root_boxes[g] = {roots[g].lower, roots[g].upper};
            }
        });

        SplitBvhOptions over;
        over.block = over.max_leaf = over.min_leaf = 1;
        over.bin_count = 8;
        over.max_depth = int(kernels::BVH_MAX_DEPTH) - int(leaves_for_(grain_most));
        const Bvh top = build_split_bvh(root_boxes, over);
        for (std::size_t n = 0; n < top_size; ++n)
            bvh_.nodes[n] = top.nodes[n].count > 0 ? roots[top.order[top.nodes[n].first]] : top.nodes[n];
        return std::move(bvh_);
    }

  private:
    using Hulls = std::array<SignedBounds, grain_most>;

    struct Scratch {
        Hulls boxes;
        Hulls before, from;  // the hulls of boxes before a cut, and of those from it on …
        alignas(16) std::array<float, grain_most> area_before, area_from;  // … and half their areas
    };

    std::span<const std::uint32_t> indices_of(const MortonGrain& grain) const {
        return std::span(bvh_.order).subspan(grain.begin, grain.end - grain.begin);
    }

    void divide_grain(const MortonGrain& grain, std::size_t leaf, std::size_t free, BvhNode& root, Scratch& scratch) {
        const auto indices = indices_of(grain);
        SignedBounds all;
        for (std::size_t i = 0; i < indices.size(); ++i) {
            scratch.boxes[i] = primitives_[indices[i]];
            all.extend(scratch.boxes[i]);
        }
        divide({grain.begin, leaf, free, std::span(scratch.boxes).first(indices.size())}, all, root, scratch);
    }

    // What is below a node.
    struct Part {
        std::size_t place, leaf, free;  // where its primitives, leaves and nodes begin
        std::span<const SignedBounds> boxes;
    };

    // Fills a node and those below it: as few leaves as can hold the boxes.
    void divide(const Part& part, SignedBounds all, BvhNode& node, Scratch& scratch) {
        node.lower = lower_of(all);
        node.upper = upper_of(all);
        const auto [place, leaf, free, boxes] = part;
        if (boxes.size() <= options_.leaf) {
            primitives_.make_leaf(leaf, place, std::span(bvh_.order).subspan(place, boxes.size()), node);
            return;
        }
        node.first = std::uint32_t(free);
        node.count = 0;
        const std::size_t left = best_cut(boxes, scratch), leaves = leaves_for_(left);
        const SignedBounds before = scratch.before[left], from = scratch.from[left];
        divide({place, leaf, free + 2, boxes.first(left)}, before, bvh_.nodes[free], scratch);
        divide({place + left, leaf + leaves, free + 2 * leaves, boxes.subspan(left)}, from, bvh_.nodes[free + 1],
               scratch);
    }

    // The cut with the least area for each leaf, of those that make no more leaves; how many boxes go left.
    std::size_t best_cut(std::span<const SignedBounds> boxes, Scratch& scratch) const {
        const std::size_t count = boxes.size(), leaves = leaves_for_(count);
        auto& [_, before, from, area_before, area_from] = scratch;
        SignedBounds low, high;
        for (std::size_t i = 1; i < count; ++i) {
            low.extend(boxes[i - 1]);
            high.extend(boxes[count - i]);
            before[i] = low;
            from[count - i] = high;
        }
        for (std::size_t i = 0; i < count; i += 4) {
            half_areas(before[i], before[i + 1], before[i + 2], before[i + 3]).store(&area_before[i]);
            half_areas(from[i], from[i + 1], from[i + 2], from[i + 3]).store(&area_from[i]);
        }
        std::size_t best = options_.leaf;
        float least = infinity;
        for (std::size_t left = 1; left < count; ++left) {
            const std::size_t leaves_left = leaves_for_(left), leaves_right = leaves_for_(count - left);
            if (leaves_left + leaves_right > leaves) continue;
            const float cost = area_before[left] * float(leaves_left) + area_from[left] * float(leaves_right);
            if (cost < least) {  // NaN never wins
                least = cost;
                best = left;
            }
        }
        return best;
    }

    const Primitives& primitives_;
    const GrainBvhOptions& options_;
    LeafCounts leaves_for_;
    Bvh bvh_;
};

}  // namespace

Bvh build_grain_bvh(std::span<const Box> boxes, const GrainBvhOptions& options) {
    assert(options.leaf >= 1 && options.leaf <= kernels::BVH_MAX_LEAF);
    MortonGrains sorted = morton_grains(boxes, grain_most);
    if (sorted.grains.empty()) return {};
    return Builder(Boxes(boxes), options).run(std::move(sorted));
}

WideBvh build_wide_grains(std::span<const kernels::Triangle> triangles, const WideBvhOptions& options) {
    MortonGrains sorted = morton_grains(triangles, grain_most);
    if (sorted.grains.empty()) return {};
    const GrainBvhOptions grain_options{.leaf = wide_block};
    const auto triangle_count = std::uint32_t(sorted.order.size());
    WideBlocks blocks(leaves_of(sorted.grains, LeafCounts(wide_block)));
    const Bvh binary = Builder(Blocks(triangles, blocks.units()), grain_options).run(std::move(sorted));
    WideBvh out = collapse_blocks(binary, std::move(blocks), options);
    out.statistics.triangle_count = triangle_count;
    return out;
}

}  // namespace spinel
