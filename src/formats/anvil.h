#pragma once
// Region files of Minecraft's worlds (Anvil, .mca): up to 32×32 chunks of blocks, of any version since 1.2: numeric
// ids, palettes whose indices span words (1.13 to 1.15) and palettes whose indices do not. Chunks are packed by gzip,
// zlib, LZ4 or not at all; those kept in files of their own (.mcc) are left out, and that is noted.
//
// Blocks stand at their place within the region: 0 … 511 along x and z, and at the world's height.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_anvil(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
