#include "accel/grain_bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <limits>
#include <vector>

#include "accel/float4.h"
#include "accel/morton_grains.h"
#include "accel/split_bvh.h"
#include "core/huge_pages.h"
#include "core/parallel.h"

namespace spinel {
namespace {

using kernels::BvhNode;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr std::uint32_t grain_most = 32;  // primitives

void put_bounds(const Bounds& bounds, BvhNode& node) {
    const auto lower = lanes_of(bounds.lower), upper = lanes_of(bounds.upper);
    node.lower = {lower[0], lower[1], lower[2]};
    node.upper = {upper[0], upper[1], upper[2]};
}

class Builder {
  public:
    Builder(std::span<const Box> boxes, const GrainBvhOptions& options) : boxes_(boxes), options_(options) {
        for (std::uint32_t i = 0; i <= grain_most; ++i) leaves_for_[i] = (i + options.leaf - 1) / options.leaf;
    }

    Bvh run() {
        MortonGrains sorted = morton_grains(boxes_, grain_most);
        if (sorted.grains.empty()) return {};
        grains_ = std::move(sorted.grains);
        sorted_ = std::move(sorted.order);
        SplitBvhOptions over;
        over.block = over.max_leaf = over.min_leaf = 1;
        over.bin_count = 8;
        over.max_depth = int(kernels::BVH_MAX_DEPTH) - int(leaves_for(grain_most));
        Bvh top = build_split_bvh(grain_bounds(), over);

        // Grains stand in the order of the top's leaves, so that the primitives below any node follow each other; their
        // nodes behind those of the top.
        std::vector<std::size_t> places(grains_.size()), free(grains_.size());
        std::size_t place = 0, size = top.nodes.size();
        for (std::size_t g = 0; g < grains_.size(); ++g) {
            const std::size_t count = grains_[top.order[g]].end - grains_[top.order[g]].begin;
            places[g] = place;
            free[g] = size;
            place += count;
            size += 2 * (leaves_for(count) - 1);
        }
        std::vector<std::uint32_t> roots(grains_.size());
        for (std::size_t n = 0; n < top.nodes.size(); ++n)
            if (top.nodes[n].count > 0) roots[top.nodes[n].first] = std::uint32_t(n);
        bvh_.nodes = std::move(top.nodes);
        bvh_.nodes.resize(size);
        bvh_.order.resize(place);
        parallel_for(roots.size(), 1024, [&](std::size_t begin, std::size_t end) {
            std::array<Bounds, grain_most> boxes;
            for (std::size_t g = begin; g < end; ++g) {
                const MortonGrain grain = grains_[top.order[g]];
                const std::size_t count = grain.end - grain.begin;
                for (std::size_t i = 0; i < count; ++i) {
                    boxes[i] = bounds_of(grain.begin + i);
                    bvh_.order[places[g] + i] = sorted_[grain.begin + i];
                }
                divide(roots[g], free[g], std::span(boxes).first(count), places[g]);
            }
        });
        return std::move(bvh_);
    }

  private:
    std::size_t leaves_for(std::size_t count) const { return leaves_for_[count]; }

    // Of the primitive at a place along the curve.
    Bounds bounds_of(std::size_t place) const {
        const Box& box = boxes_[sorted_[place]];
        return {Float4(box.lower), Float4(box.upper)};
    }

    HugeVector<Box> grain_bounds() const {
        HugeVector<Box> boxes(grains_.size());
        parallel_for(grains_.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t g = begin; g < end; ++g) {
                Bounds bounds;
                for (std::size_t i = grains_[g].begin; i < grains_[g].end; ++i) bounds.extend(bounds_of(i));
                const auto l = lanes_of(bounds.lower), u = lanes_of(bounds.upper);
                boxes[g] = {{l[0], l[1], l[2]}, {u[0], u[1], u[2]}};
            }
        });
        return boxes;
    }

    // Fills node `at`, and those below it from `free` on, for boxes that stand in the order from `place` on: as few
    // leaves as can hold them.
    void divide(std::size_t at, std::size_t free, std::span<const Bounds> boxes, std::size_t place) {
        BvhNode& node = bvh_.nodes[at];
        Bounds all;
        for (const Bounds& box : boxes) all.extend(box);
        put_bounds(all, node);
        if (boxes.size() <= options_.leaf) {
            node.first = std::uint32_t(place);
            node.count = std::uint32_t(boxes.size());
            return;
        }
        node.first = std::uint32_t(free);
        node.count = 0;
        const std::size_t left = best_cut(boxes);
        divide(free, free + 2, boxes.first(left), place);
        divide(free + 1, free + 2 * leaves_for(left), boxes.subspan(left), place + left);
    }

    // The cut with the least area for each leaf, of those that make no more leaves; how many boxes go left.
    std::size_t best_cut(std::span<const Bounds> boxes) const {
        const std::size_t count = boxes.size(), leaves = leaves_for(count);
        std::array<float, grain_most> right;  // area of a box and all behind it
        Bounds bounds;
        for (std::size_t i = count - 1; i > 0; --i) {
            bounds.extend(boxes[i]);
            right[i] = bounds.half_area();
        }
        bounds = {};
        std::size_t best = options_.leaf;
        float least = infinity;
        for (std::size_t left = 1; left < count; ++left) {
            bounds.extend(boxes[left - 1]);
            const std::size_t leaves_left = leaves_for(left), leaves_right = leaves_for(count - left);
            if (leaves_left + leaves_right > leaves) continue;
            const float cost = bounds.half_area() * float(leaves_left) + right[left] * float(leaves_right);
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
    std::vector<MortonGrain> grains_;
    std::vector<std::uint32_t> sorted_;  // primitives along the curve
    Bvh bvh_;
};

}  // namespace

Bvh build_grain_bvh(std::span<const Box> boxes, const GrainBvhOptions& options) {
    assert(options.leaf >= 1 && options.leaf <= kernels::BVH_MAX_LEAF);
    return Builder(boxes, options).run();
}

}  // namespace spinel
