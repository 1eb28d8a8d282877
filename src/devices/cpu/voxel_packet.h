#pragma once
// Neighbours among rays, eight at a time (AVX2).

#ifdef __AVX2__

#include "devices/cpu/ray_columns.h"

namespace spinel {

// Whether the rays in `lanes`, the first of the eight among them or not, are of one octant and so near to the first
// that they are better off as a packet.
bool are_neighbours(const RayColumns& ray, unsigned lanes);

// For rays of one octant: as cpu_voxels_closest8. `ray` are the columns of `rays`.
unsigned packet_closest(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                        kernels::uint instance, const RayColumns& ray, const kernels::Ray* rays, unsigned lanes,
                        kernels::Hit* hits);

}  // namespace spinel

#endif
