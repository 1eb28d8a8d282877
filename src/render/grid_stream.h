#pragma once
// Whole batches of rays through uniform grids together (kernels/grid_stream.h).

#include <span>
#include <vector>

#include "kernels/device.h"
#include "spinel/trace.h"

namespace spinel {

// Hits of all rays, as kernels::trace_closest (or, for `any`, some hit of each) gives them one by one. All meshes of
// the scene have to be built into "grid". Counts of states are added to `passes`.
void stream_trace(const kernels::SceneView& scene, std::span<const kernels::Ray> rays, kernels::uint mask, bool any,
                  kernels::Hit* hits, std::vector<StreamPass>& passes);

}  // namespace spinel
