#ifndef SPINEL_KERNELS_INTEGRATORS_H
#define SPINEL_KERNELS_INTEGRATORS_H
// What a sample of a pixel can be: an integrator takes the state of a camera ray and its first hit. To add one: a
// function here or in a header of its own, and one row in integrator_table.h; the devices, `spinel list integrators`,
// the scene file and the command line follow from it.
#include "dvr.h"
#include "heatmap.h"
#include "integrator_table.h"
#include "path.h"
#include "preview_ao.h"
#include "preview_cone.h"
#include "preview_faces.h"
#include "single_scatter.h"
#include "whitted.h"
KERNELS_BEGIN

FN PixelSample path_sample(const_in(PathState) state) {
    return PixelSample(state.radiance, state.first, (state.flags & PATH_BOUND_REACHED) != 0u);
}

FN PixelSample integrate_path(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state, Hit hit) {
    path_follow(scene, settings, state, hit);
    return path_sample(state);
}

// The first thing that is seen, without light from elsewhere.
FN void see_first(const_in(SceneView) scene, const_in(PathSettings) settings, inout(PathState) state, Hit hit) {
    PathSettings seen = settings;
    seen.max_bounces = 0;
    path_follow(scene, seen, state, hit);
}

// Shading normals of what is seen first, mapped from [-1, 1] to [0, 1].
FN PixelSample integrate_normals(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state, Hit hit) {
    see_first(scene, settings, state, hit);
    vec3 color = state.first.object == NONE ? vec3(0.0f) : 0.5f * state.first.normal + 0.5f;
    return PixelSample(color, state.first, (state.flags & PATH_BOUND_REACHED) != 0u);
}

FN PixelSample integrate_ao(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state, Hit hit) {
    return preview_ao(scene, settings.preview, state.ray, hit, state.numbers);
}

FN PixelSample integrate_faces(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state, Hit hit) {
    return preview_faces(scene, settings.preview, state.ray, hit);
}

FN PixelSample integrate_cone(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state, Hit hit) {
    return preview_cone(scene, settings.preview, state.ray, hit, state.numbers);
}

FN PixelSample integrate_single_scatter(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state,
                                        Hit hit) {
    return single_scatter(scene, settings.march, state.ray, state.inside, hit, state.numbers);
}

FN PixelSample integrate_dvr(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state, Hit hit) {
    return dvr(scene, settings.dvr, state.ray, hit, state.numbers);
}

FN PixelSample integrate_whitted(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state, Hit hit) {
    return whitted(scene, settings, state, hit);
}

FN PixelSample integrate_direct(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state, Hit hit) {
    PathSettings once = settings;
    once.max_bounces = settings.max_bounces < 0 ? 1 : min(settings.max_bounces, 1);
    path_follow(scene, once, state, hit);
    return path_sample(state);
}

// From white at the camera to black at the end of what is gauged; black where nothing is.
FN PixelSample integrate_depth(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state, Hit hit) {
    see_first(scene, settings, state, hit);
    float near = state.first.object == NONE ? 0.0f : max(1.0f - state.first.depth / settings.gauge.depth_end, 0.0f);
    return PixelSample(vec3(near), state.first, (state.flags & PATH_BOUND_REACHED) != 0u);
}

FN PixelSample integrate_heatmap(const_in(SceneView) scene, const_in(PathSettings) settings, PathState state, Hit hit) {
    Ray ray = state.ray;
    see_first(scene, settings, state, hit);
    return PixelSample(heatmap(scene, settings.gauge, ray), state.first, (state.flags & PATH_BOUND_REACHED) != 0u);
}

FN PixelSample integrate(const_in(SceneView) scene, const_in(PathSettings) settings, uint integrator,
                         const_in(PathState) state, const_in(Hit) hit) {
#define SPINEL_INTEGRATOR_CASE(number, name, text, needs, doc) \
    if (integrator == number) return integrate_##name(scene, settings, state, hit);
    SPINEL_INTEGRATORS(SPINEL_INTEGRATOR_CASE)
#undef SPINEL_INTEGRATOR_CASE
    return PixelSample(vec3(0.0f), FirstHit(vec3(0.0f), 0.0f, vec3(0.0f), NONE), false);
}

KERNELS_END
#endif
