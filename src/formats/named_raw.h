#pragma once
// Samples without a header, `.raw` or `.raw.gz`, whose name tells size and type as the Open SciVis Datasets do:
// engine_256x256x128_uint8.raw. Types are uint8, int8, uint16, int16, uint32, int32, float32, float64, also u8 … f64;
// numbers are little-endian, x fastest, one unit apart. A `.nhdr` (nrrd.h) beside a raw file says more.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_named_raw(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
