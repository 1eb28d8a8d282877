#ifndef SPINEL_KERNELS_PREVIEW_SHADE_H
#define SPINEL_KERNELS_PREVIEW_SHADE_H
// What the preview integrators have in common: the first surface that is worth showing, and the light on it.
//
// Their light is the scene's sun, its brightest directional light, and its sky, the mean of the environment above and
// below the horizon. Lamps are not looked at, but surfaces that emit are as bright as they are. A scene with neither is
// shown in the light of a studio (compile_preview.cpp). Glass is seen through without being bent, with the sky
// reflected in it and its absorption on the way; media are not seen.
#include "device.h"
#include "environment.h"
#include "path_settings.h"
#include "pixel_sample.h"
#include "random.h"
#include "surface.h"
#include "voxels.h"
KERNELS_BEGIN

const uint MAX_PREVIEW_LAYERS = 256u;  // glass, cut-out parts and boundaries of media before what is shown

struct PreviewView {
    bool found;  // false: nothing is there but the sky
    bool bound_reached;
    Ray ray;  // the last piece of the way
    Hit hit;
    Surface surface;
    Frame frame;  // of shading, z towards the viewer
    vec3 albedo;
    float distance;    // from the camera
    vec3 transmitted;  // by what was looked through
    vec3 before;       // radiance that came from it
    Ray first;         // the whole way
};

FN vec3 preview_sky(const_in(SceneView) scene, vec3 direction) {
    return mix(scene.preview_light.sky_below, scene.preview_light.sky_above, 0.5f + 0.5f * direction.y);
}

FN bool preview_is_glass(const_in(SceneView) scene, uint material) {
    return scene.materials.at[material].kind == MATERIAL_DIELECTRIC;
}

// Looks through a face of glass: what it reflects of the sky, what is left of what lies behind.
FN void preview_look_through(const_in(SceneView) scene, inout(PreviewView) view, inout(vec3) absorption) {
    RECORD(Material) m = scene.materials.at[view.surface.material];
    vec3 d = view.ray.direction;
    vec3 n = view.surface.normal;
    float cosine = min(abs(dot(d, n)), 1.0f);
    if (view.surface.entering) {
        float f0 = sqr((m.ior - 1.0f) / (m.ior + 1.0f));
        float fresnel = f0 + (1.0f - f0) * pow(1.0f - cosine, 5.0f);
        view.before += view.transmitted * (fresnel * environment_radiance(scene, normalize(reflect(d, n))));
        view.transmitted *= 1.0f - fresnel;
    }
    view.transmitted *= m.color;
    absorption = view.surface.entering ? m.absorption : vec3(0.0f);
}

// The first surface along a camera ray, whose nearest hit is given, that has a material and is more opaque than not.
FN PreviewView preview_view(const_in(SceneView) scene, Ray ray, const_in(Hit) first) {
    PreviewView view;
    view.found = false;
    view.ray = ray;
    view.first = ray;
    view.distance = 0.0f;
    view.transmitted = vec3(1.0f);
    view.before = vec3(0.0f);
    view.bound_reached = false;
    vec3 absorption = vec3(0.0f);
    view.hit = first;
    for (uint i = 0u; i < MAX_PREVIEW_LAYERS; ++i) {
        if (!is_hit(view.hit)) return view;
        view.surface = surface_at(scene, view.ray, view.hit);
        view.distance += distance(view.ray.origin, view.surface.position);
        if (!is_black(absorption)) {
            vec3 depth = absorption * distance(view.ray.origin, view.surface.position);
            view.transmitted *= vec3(exp(-depth.x), exp(-depth.y), exp(-depth.z));
        }
        bool seen = view.surface.material != NONE && surface_opacity(scene, view.surface) >= 0.5f;
        if (seen && !preview_is_glass(scene, view.surface.material)) {
            view.found = true;
            view.frame = shading_frame(scene, view.surface, -ray.direction);
            Bsdf bsdf = surface_bsdf(scene, view.surface, 1.0f);
            view.albedo = bsdf_albedo(bsdf, to_local(view.frame, -ray.direction));
            return view;
        }
        if (seen) preview_look_through(scene, view, absorption);
        view.ray.origin = leave_surface(scene, view.surface, ray.direction);
        view.hit = trace_closest(scene, view.ray, TRACE_ALL);
    }
    view.bound_reached = true;
    return view;
}

// Everything else that a pixel shows, about `shaded`, the light that the surface gives back.
FN PixelSample preview_sample(const_in(SceneView) scene, const_in(PreviewView) view, vec3 shaded) {
    if (!view.found) {
        vec3 sky = environment_radiance(scene, view.ray.direction);
        return PixelSample(view.before + view.transmitted * sky, FirstHit(vec3(0.0f), 0.0f, vec3(0.0f), NONE),
                           view.bound_reached);
    }
    vec3 radiance = view.before + view.transmitted * (surface_emission(scene, view.surface) + shaded);
    FirstHit first =
        FirstHit(view.frame.z, view.distance, view.albedo, scene.instances.at[view.surface.instance].object);
    return PixelSample(radiance, first, view.bound_reached);
}

// Where a ray that leaves the surface on the viewer's side begins.
FN vec3 preview_origin(const_in(SceneView) scene, const_in(PreviewView) view) {
    return leave_surface(scene, view.surface, -view.ray.direction);
}

// Irradiance by the sun over π, with nothing in its way.
FN vec3 preview_sun(const_in(SceneView) scene, vec3 normal) {
    return scene.preview_light.sun * (INV_PI * max(dot(normal, scene.preview_light.to_sun), 0.0f));
}

KERNELS_END
#endif
