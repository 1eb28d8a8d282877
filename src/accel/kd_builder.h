#pragma once
// Builds the kd-trees that kernels/mesh_kd.h walks, from boxes and a way to clip what is in them: the tree never knows
// a shape. Surface area heuristic at every plane where a clipped primitive begins or ends, in O(n log n): Wald and
// Havran, "On building fast kd-Trees for Ray Tracing, and on doing that in O(N log N)", RT 2006.

#include <functional>
#include <span>
#include <vector>

#include "accel/bvh_builder.h"

namespace spinel {

// Bounds of the part of a primitive that lies in a region, no smaller than it; lower > upper if there is none. Called
// from several threads.
using ClipToBox = std::function<Box(std::uint32_t primitive, const Box& region)>;

struct KdOptions {
    float traversal_cost = 1.0f;  // of an interior node, in primitive tests
    float empty_bonus = 0.2f;     // by which planes that cut off empty space are preferred (Wald and Havran's λ)
    std::size_t references = 16;  // in leaves, at most, for each primitive, and 2¹⁶ besides
};

// Nodes as kernels::KdNode tells, the root first; leaves name boxes in `references`, some in several.
struct KdTree {
    std::vector<kernels::KdNode> nodes;
    std::vector<std::uint32_t> references;
    Box bounds;
    double sah_cost = 0;  // of a ray that meets the bounds, in primitive tests
    std::uint32_t depth = 0;
    std::size_t leaf_count = 0;
};

// All boxes finite and ordered. The result depends on the boxes only, not on the number of threads.
KdTree build_kd_tree(std::span<const Box> boxes, const ClipToBox& clip, const KdOptions& options = {});

}  // namespace spinel
