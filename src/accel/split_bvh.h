#pragma once
// Builds binary hierarchies for walks that test several primitives at once, and
// where it pays lets two leaves share a primitive, each bounding its own part
// of it: spatial splits (Stich, Friedrich, Dietrich, "Spatial Splits in
// Bounding Volume Hierarchies", HPG 2009). Scans of fine triangles gain nothing
// by them; walls that stand aslant to the axes do. So they are tried only where
// the children of the best other split overlap much.

#include <cstdint>
#include <functional>
#include <span>

#include "accel/bvh_builder.h"

namespace spinel {

struct SplitBvhOptions {
    std::uint32_t block = 4;     // primitives that are tested at once: leaves are
                                 // priced by blocks; a power of two
    std::uint32_t max_leaf = 4;  // at most kernels::BVH_MAX_LEAF; no node with at
                                 // most `min_leaf` is split
    std::uint32_t min_leaf = 4;
    float traversal_cost = 1.0f;  // of one interior node, in tests of blocks
    int bin_count = 16;           // at most 32
    int max_depth = int(kernels::BVH_MAX_DEPTH);
    float spatial_growth = 0.0f;  // references beyond the number of primitives, as
                                  // a part of it; 0: none
    // Spatial splits are tried in nodes of so many references where the
    // children's boxes share so much of the node's area, and of the root's.
    std::uint32_t spatial_from = 64;
    float spatial_overlap = 0.1f;
    float spatial_overlap_of_all = 1e-4f;
};

// The part of a box in which a primitive lies on either side of a plane; either
// may be empty (lower > upper). Must hold all of the primitive that the box
// holds, in spite of rounding.
using ClipPrimitive =
    std::function<void(std::uint32_t primitive, const Box& box, int axis, float plane, Box& below, Box& above)>;

// As build_bvh(): the same order of nodes, the same treatment of unusable
// boxes, independent of the number of threads. With spatial splits `order`
// names some primitives more than once.
Bvh build_split_bvh(std::span<const Box> boxes, const SplitBvhOptions& options, const ClipPrimitive& clip = {});

}  // namespace spinel
