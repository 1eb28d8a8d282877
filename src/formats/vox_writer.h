#pragma once
// Writes MagicaVoxel files (.vox, version 150): what load_vox reads again.
//
// Every voxel object becomes one or several models of at most 256 cells along an edge, placed by a scene graph. Objects
// must stand on the lattice: whole-numbered, turned by right angles, all of one scale; a scene that holds something
// else than voxels is refused. There is one palette of 255 colours of 8 bits; more are drawn together by how they look.
// What else a file has no words for (parameters of materials, textures, lights) is left out, and a note says so.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"

namespace spinel {

// Notes: none, or one sentence that names all that was left out or changed.
Result<Notes> save_vox(const Scene& scene, const std::filesystem::path& path);

}  // namespace spinel
