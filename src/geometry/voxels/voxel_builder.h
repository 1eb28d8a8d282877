#pragma once
// From a tree of voxels to the arrays that kernels/voxels.h walks.

#include <cstdint>
#include <vector>

#include "spinel/voxels.h"

namespace spinel {

// Appends the tree's arrays and tells where they stand.
kernels::VoxelGrid append_voxels(const VoxelTree& tree, std::vector<kernels::VoxelNode>& nodes,
                                 std::vector<std::uint32_t>& words);

}  // namespace spinel
