#pragma once
// A volume's surface, as kernels/sdf.h walks it: the solid where the look-up is below a level (or above it), cut off at
// the outermost samples. In the index space of the grid, so that lengths are in samples, whatever the grid's transform.
//
// The Lipschitz bound: linear and cubic look-ups are convex combinations of samples, and so is each component of their
// gradient of differences between neighbours. Where the greatest difference near the surface along x, y and z is dx, dy
// and dz, no gradient is longer than √(dx² + dy² + dz²); values are divided by that and are distances, or less.

#include <cstdint>
#include <vector>

#include "core/result.h"
#include "geometry/sdf/sdf_builder.h"

namespace spinel {

// Of view.grids.at[grid], which is one of `words` and `floats` and not looked up by its nearest sample. Appends the
// table of kernels/sdf_grid.h to `words`; the tape refers to it. An error says what is wrong with the samples.
Result<SdfData> build_surface(const VolumeGeometry& volume, const kernels::DensityGrid& record, kernels::uint grid,
                              std::vector<std::uint32_t>& words, const std::vector<float>& floats);

}  // namespace spinel
