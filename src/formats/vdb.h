#pragma once
// OpenVDB files: sets of voxels, written and read here, or volumes (vdb_volume.h).
//
// An active voxel is a solid one; an integer value from 1 to 65535 is its palette index, any other value counts as 1.
// The grid's transform places the set; in OpenVDB a voxel's place is its centre. Grids that Spinel writes (Int32) also
// carry their size and their materials as metadata: "spinel_size", and "spinel_materials", a scene file. The voxels of
// other grids get a colour for each palette index.
//
// A file is read as voxels if all of its grids are of integers, of bits or masks. A grid of floats makes it a volume,
// unless LoadOptions::voxels asks for voxels. Points are refused.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_vdb(const std::filesystem::path& path, const LoadOptions& options);

// One grid for each object, all of which must be voxels with a surface and without textures.
Result<Notes> save_vdb(const Scene& scene, const std::filesystem::path& path);

}  // namespace spinel
