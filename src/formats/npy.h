#pragma once
// NumPy's .npy for ray batches. Format: numpy.org/doc/stable/reference/generated/numpy.lib.format.html

#include <filesystem>
#include <span>
#include <vector>

#include "core/result.h"
#include "spinel/trace.h"

namespace spinel {

// A little-endian float32 array of shape [N, 8] in C order: origin xyz, t_min, direction xyz, t_max.
Result<std::vector<TraceRay>> read_rays_npy(const std::filesystem::path& path);

// A structured array with the fields t, instance, primitive, u, v, nx, ny, nz, ix, iy, iz, material.
Result<void> write_hits_npy(const std::filesystem::path& path, std::span<const TraceHit> hits);

}  // namespace spinel
