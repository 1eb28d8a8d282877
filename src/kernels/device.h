#ifndef SPINEL_KERNELS_DEVICE_H
#define SPINEL_KERNELS_DEVICE_H
// What the physics asks of the scene: rays against it (traverse.h). And what that asks of a device: rays against one
// geometry, where a device knows a faster way. Shaders use the kernels' own walks; the CPU's are in devices/cpu, where
// alone these functions are defined for C++. Whatever the walk, the answer is the same, bit for bit.
#include "scene_view.h"
KERNELS_BEGIN

const uint TRACE_SOLID = 1u;         // instances that stop light for sure
const uint TRACE_PASS_THROUGH = 2u;  // instances flagged INSTANCE_PASS_THROUGH
const uint TRACE_ALL = 3u;

// The nearest hit in (t_min, t_max) among the instances that the mask admits; of hits at the same t, that of the first
// instance.
FN Hit trace_closest(const_in(SceneView) scene, Ray ray, uint mask);

// Whether anything of those instances lies in (t_min, t_max).
FN bool trace_any(const_in(SceneView) scene, Ray ray, uint mask);

// Whether anything that stops light for sure lies in (t_min, t_max).
FN bool trace_occluded(const_in(SceneView) scene, Ray ray);

// The nearest interface of a set of voxels in (ray.t_min, hit.t), as voxels_closest() of voxels.h.
void device_voxels_closest(const_in(SceneView) scene, uint grid, uint slot_first, Ray ray, inout(Hit) hit);

KERNELS_END
#endif
