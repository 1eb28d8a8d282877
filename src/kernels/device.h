#ifndef SPINEL_KERNELS_DEVICE_H
#define SPINEL_KERNELS_DEVICE_H
// What the physics asks of a device: rays against the scene. The reference walks (traverse.h) define these for every
// device; a device with faster walks of its own defines SPINEL_DEVICE_TRAVERSAL before it includes a kernel and
// supplies them.
#include "scene_view.h"
KERNELS_BEGIN

const uint TRACE_SOLID = 1u;         // instances that stop light for sure
const uint TRACE_PASS_THROUGH = 2u;  // instances flagged INSTANCE_PASS_THROUGH
const uint TRACE_ALL = 3u;

// The nearest hit in (t_min, t_max) among the instances that the mask admits.
FN Hit trace_closest(const_in(SceneView) scene, Ray ray, uint mask);

// Whether anything that stops light for sure lies in (t_min, t_max).
FN bool trace_occluded(const_in(SceneView) scene, Ray ray);

KERNELS_END
#endif
