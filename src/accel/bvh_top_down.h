#pragma once
// The frame of builders that split ranges of primitives from above.

#include "accel/bvh_bounds.h"
#include "core/parallel.h"

namespace spinel::bvh {

constexpr std::size_t parallel_threshold = 4096;  // primitives below which a subtree is not worth a task

// Fills nodes[node] and its subtree over primitives [begin, end). split(begin, end, depth, bounds) reorders them, tells
// their bounds, and returns where the right child begins; `begin`: a leaf. The subtree's other nodes go to
// [pool, pool + 2·(end − begin) − 2), which always suffices, so that subtrees are built at the same time; compact()
// closes the gaps that larger leaves leave.
template <class Split>
void build_top_down(std::vector<kernels::BvhNode>& nodes, const Split& split, std::size_t node, std::size_t pool,
                    std::size_t begin, std::size_t end, int depth) {
    Bounds bounds = Bounds::empty();
    const std::size_t middle = split(begin, end, depth, bounds);
    kernels::BvhNode& out = nodes[node];
    out.lower = {bounds.lower[0], bounds.lower[1], bounds.lower[2]};
    out.upper = {bounds.upper[0], bounds.upper[1], bounds.upper[2]};
    if (middle == begin) {
        out.first = std::uint32_t(begin);
        out.count = std::uint32_t(end - begin);
        return;
    }
    out.first = std::uint32_t(pool);
    out.count = 0;
    const std::size_t left_pool = pool + 2, right_pool = left_pool + 2 * (middle - begin) - 2;
    const auto left = [&] { build_top_down(nodes, split, pool, left_pool, begin, middle, depth + 1); };
    const auto right = [&] { build_top_down(nodes, split, pool + 1, right_pool, middle, end, depth + 1); };
    if (end - begin < parallel_threshold) {
        left();
        right();
        return;
    }
    parallel_for(2, 1, [&](std::size_t first, std::size_t last) {
        if (first == 0) left();
        if (last == 2) right();
    });
}

// At least one primitive; gaps closed, measured, without an order.
template <class Split>
Bvh build_top_down(std::size_t count, const Split& split, float traversal_cost) {
    std::vector<kernels::BvhNode> sparse(2 * count - 1);
    build_top_down(sparse, split, 0, 1, 0, count, 0);
    Bvh bvh;
    compact(sparse, traversal_cost, bvh);
    return bvh;
}

}  // namespace spinel::bvh
