#pragma once
// Rays against a set of voxels on the CPU, one by one or eight at a time. Both find what kernels::voxels_closest finds,
// bit for bit; on machines without the instructions that they need they are that function.

#include "kernels/voxels.h"

namespace spinel {

void cpu_voxels_closest(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                        const kernels::Ray& ray, kernels::Hit& hit);

// Rays that go together: neighbours in the picture, or from neighbouring places towards one light.
inline constexpr int packet_size = 8;

// For each of eight rays whose bit is set in `lanes`; returns those that found something nearer than their hit.t.
unsigned cpu_voxels_closest8(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                             const kernels::Ray* rays, unsigned lanes, kernels::Hit* hits);

}  // namespace spinel
