#ifndef SPINEL_KERNELS_HEATMAP_H
#define SPINEL_KERNELS_HEATMAP_H
// What a camera ray costs, in false colour.
#include "counted.h"
#include "path_settings.h"
#include "texture.h"
KERNELS_BEGIN

const int HEATMAP_ALL = 0;  // steps, boxes and tests together
const int HEATMAP_STEPS = 1;
const int HEATMAP_BOXES = 2;
const int HEATMAP_TESTS = 3;

// Dark blue over green and yellow to dark red for 0 … 1, in sRGB as it is shown: a fit to Mikhailov's "Turbo" (2019).
FN vec3 heat_color(float x) {
    float t = clamp(x, 0.0f, 1.0f);
    float t2 = t * t;
    float t4 = t2 * t2;
    vec3 c = vec3(0.13572138f, 0.09140261f, 0.10667330f) + vec3(4.61539260f, 2.19418839f, 12.64194608f) * t +
             vec3(-42.66032258f, 4.84296658f, -60.58204836f) * t2 +
             vec3(132.13108234f, -14.18503333f, 110.36276771f) * (t2 * t) +
             vec3(-152.94239396f, 4.27729857f, -89.90310912f) * t4 +
             vec3(59.28637943f, 2.82956604f, 27.34824973f) * (t4 * t);
    return clamp(c, vec3(0.0f), vec3(1.0f));
}

FN uint heat_count(const_in(WalkCount) count, int counter) {
    if (counter == HEATMAP_STEPS) return count.steps;
    if (counter == HEATMAP_BOXES) return count.boxes;
    if (counter == HEATMAP_TESTS) return count.tests;
    return count.steps + count.boxes + count.tests;
}

// Radiance that is shown as the colour, where the tone map is "linear" and the exposure 0.
FN vec3 heatmap(const_in(SceneView) scene, const_in(GaugeSettings) settings, Ray ray) {
    WalkCount count = no_count();
    trace_closest_counted(scene, ray, TRACE_ALL, count);
    vec3 c = heat_color(float(heat_count(count, settings.counter)) / settings.most);
    return vec3(srgb_to_linear(c.x), srgb_to_linear(c.y), srgb_to_linear(c.z));
}

KERNELS_END
#endif
