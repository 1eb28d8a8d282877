#pragma once
// Voxel formats whose cells carry plain colours:
//   .qb      Qubicle: matrices with names and places, packed or not
//   .kv6     Voxlap and SLAB6: the surface of one object
//   .binvox  Patrick Min's: solid or empty, packed
// Each colour becomes a diffuse material; sets of more colours than a palette has are refused.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_qubicle(const std::filesystem::path& path, const LoadOptions& options = {});
Result<Scene> load_kv6(const std::filesystem::path& path, const LoadOptions& options = {});
Result<Scene> load_binvox(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
