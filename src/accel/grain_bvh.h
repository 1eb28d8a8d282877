#pragma once
// Binary hierarchies in a small part of the time that a heuristic over all primitives takes: groups of at most 32
// neighbours along a Morton curve (morton_grains.h) are divided along the curve, and only the groups are asked by the
// binned surface area heuristic. Pantaleoni and Luebke, "HLBVH: Hierarchical LBVH Construction for Real-Time Ray
// Tracing of Dynamic Geometry", HPG 2010.

#include <span>

#include "accel/bvh_builder.h"

namespace spinel {

struct GrainBvhOptions {
    std::uint32_t leaf = 4;  // primitives at most, and tested at once; at most kernels::BVH_MAX_LEAF
};

// As build_bvh(): siblings adjacent behind their parents, the same treatment of unusable boxes, independent of the
// number of threads. Statistics are left to whoever needs them (bvh_statistics).
Bvh build_grain_bvh(std::span<const Box> boxes, const GrainBvhOptions& options = {});

}  // namespace spinel
