#pragma once
// Volumes in NanoVDB files (major version 32 of the format, as NanoVDB 10 writes it): grids of floats, doubles, their
// quantised forms (Fp4, Fp8, Fp16, FpN) and vectors of three, plain or packed by zip or blosc. Level sets become fog.
// Other grids are left out, and said.
//
// NanoVDB maps its files into memory and trusts every offset in them. Here each one is checked before it is followed.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_nvdb(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
