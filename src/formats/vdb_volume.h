#pragma once
// Volumes in OpenVDB files: grids of floats, doubles and vectors (of three floats or doubles), stored as such or as
// halves, with any affine transform. Level sets are surfaces. Other grids are left out, and said.
//
// In OpenVDB a voxel's index is its sample's place: grids keep their world, whatever part of it is stored.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

// The file's list of grids has been read (vdb_layout.h). OpenVDB's exceptions pass through.
Result<Scene> read_vdb_volumes(const std::filesystem::path& path, const LoadOptions& options);

}  // namespace spinel
