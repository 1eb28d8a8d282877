#pragma once
// From a tree of voxels, its looks, or an SDF to the arrays that kernels/voxels.h walks.

#include <cstdint>
#include <vector>

#include "geometry/sdf/sdf_builder.h"
#include "spinel/scene.h"

namespace spinel {

// Appends the tree's arrays and tells where they stand.
kernels::VoxelGrid append_voxels(const VoxelTree& tree, std::vector<kernels::VoxelNode>& nodes,
                                 std::vector<std::uint32_t>& words);

// Rounded edges and waves: what of its cell a voxel fills.
void append_shapes(const VoxelGeometry& voxels, kernels::VoxelGrid& grid, std::vector<float>& floats);

void append_outlines(const VoxelOutlines& outlines, kernels::VoxelGrid& grid, std::vector<float>& floats);

// The cells whose middle lies in the bounds of the SDF, number `sdf` of the scene's.
Result<kernels::VoxelGrid> append_sdf_voxels(const SdfVoxelGeometry& voxels, const kernels::Sdf& bounds,
                                             std::uint32_t sdf, std::vector<float>& floats);

// Radius of the edges of a palette index.
float rounding_of(const VoxelGeometry& voxels, std::size_t palette);

}  // namespace spinel
