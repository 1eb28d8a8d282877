#ifndef SPINEL_KERNELS_INTEGRATORS_H
#define SPINEL_KERNELS_INTEGRATORS_H
// What a sample of a pixel can be. To add an integrator: a function here or in a header of its own, and one row in
// integrator_table.h; the devices, `spinel list integrators`, the scene file and the command line follow from it.
#include "integrator_table.h"
#include "path.h"
#include "preview_ao.h"
#include "preview_cone.h"
#include "preview_faces.h"
KERNELS_BEGIN

FN PixelSample integrate_path(const_in(SceneView) scene, const_in(PathSettings) settings, uvec2 pixel, uint index) {
    PathState state = trace_path(scene, settings, pixel, index);
    return PixelSample(state.radiance, state.first, (state.flags & PATH_BOUND_REACHED) != 0u);
}

// Shading normals of what is seen first, mapped from [-1, 1] to [0, 1].
FN PixelSample integrate_normals(const_in(SceneView) scene, const_in(PathSettings) settings, uvec2 pixel, uint index) {
    PathSettings seen = PathSettings(settings.seed, 0, 0.0f, 0, settings.preview);
    PathState state = trace_path(scene, seen, pixel, index);
    vec3 color = state.first.object == NONE ? vec3(0.0f) : 0.5f * state.first.normal + 0.5f;
    return PixelSample(color, state.first, (state.flags & PATH_BOUND_REACHED) != 0u);
}

// The previews take the camera ray and its first hit (preview_shade.h).
#define SPINEL_PREVIEW(call)                                     \
    Sampler numbers = make_sampler(pixel, index, settings.seed); \
    vec2 u_film = sampler_2d(numbers);                           \
    vec2 u_lens = sampler_2d(numbers);                           \
    Ray ray = camera_ray(scene.camera, pixel, u_film, u_lens);   \
    Hit first = trace_closest(scene, ray, TRACE_ALL);            \
    return call;
FN PixelSample integrate_ao(const_in(SceneView) scene, const_in(PathSettings) settings, uvec2 pixel, uint index){
    SPINEL_PREVIEW(preview_ao(scene, settings.preview, ray, first, numbers))} FN PixelSample
    integrate_faces(const_in(SceneView) scene, const_in(PathSettings) settings, uvec2 pixel,
                    uint index){SPINEL_PREVIEW(preview_faces(scene, settings.preview, ray, first))} FN PixelSample
    integrate_cone(const_in(SceneView) scene, const_in(PathSettings) settings, uvec2 pixel,
                   uint index){SPINEL_PREVIEW(preview_cone(scene, settings.preview, ray, first, numbers))}
#undef SPINEL_PREVIEW

FN PixelSample
    integrate(const_in(SceneView) scene, const_in(PathSettings) settings, uint integrator, uvec2 pixel, uint index) {
#define SPINEL_INTEGRATOR_CASE(number, name, needs, doc) \
    if (integrator == number) return integrate_##name(scene, settings, pixel, index);
    SPINEL_INTEGRATORS(SPINEL_INTEGRATOR_CASE)
#undef SPINEL_INTEGRATOR_CASE
    return PixelSample(vec3(0.0f), FirstHit(vec3(0.0f), 0.0f, vec3(0.0f), NONE), false);
}

KERNELS_END
#endif
