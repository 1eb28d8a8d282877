#pragma once
// Mitsuba's grid volumes, `.vol` of version 3: floats, bytes (0 … 1) or halves in a box, of one channel or of three.
//
//   https://mitsuba.readthedocs.io/en/stable/src/generated/plugins_volumes.html

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_mitsuba_volume(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
