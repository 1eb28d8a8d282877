#pragma once
// Luanti's schematics (.mts, versions 1 to 4). Nodes that are placed with some probability are there, those that never
// are not.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_mts(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
