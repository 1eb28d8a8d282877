#pragma once
// The arrays that kernels/grids.h reads, made of a grid's samples; and bounds of what look-ups give.

#include <cstdint>
#include <vector>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

// Appends the bricks to `words`, coarse bounds to `floats`. An error says what is wrong with the samples.
Result<kernels::DensityGrid> append_grid(const Grid& grid, std::vector<std::uint32_t>& words,
                                         std::vector<float>& floats);

struct ValueBounds {
    float least = 0;
    float most = 0;
};

// Bounds of all look-ups at lower ≤ p < upper in index space, which must meet the box, by every sample that they read.
ValueBounds grid_bounds(const kernels::SceneView& view, const kernels::DensityGrid& grid, vec3 lower, vec3 upper);

}  // namespace spinel
