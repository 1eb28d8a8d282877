#pragma once
// Scene files: JSON in, validated Scene out. docs/scene.md describes them.

#include <filesystem>
#include <functional>
#include <string_view>

#include "core/result.h"
#include "image/pixels.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

// How files that a scene names are read; the reader itself knows no format. Paths are absolute or relative to
// the working directory, already joined with the scene file's folder.
struct SceneLoaders {
    std::function<Result<Scene>(const std::filesystem::path&, const LoadOptions&)> model;  // meshes, voxels, volumes
    std::function<Result<PixelBuffer>(const std::filesystem::path&)> pixels;               // textures, environments
};

// `file` names the text in messages; its folder is where relative paths start. An animation is seen at the moment.
Result<Scene> read_scene_json(std::string_view text, const std::filesystem::path& file, const SceneLoaders& loaders,
                              const Moment& moment = {});

}  // namespace spinel
