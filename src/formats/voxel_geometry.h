#pragma once
// From the cells that a reader found to the scene's voxel geometry: the one place that knows how it is held.

#include <string>
#include <vector>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

constexpr std::size_t MAX_VOXELS = std::size_t(1) << 26;  // that a reader may list, so that memory stays bounded

// Every point lies inside size.
Result<Geometry> voxel_geometry(std::string name, ivec3 size, std::vector<VoxelPoint> points);

// The cells that are not empty.
std::vector<VoxelPoint> voxel_points(const VoxelGeometry& geometry);

}  // namespace spinel
