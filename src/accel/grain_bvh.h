#pragma once
// Binary hierarchies in a small part of the time that a heuristic over all primitives takes: groups of at most 32
// neighbours along a Morton curve (morton_grains.h) are divided along the curve, and only the groups are asked by the
// binned surface area heuristic. Pantaleoni and Luebke, "HLBVH: Hierarchical LBVH Construction for Real-Time Ray
// Tracing of Dynamic Geometry", HPG 2010.

#include <span>

#include "accel/bvh_builder.h"
#include "accel/wide_bvh.h"

namespace spinel {

struct GrainBvhOptions {
    std::uint32_t leaf = 4;  // primitives at most, and tested at once; at most kernels::BVH_MAX_LEAF
};

// As build_bvh(): siblings adjacent behind their parents, the same treatment of unusable boxes, independent of the
// number of threads. Primitives of a subtree follow each other in the order only below the roots of groups. Statistics
// are left to whoever needs them (bvh_statistics).
Bvh build_grain_bvh(std::span<const Box> boxes, const GrainBvhOptions& options = {});

// From triangles to a wide hierarchy: a few hundredths dearer for rays than what collapse_bvh() makes of the binary one
// over their boxes, and of scans and rooms with a tenth more nodes. Blocks and most nodes are written while groups are
// divided, so that their triangles, which lie all over memory, are fetched once.
WideBvh build_wide_grains(std::span<const kernels::Triangle> triangles, const WideBvhOptions& options = {});

}  // namespace spinel
