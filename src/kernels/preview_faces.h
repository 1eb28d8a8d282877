#ifndef SPINEL_KERNELS_PREVIEW_FACES_H
#define SPINEL_KERNELS_PREVIEW_FACES_H
// `faces`: every face has one brightness: its normal against the sun, a hard shadow, a constant sky. Nothing here is
// random but the place within the pixel (and on the lens), so edges are smooth and faces have no grain.
#include "preview_glow.h"
#include "preview_shade.h"
KERNELS_BEGIN

FN PixelSample preview_faces(const_in(SceneView) scene, const_in(PreviewSettings) settings, Ray ray,
                             const_in(Hit) first) {
    PreviewView view = preview_view(scene, ray, first);
    vec3 shaded = vec3(0.0f);
    if (view.found) {
        // The normal of the face itself, on the viewer's side: shading normals would not be flat.
        vec3 n = view.surface.entering ? view.surface.geometric_normal : -view.surface.geometric_normal;
        vec3 light = 0.5f * (scene.preview_light.sky_above + scene.preview_light.sky_below);
        vec3 sun = preview_sun(scene, n);
        if (!is_black(sun)) {
            Ray shadow = Ray(preview_origin(scene, view), 0.0f, scene.preview_light.to_sun, INFINITE);
            if (!trace_occluded(scene, shadow)) light += sun;
        }
        shaded = view.albedo * light;
    }
    return preview_with_glow(scene, settings, view, preview_sample(scene, view, shaded));
}

KERNELS_END
#endif
