#pragma once
// Anything readable as a scene that can be rendered.

#include <filesystem>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

// A scene file (.json), or a model of any registered format. A model gets a camera, sun, sky and ground of
// its own; a scene file gets a camera if it has none, and nothing else. `size` (0, 0: the scene's film)
// decides what a fitted camera must frame.
Result<Scene> load_scene(const std::filesystem::path& path, ivec2 size = {0, 0});

}  // namespace spinel
