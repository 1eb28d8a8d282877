#pragma once
// Voxels as they look from afar, for every node of a tree: see kernels/voxel_mip.h.

#include <span>
#include <vector>

#include "kernels/voxel_mip.h"
#include "spinel/voxels.h"

namespace spinel {

struct VoxelMips {
    std::vector<kernels::VoxelMip> palette;  // of the root, then of each palette index from 1 on
    std::vector<kernels::VoxelMip> nodes;    // in the order of the tree's
};

// looks[p − 1] is that of a voxel of palette index p. Does not depend on where a node stands, so shared subtrees keep
// their one mip.
VoxelMips build_voxel_mips(const VoxelTree& tree, std::span<const kernels::VoxelLook> looks);

}  // namespace spinel
