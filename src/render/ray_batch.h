#pragma once
// Many rays against the scene at once, in the way that suits them and the device. As kernels::trace_closest and
// trace_any for each, bit for bit; like the walks of kernels/device.h, defined where the device is (devices/cpu).

#include <span>

#include "kernels/device.h"

namespace spinel {

// Of rays that are neighbours, the best order is theirs in blocks of 4×2, of 8×8.
void device_batch_closest(const kernels::SceneView& scene, std::span<const kernels::Ray> rays, kernels::uint mask,
                          kernels::Hit* hits);

// A hit tells only whether there is one: is_hit().
void device_batch_any(const kernels::SceneView& scene, std::span<const kernels::Ray> rays, kernels::uint mask,
                      kernels::Hit* hits);

}  // namespace spinel
