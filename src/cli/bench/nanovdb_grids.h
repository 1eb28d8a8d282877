// Grids of NanoVDB, for the peers of `spinel bench`.

#pragma once

#include <nanovdb/util/GridHandle.h>

#include <cstddef>

#include "spinel/grid.h"
#include "spinel/voxels.h"

namespace spinel::cli {

// Active where the set is occupied (ValueMask).
nanovdb::GridHandle<> nanovdb_mask(const VoxelTree& tree);

// Voxel (i, j, k) is sample (i, j, k), of the first channel; what differs from the background is active, and counted.
nanovdb::GridHandle<> nanovdb_floats(const GridSamples& samples, float background, std::size_t& active_count);

}  // namespace spinel::cli
