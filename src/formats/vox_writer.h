#pragma once
// Writes MagicaVoxel files (.vox, version 150): what load_vox reads again.
//
// Every voxel object becomes one or several models of at most 256 cells along an edge, placed by a scene graph. Objects
// must stand on the lattice: whole-numbered, turned by right angles, all of one scale. There is one palette of 255
// colours of 8 bits; a scene that needs more, or that holds something else than voxels, is refused.

#include <filesystem>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

Result<void> save_vox(const Scene& scene, const std::filesystem::path& path);

}  // namespace spinel
