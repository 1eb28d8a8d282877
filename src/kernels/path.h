#ifndef SPINEL_KERNELS_PATH_H
#define SPINEL_KERNELS_PATH_H
// The path tracer as a state machine. A device may run its four stages as one kernel (path_follow below) or as separate
// kernels over queues of states:
//
//   path_generate   a camera ray (path_state.h)
//   path_extend     the nearest hit along it
//   path_shade      medium or surface: emission, next-event estimation (asks for a Connection), a new direction
//   path_connect    the shadow ray, through media and past interfaces
//
// Unidirectional path tracing with next-event estimation and multiple importance sampling (Veach 1997, balance
// heuristic in the one-sample form of Miller, Georgiev, Jarosz 2019 so that volumes and colour channels join in; see
// medium.h).
#include "path_connect.h"
#include "path_shade.h"
#include "path_state.h"
KERNELS_BEGIN

// Shades the hit at the end of a path's ray, and connects.
FN void path_step(const_in(SceneView) scene, const_in(PathSettings) settings, inout(PathState) state,
                  const_in(Hit) hit) {
    Connection c = path_shade(scene, settings, state, hit);
    if (c.valid && !trace_occluded(scene, c.ray))
        state.radiance += clamped(settings, state.bounces, path_connect(scene, settings, state, c));
}

// Follows a path from the hit at the end of its ray to its own end.
FN void path_follow(const_in(SceneView) scene, const_in(PathSettings) settings, inout(PathState) state, Hit hit) {
    for (uint i = 0u; i <= MAX_PATH_SEGMENTS && (state.flags & PATH_ALIVE) != 0u; ++i) {
        if (i > 0u) hit = path_extend(scene, state);
        path_beside(scene, settings, state, hit);
        path_step(scene, settings, state, hit);
    }
}

KERNELS_END
#endif
