#pragma once
// From implicit surfaces and volumes to voxels: a cell is solid when the field says so at its centre.

#include "geometry/sdf/sdf_builder.h"
#include "geometry/voxels/voxelise.h"
#include "spinel/scene.h"
#include "spinel/voxels.h"

namespace spinel {

// Cells of the frame whose centre lies inside of the solid. Whole boxes are told from one evaluation by the tape's
// Lipschitz bound: where |f| at a box's centre exceeds what f can change by to its corners, its sign is that of all
// cells. `data` outlives the function.
VoxelFunction sdf_voxels(const SdfData& data, const VoxelFrame& frame, const mat4x3& world_to_object,
                         std::uint16_t palette);

// Cells at whose centre the grid, linear between its samples or not as its filter says, is at least `threshold`, which
// is above 0. Outside of its box a grid is 0. `grid` outlives the function.
VoxelFunction volume_voxels(const Grid& grid, const VoxelFrame& frame, const mat4x3& world_to_object, float threshold,
                            std::uint16_t palette);

// The same of a volume's surface: cells at whose centre the grid is below `level`, or above it.
VoxelFunction solid_voxels(const Grid& grid, const VoxelFrame& frame, const mat4x3& world_to_object, float level,
                           bool above, std::uint16_t palette);

}  // namespace spinel
