#pragma once
// Rays against a set of voxels on the CPU: one by one, eight neighbours at a time, or any number in any order. All find
// what kernels::voxels_closest finds, bit for bit; on machines without the instructions that they need they are that
// function.

#include <span>

#include "devices/cpu/packet_trace.h"
#include "kernels/voxels.h"

namespace spinel {

// Writes to `hit` what is nearer than hit.t.
void cpu_voxels_closest(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                        const kernels::Ray& ray, kernels::Hit& hit);

// What that costs a ray: nodes that it looks into, the root among them, and cubes of one palette index that it meets.
// Nothing is counted where the ray starts in something, or where this walk is the kernel's.
struct VoxelWalkCount {
    kernels::uint nodes = 0;
    kernels::uint cubes = 0;
};
VoxelWalkCount cpu_voxels_count(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                                const kernels::Ray& ray);

// Those that follow write `instance` to what they find.

// As that for each of eight rays whose bit is set in `lanes`; returns those that found something.
unsigned closest_one_by_one(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                            kernels::uint instance, const kernels::Ray* rays, unsigned lanes, kernels::Hit* hits);

// The same in the way that suits them: neighbours as a packet, others as a stream.
unsigned cpu_voxels_closest8(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                             kernels::uint instance, const kernels::Ray* rays, unsigned lanes, kernels::Hit* hits);

// Any number of rays in any order, each answered whole: its hit, or none before its t_max. Groups of eight that are
// neighbours go as packets, what is between them as streams.
void cpu_voxels_closest_batch(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                              kernels::uint instance, std::span<const kernels::Ray> rays, kernels::Hit* hits);

// The same, all of them as one stream.
void cpu_voxels_closest_stream(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                               kernels::uint instance, std::span<const kernels::Ray> rays, kernels::Hit* hits);

}  // namespace spinel
