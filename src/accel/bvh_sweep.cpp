// The surface area heuristic at every plane between two primitives (MacDonald and Booth, "Heuristics for Ray Tracing
// Using Space Subdivision", 1990). Primitives are sorted by their centres along each axis once; splits keep the three
// orders, so the whole takes O(n log n).

#include <numeric>

#include "accel/bvh_top_down.h"

namespace spinel::bvh {
namespace {

using Index = std::uint32_t;

class SweepBuilder {
  public:
    SweepBuilder(std::vector<Primitive> primitives, const BvhOptions& options)
        : primitives_(std::move(primitives)),
          options_(options),
          left_(primitives_.size()),
          right_area_(primitives_.size()),
          scratch_(primitives_.size()) {
        parallel_for(3, 1, [&](std::size_t first, std::size_t last) {
            for (std::size_t axis = first; axis < last; ++axis) {
                std::vector<Index>& order = orders_[axis];
                order.resize(primitives_.size());
                std::iota(order.begin(), order.end(), Index(0));
                std::sort(order.begin(), order.end(), [&](Index a, Index b) {
                    const float ca = primitives_[a].bounds.center(axis), cb = primitives_[b].bounds.center(axis);
                    return ca != cb ? ca < cb : a < b;
                });
            }
        });
    }

    Bvh build() {
        const auto split = [this](std::size_t begin, std::size_t end, int depth, Bounds& bounds) {
            for (std::size_t i = begin; i < end; ++i) bounds.extend(primitives_[orders_[0][i]].bounds);
            return partition(bounds, begin, end, depth);
        };
        Bvh bvh = build_top_down(primitives_.size(), split, options_.traversal_cost);
        bvh.order.reserve(primitives_.size());
        for (const Index i : orders_[0]) bvh.order.push_back(primitives_[i].index);
        return bvh;
    }

  private:
    struct Split {
        std::size_t axis = 0;
        std::size_t middle = 0;  // 0: none
        float cost = std::numeric_limits<float>::infinity();
    };

    std::size_t partition(const Bounds& bounds, std::size_t begin, std::size_t end, int depth) {
        const std::size_t count = end - begin;
        if (count <= 1) return begin;
        Split split;
        if (depth + ceil_log2(count) < int(kernels::BVH_MAX_DEPTH)) split = best_split(bounds, begin, end);
        if (count <= options_.max_leaf && !(split.cost < float(count))) return begin;
        if (split.middle == 0) split = {0, begin + count / 2, 0};
        for (std::size_t i = begin; i < end; ++i) left_[orders_[split.axis][i]] = i < split.middle;
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (axis != split.axis) keep_order(orders_[axis], begin, end);
        return split.middle;
    }

    // Stable: what goes left first, each side in its order.
    void keep_order(std::vector<Index>& order, std::size_t begin, std::size_t end) {
        std::size_t left = begin, right = begin;
        for (std::size_t i = begin; i < end; ++i) {
            if (left_[order[i]]) order[left++] = order[i];
            else scratch_[right++] = order[i];
        }
        std::copy(scratch_.begin() + std::ptrdiff_t(begin), scratch_.begin() + std::ptrdiff_t(right),
                  order.begin() + std::ptrdiff_t(left));
    }

    Split best_split(const Bounds& bounds, std::size_t begin, std::size_t end) {
        Split best;
        const float area = bounds.half_area();
        const float inverse_area = area > 0 ? 1.0f / area : 0.0f;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::vector<Index>& order = orders_[axis];
            Bounds right = Bounds::empty();
            for (std::size_t i = end - 1; i > begin; --i) {
                right.extend(primitives_[order[i]].bounds);
                right_area_[i] = right.half_area();
            }
            Bounds left = Bounds::empty();
            for (std::size_t i = begin + 1; i < end; ++i) {
                left.extend(primitives_[order[i - 1]].bounds);
                const float cost =
                    options_.traversal_cost +
                    (left.half_area() * float(i - begin) + right_area_[i] * float(end - i)) * inverse_area;
                if (cost < best.cost) best = {axis, i, cost};  // NaN never wins
            }
        }
        return best;
    }

    std::vector<Primitive> primitives_;
    const BvhOptions& options_;
    std::array<std::vector<Index>, 3> orders_;  // into primitives_; ranges belong to subtrees
    std::vector<unsigned char> left_;           // of the split at hand, by primitive
    std::vector<float> right_area_;
    std::vector<Index> scratch_;
};

}  // namespace

Bvh build_by_sweep(std::vector<Primitive> primitives, const BvhOptions& options) {
    return SweepBuilder(std::move(primitives), options).build();
}

}  // namespace spinel::bvh
