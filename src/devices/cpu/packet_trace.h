#pragma once
// Eight coherent rays against the scene on the CPU: as kernels::trace_closest and trace_any for each, bit for bit.
// Where sets of voxels and wide hierarchies of meshes stand they go together.

#include "kernels/scene_view.h"

namespace spinel {

// As many rays as go together.
inline constexpr int packet_size = 8;

// Rays whose bit is set in `lanes`; the others' hits are left alone.
void cpu_trace_closest8(const kernels::SceneView& scene, const kernels::Ray rays[packet_size], unsigned lanes,
                        kernels::uint mask, kernels::Hit hits[packet_size]);

// Which of them meet anything.
unsigned cpu_trace_any8(const kernels::SceneView& scene, const kernels::Ray rays[packet_size], unsigned lanes,
                        kernels::uint mask);

}  // namespace spinel
