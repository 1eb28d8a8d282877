#pragma once
// Eight-wide hierarchies in less than half the memory (layout: kernels/mesh_compact.h): boxes in bytes, vertices once
// for the triangles of a block that share them. Both are exact where it counts: no box is smaller than it was, and
// vertices are the floats that they were.

#include "accel/wide_bvh.h"

namespace spinel {

// As collapse_bvh(); of eight triangles a block at most, and as many vertices. Addresses count in 28 bits, of steps of
// sixteen bytes: about 1.5·10⁸ triangles.
WideBvh compact_bvh(const Bvh& binary, std::span<const kernels::Triangle> triangles,
                    const WideBvhOptions& options = {});

}  // namespace spinel
