#ifndef SPINEL_KERNELS_WHITTED_H
#define SPINEL_KERNELS_WHITTED_H
// The tree of rays of Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980: where a surface
// is a mirror or clear glass, or has a clear coat, the reflected and the refracted ray are both followed; everything
// else gets light straight from its sources, as `direct` has it, by a shadow ray and by one that is looked at for what
// emits alone. No light goes from wall to wall, and there are no caustics. What reflects and refracts is free of noise.
//
// The stages of the path tracer do the work, so that nested dielectrics, media and opacity are what they are there.
#include "path.h"
KERNELS_BEGIN

const int WHITTED_DEPTH = 64;              // reflections and refractions in a row, where the settings know no limit
const float WHITTED_FORKS = 1.0f / 32.0f;  // a ray that carries less of the picture goes one way, chosen by chance
const uint WHITTED_PENDING = 24u;
const uint WHITTED_RAYS = 4096u;  // of one sample: a safety bound, counted

FN float whitted_carried(const_in(PathState) state) {
    return max_component(state.weights.throughput) * state.eta_scale / average(state.weights.r_path);
}

FN PixelSample whitted(const_in(SceneView) scene, const_in(PathSettings) settings, const_in(PathState) camera,
                       Hit hit) {
    PathSettings tree = settings;
    tree.max_bounces = settings.max_bounces < 0 ? WHITTED_DEPTH : settings.max_bounces;
    tree.roulette_start = tree.max_bounces + 1;  // no path ends by chance
    PathState pending[WHITTED_PENDING];
    pending[0] = camera;
    uint count = 1u;
    vec3 radiance = vec3(0.0f);
    FirstHit first = camera.first;
    bool bound_reached = false;
    for (uint i = 0u; i < WHITTED_RAYS && count > 0u; ++i) {
        --count;
        PathState from = pending[count];
        if (i > 0u) hit = path_extend(scene, from);
        path_beside(scene, tree, from, hit);
        bool may_fork = whitted_carried(from) >= WHITTED_FORKS && count + 2u <= WHITTED_PENDING;
        PathState one = from;
        if (may_fork) one.flags |= PATH_TAKES_MIRROR;
        path_step(scene, tree, one, hit);
        bool forked = (one.flags & PATH_FORKED) != 0u;
        one.flags &= ~(PATH_TAKES_MIRROR | PATH_FORKED);
        if (first.object == NONE) first = one.first;
        bool scattered = one.bounces > from.bounces;
        if (scattered && (one.flags & (PATH_ALIVE | PATH_SPECULAR)) == PATH_ALIVE) {
            PathSettings seen = tree;
            seen.max_bounces = one.bounces;
            path_follow(scene, seen, one, path_extend(scene, one));
        }
        radiance += one.radiance;
        one.radiance = vec3(0.0f);
        if ((one.flags & PATH_BOUND_REACHED) != 0u) bound_reached = true;

        PathState other = from;
        other.flags &= ~PATH_ALIVE;
        if (forked) {  // what the step gathers has been counted
            other.flags |= PATH_ALIVE | PATH_LEAVES_MIRROR;
            path_shade(scene, tree, other, hit);
            other.flags &= ~PATH_LEAVES_MIRROR;
            other.radiance = vec3(0.0f);
            if ((other.flags & (PATH_ALIVE | PATH_SPECULAR)) == PATH_ALIVE) {
                PathSettings seen = tree;
                seen.max_bounces = other.bounces;
                path_follow(scene, seen, other, path_extend(scene, other));
                radiance += other.radiance;
                other.radiance = vec3(0.0f);
            }
            if ((other.flags & PATH_BOUND_REACHED) != 0u) bound_reached = true;
        }
        // The one that carries less comes first: it can fork less often, so that few rays wait.
        bool other_first = whitted_carried(other) < whitted_carried(one);
        for (uint k = 0u; k < 2u; ++k) {
            if ((k == 0u) == other_first) {
                if ((one.flags & PATH_ALIVE) != 0u) {
                    pending[count] = one;
                    ++count;
                }
            } else if ((other.flags & PATH_ALIVE) != 0u) {
                pending[count] = other;
                ++count;
            }
        }
    }
    return PixelSample(radiance, first, bound_reached || count > 0u);
}

KERNELS_END
#endif
