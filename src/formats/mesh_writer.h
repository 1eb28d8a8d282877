#pragma once
// Meshes to files. Objects are written in the space of the world, instances one by one. Textures cannot be written, and
// objects that are not meshes are refused.
//
// .obj: a group for each object; materials in a .mtl beside it: colour, emission, opacity, index of refraction, and
// roughness and metallic as the PBR extension of MTL has them.
// .ply: binary, triangles; material and vertex colours become 8-bit sRGB colours of vertices.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"

namespace spinel {

Result<Notes> save_obj(const Scene& scene, const std::filesystem::path& path);
Result<Notes> save_ply(const Scene& scene, const std::filesystem::path& path);

}  // namespace spinel
