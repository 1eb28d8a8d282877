#pragma once
// Groups of a few boxes that lie close together, found by sorting: boxes stand along a Morton curve through their
// centres, which is cut where the bits of the curve change most until no group is larger than asked for. Lauterbach et
// al., "Fast BVH Construction on GPUs", Eurographics 2009.

#include <span>
#include <vector>

#include "accel/bvh_builder.h"

namespace spinel {

struct MortonGrain {
    std::uint32_t begin, end;  // in the order
};

struct MortonGrains {
    std::vector<std::uint32_t>
        order;                        // of boxes along the curve; those that are not finite or not ordered are left out
    std::vector<MortonGrain> grains;  // in that order, of 1 … `most` boxes
};

// Independent of the number of threads. At most BVH_MAX_PRIMITIVES boxes.
MortonGrains morton_grains(std::span<const Box> boxes, std::uint32_t most);
// Of the boxes of triangles.
MortonGrains morton_grains(std::span<const kernels::Triangle> triangles, std::uint32_t most);

}  // namespace spinel
