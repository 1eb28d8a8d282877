#include "accel/bvh_builder.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "accel/bvh_top_down.h"
#include "accel/pair_tree.h"

namespace spinel {
namespace {

using bvh::Bounds;
using bvh::Primitive;

constexpr int bin_count = 16;

struct Split {
    int axis = -1;  // −1: none found
    int bin = 0;    // bins below go left
    float cost = std::numeric_limits<float>::infinity();
};

class Builder {
  public:
    Builder(std::vector<Primitive>& primitives, const BvhOptions& options)
        : primitives_(primitives), options_(options) {}

    // As bvh::build_top_down() wants it.
    std::size_t split(std::size_t begin, std::size_t end, int depth, Bounds& bounds) {
        Bounds centers = Bounds::empty();
        for (std::size_t i = begin; i < end; ++i) {
            bounds.extend(primitives_[i].bounds);
            centers.extend_center(primitives_[i].bounds);
        }
        return partition(bounds, centers, begin, end, depth);
    }

  private:
    // Reorders [begin, end) and returns where the right child begins; `begin`: make a leaf.
    std::size_t partition(const Bounds& bounds, const Bounds& centers, std::size_t begin, std::size_t end, int depth) {
        const std::size_t count = end - begin;
        if (count <= 1) return begin;
        // As many levels as halving needs are kept in reserve, which bounds the depth whatever the input.
        const bool balance = depth + bvh::ceil_log2(count) >= static_cast<int>(kernels::BVH_MAX_DEPTH);
        if (options_.method == BvhMethod::median)
            return count <= options_.max_leaf ? begin : median(centers, begin, end);
        const Split split = balance ? Split{} : best_split(bounds, centers, begin, end);
        const float leaf_cost = static_cast<float>(count);
        if (count <= options_.max_leaf && !(split.cost < leaf_cost)) return begin;
        if (split.axis < 0) return median(centers, begin, end);
        const auto axis = static_cast<std::size_t>(split.axis);
        const float offset = centers.lower[axis];
        const float scale = bin_scale(centers, axis);
        const auto middle = std::partition(
            primitives_.begin() + static_cast<std::ptrdiff_t>(begin),
            primitives_.begin() + static_cast<std::ptrdiff_t>(end),
            [&](const Primitive& p) { return bin_of(p.bounds.center(axis), offset, scale) < split.bin; });
        return static_cast<std::size_t>(middle - primitives_.begin());
    }

    // Zero where the centres do not spread, or not enough for a finite scale.
    static float bin_scale(const Bounds& centers, std::size_t axis) {
        const float scale = static_cast<float>(bin_count) / (centers.upper[axis] - centers.lower[axis]);
        return std::isfinite(scale) ? scale : 0.0f;
    }
    static int bin_of(float center, float offset, float scale) {
        return std::min(static_cast<int>((center - offset) * scale), bin_count - 1);
    }

    Split best_split(const Bounds& bounds, const Bounds& centers, std::size_t begin, std::size_t end) const {
        struct Bin {
            Bounds bounds = Bounds::empty();
            std::uint32_t count = 0;
        };
        std::array<std::array<Bin, bin_count>, 3> bins;
        std::array<float, 3> scale;
        for (std::size_t axis = 0; axis < 3; ++axis) scale[axis] = bin_scale(centers, axis);
        for (std::size_t i = begin; i < end; ++i) {
            const Bounds& b = primitives_[i].bounds;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                Bin& bin =
                    bins[axis][static_cast<std::size_t>(bin_of(b.center(axis), centers.lower[axis], scale[axis]))];
                bin.bounds.extend(b);
                ++bin.count;
            }
        }
        Split best;
        const float parent_area = bounds.half_area();
        const float inverse_area = parent_area > 0 ? 1.0f / parent_area : 0.0f;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!(scale[axis] > 0)) continue;
            std::array<float, bin_count> right_cost;
            Bounds right = Bounds::empty();
            std::uint32_t right_count = 0;
            for (std::size_t i = bin_count - 1; i > 0; --i) {
                right.extend(bins[axis][i].bounds);
                right_count += bins[axis][i].count;
                right_cost[i] = right_count > 0 ? right.half_area() * static_cast<float>(right_count) : 0.0f;
            }
            Bounds left = Bounds::empty();
            std::uint32_t left_count = 0;
            const auto total = static_cast<std::uint32_t>(end - begin);
            for (std::size_t i = 1; i < bin_count; ++i) {
                left.extend(bins[axis][i - 1].bounds);
                left_count += bins[axis][i - 1].count;
                if (left_count == 0 || left_count == total) continue;
                const float cost = options_.traversal_cost +
                                   (left.half_area() * static_cast<float>(left_count) + right_cost[i]) * inverse_area;
                if (cost < best.cost) best = {static_cast<int>(axis), static_cast<int>(i), cost};  // NaN never wins
            }
        }
        return best;
    }

    // Halves by number, ordered by centre along the widest axis; ties by index, so that the order is total.
    std::size_t median(const Bounds& centers, std::size_t begin, std::size_t end) {
        std::size_t axis = 0;
        for (std::size_t i = 1; i < 3; ++i) {
            if (centers.upper[i] - centers.lower[i] > centers.upper[axis] - centers.lower[axis]) axis = i;
        }
        const std::size_t middle = begin + (end - begin) / 2;
        const auto at = [&](std::size_t i) { return primitives_.begin() + static_cast<std::ptrdiff_t>(i); };
        std::nth_element(at(begin), at(middle), at(end), [axis](const Primitive& a, const Primitive& b) {
            const float ca = a.bounds.center(axis), cb = b.bounds.center(axis);
            return ca != cb ? ca < cb : a.index < b.index;
        });
        return middle;
    }

    std::vector<Primitive>& primitives_;
    const BvhOptions& options_;
};

}  // namespace

Bvh build_bvh(std::span<const Box> boxes, const BvhOptions& options) {
    assert(boxes.size() <= kernels::BVH_MAX_PRIMITIVES);
    assert(options.max_leaf >= 1 && options.max_leaf <= kernels::BVH_MAX_LEAF);
    std::vector<Primitive> primitives = bvh::usable_primitives(boxes);
    if (primitives.empty()) return {};
    if (options.method == BvhMethod::sweep) return bvh::build_by_sweep(std::move(primitives), options);
    const bool moved = options.method == BvhMethod::reinsertion;
    BvhOptions first = options;
    if (moved) first = {.max_leaf = 1, .traversal_cost = options.traversal_cost};
    Builder builder(primitives, first);
    const auto split = [&](std::size_t begin, std::size_t end, int depth, Bounds& bounds) {
        return builder.split(begin, end, depth, bounds);
    };
    Bvh bvh = bvh::build_top_down(primitives.size(), split, options.traversal_cost);
    if (moved) {
        bvh::PairTree tree = bvh::pair_tree(bvh);
        bvh::optimize(tree);
        return bvh::finish(tree, primitives, options);
    }
    bvh.order.reserve(primitives.size());
    for (const Primitive& primitive : primitives) bvh.order.push_back(primitive.index);
    return bvh;
}

}  // namespace spinel
