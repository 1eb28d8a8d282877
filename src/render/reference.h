#pragma once
// The naive twin of kernels/traverse.h: every instance, every primitive, in double precision, right by
// reading. Slow. Tests compare everything clever with it.

#include "kernels/device.h"

namespace spinel {

// What the twin knows of the nearest hit, t and the surface's position unrounded.
struct ReferenceHit {
    double t = 0;
    kernels::Hit hit = {};  // instance NONE: a miss
};

ReferenceHit reference_hit(const kernels::SceneView& scene, const kernels::Ray& ray, kernels::uint mask);

// As rows of the table of accelerators.
kernels::Hit brute_force_closest(const kernels::SceneView& scene, const kernels::Ray& ray, kernels::uint mask);
bool brute_force_any(const kernels::SceneView& scene, const kernels::Ray& ray, kernels::uint mask);

}  // namespace spinel
