#pragma once
// Triangle meshes through Assimp: OBJ with MTL, PLY, STL, OFF, glTF 2.0.
//
// Each mesh of the file becomes one geometry; each reference to it by a node one object. Polygons are cut
// into triangles, points and lines are left out. Where a file has no normals they are made smooth with
// creases at 60° (not for glTF, whose rule is flat); an STL's own are ignored, since they are flat by nature.
// Where there are texture coordinates there are tangents. Of glTF, cameras and punctual lights are read;
// animation and skins are not.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_mesh(const std::filesystem::path& path, const LoadOptions& options = {});
Result<Scene> load_gltf(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
