#include "accel/grain_bvh.h"

#include <algorithm>
#include <array>
#include <bit>
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

class Builder {
  public:
    Builder(std::span<const Box> boxes, const GrainBvhOptions& options) : boxes_(boxes), options_(options) {
        for (std::uint32_t i = 0; i <= grain_most; ++i) leaves_for_[i] = (i + options.leaf - 1) / options.leaf;
    }

    Bvh run() {
        MortonGrains sorted = morton_grains(boxes_, grain_most);
        const std::vector<MortonGrain>& grains = sorted.grains;
        if (grains.empty()) return {};
        bvh_.order = std::move(sorted.order);

        // Nodes below the roots of grains stand behind those of the top, in the order of grains.
        std::vector<std::size_t> free(grains.size());
        std::size_t size = 2 * grains.size() - 1;
        for (std::size_t g = 0; g < grains.size(); ++g) {
            free[g] = size;
            size += 2 * (leaves_for(grains[g].end - grains[g].begin) - 1);
        }
        bvh_.nodes.resize(size);
        HugeVector<BvhNode> roots(grains.size());
        HugeVector<Box> root_boxes(grains.size());
        parallel_for(grains.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t g = begin; g < end; ++g) {
                if (g + 2 < end) prefetch(grains[g + 2]);
                divide_grain(grains[g], roots[g], free[g]);
                root_boxes[g] = {roots[g].lower, roots[g].upper};
            }
        });

        SplitBvhOptions over;
        over.block = over.max_leaf = over.min_leaf = 1;
        over.bin_count = 8;
        over.max_depth = int(kernels::BVH_MAX_DEPTH) - int(leaves_for(grain_most));
        const Bvh top = build_split_bvh(root_boxes, over);
        for (std::size_t n = 0; n < top.nodes.size(); ++n)
            bvh_.nodes[n] = top.nodes[n].count > 0 ? roots[top.order[top.nodes[n].first]] : top.nodes[n];
        return std::move(bvh_);
    }

  private:
    using Hulls = std::array<SignedBounds, grain_most>;

    std::size_t leaves_for(std::size_t count) const { return leaves_for_[count]; }

    void divide_grain(const MortonGrain& grain, BvhNode& root, std::size_t free) {
        const std::size_t count = grain.end - grain.begin;
        Hulls boxes;
        SignedBounds all;
        for (std::size_t i = 0; i < count; ++i) {
            boxes[i] = signed_bounds(boxes_[bvh_.order[grain.begin + i]]);
            all.extend(boxes[i]);
        }
        divide(root, all, free, std::span(boxes).first(count), grain.begin);
    }

    // Asks memory for what divide_grain() reads: boxes are wanted in another order than they stand in.
    void prefetch(const MortonGrain& grain) const {
        for (std::size_t i = grain.begin; i < grain.end; ++i) {
            const char* box = reinterpret_cast<const char*>(&boxes_[bvh_.order[i]]);
            __builtin_prefetch(box);
            __builtin_prefetch(box + sizeof(Box) - 1);
        }
    }

    // Fills a node, and those below it from `free` on, for boxes that stand in the order from `place` on: as few leaves
    // as can hold them.
    void divide(BvhNode& node, SignedBounds all, std::size_t free, std::span<const SignedBounds> boxes,
                std::size_t place) {
        node.lower = lower_of(all);
        node.upper = upper_of(all);
        if (boxes.size() <= options_.leaf) {
            node.first = std::uint32_t(place);
            node.count = std::uint32_t(boxes.size());
            return;
        }
        node.first = std::uint32_t(free);
        node.count = 0;
        Hulls before, from;
        const std::size_t left = best_cut(boxes, before, from);
        divide(bvh_.nodes[free], before[left], free + 2, boxes.first(left), place);
        divide(bvh_.nodes[free + 1], from[left], free + 2 * leaves_for(left), boxes.subspan(left), place + left);
    }

    // The cut with the least area for each leaf, of those that make no more leaves; how many boxes go left. Also the
    // hulls of boxes before a cut, and of those from it on.
    std::size_t best_cut(std::span<const SignedBounds> boxes, Hulls& before, Hulls& from) const {
        const std::size_t count = boxes.size(), leaves = leaves_for(count);
        SignedBounds low, high;
        for (std::size_t i = 1; i < count; ++i) {
            low.extend(boxes[i - 1]);
            high.extend(boxes[count - i]);
            before[i] = low;
            from[count - i] = high;
        }
        std::size_t best = options_.leaf;
        float least = infinity;
        for (std::size_t left = 1; left < count; ++left) {
            const std::size_t leaves_left = leaves_for(left), leaves_right = leaves_for(count - left);
            if (leaves_left + leaves_right > leaves) continue;
            const float cost =
                half_area(before[left]) * float(leaves_left) + half_area(from[left]) * float(leaves_right);
            if (cost < least) {  // NaN never wins
                least = cost;
                best = left;
            }
        }
        return best;
    }

    std::span<const Box> boxes_;
    const GrainBvhOptions& options_;
    std::array<std::uint32_t, grain_most + 1> leaves_for_;
    Bvh bvh_;
};

}  // namespace

Bvh build_grain_bvh(std::span<const Box> boxes, const GrainBvhOptions& options) {
    assert(options.leaf >= 1 && options.leaf <= kernels::BVH_MAX_LEAF);
    return Builder(boxes, options).run();
}

}  // namespace spinel
