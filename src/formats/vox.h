#pragma once
// MagicaVoxel (.vox): every model at its place, every used palette entry a material.
//
// Each model that is placed becomes a VoxelGeometry in the file's own cell order (z up); its objects turn it
// to y up and carry the scene graph's rotations and translations, so one model may be placed many times.
// Hidden nodes and layers are left out. Of animations one frame is taken: that is also a model of a file without a
// scene graph. Light, ground, fog and cameras are those of vox_settings.h. Cells of a cloud material have no surface:
// they become a geometry and an object of their own, whose interior is the medium.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_vox(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
