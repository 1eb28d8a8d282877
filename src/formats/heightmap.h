#pragma once
// Terrain from heights: a column of voxels for each sample, coloured by height and steepness. Only the shell that can
// be seen from above and from the sides is filled.
//
// .hgt (and .hgt.gz), the SRTM's tiles: big-endian metres, as many rows as columns, from the north. Without options it
// is true to scale, x east, y up, z south, in metres; voxels are then eight times as wide as high. Pictures are
// heightmaps only when LoadOptions::heightmap says so: black is 0, white that many voxels high; colours count by their
// mean.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_hgt(const std::filesystem::path& path, const LoadOptions& options = {});
Result<Scene> load_heightmap(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
