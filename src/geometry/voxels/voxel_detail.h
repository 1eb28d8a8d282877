#pragma once
// A voxel set with less detail where less can be seen.

#include <functional>

#include "spinel/voxels.h"

namespace spinel {

// Cubes of the tree of 4³, 16³ … voxels for which `coarse` says so become one solid cube, of the palette index that
// most of their voxels have (of several the lowest), if they hold voxels for which `plain` says so and no others. What
// is thin grows by that, at most to the size of such a cube, but nothing gets holes. Cubes that reach out of the set
// stay as they are, and so do sets with shared subtrees. `coarse` is asked from large to small.
struct VoxelDetail {
    std::function<bool(ivec3 lower, int edge)> coarse;
    std::function<bool(std::uint16_t palette)> plain;
};
VoxelTreePointer with_less_detail(const VoxelTree& tree, const VoxelDetail& detail);

}  // namespace spinel
