#ifndef SPINEL_KERNELS_ENVIRONMENT_H
#define SPINEL_KERNELS_ENVIRONMENT_H
// Light from infinitely far away, as an equirectangular image, importance sampled by luminance (Pharr, Jakob,
// Humphreys, "Physically Based Rendering", 4th ed., 12.5).
#include "scene_view.h"
KERNELS_BEGIN

// uv of a direction in the environment's own space, u ∈ [0,1) around, v ∈ [0,1] down from the zenith.
FN vec2 equirect_uv(vec3 d) {
    float u = atan(d.x, -d.z) * (0.5f * INV_PI);
    return vec2(u < 0.0f ? u + 1.0f : u, acos(clamp(d.y, -1.0f, 1.0f)) * INV_PI);
}

FN vec3 equirect_direction(vec2 uv) {
    float phi = 2.0f * PI * uv.x;
    float theta = PI * uv.y;
    return vec3(sin(phi) * sin(theta), cos(theta), -cos(phi) * sin(theta));
}

FN vec3 environment_texel(const_in(SceneView) scene, const_in(Environment) e, int x, int y) {
    int w = int(e.width);
    x = x < 0 ? x + w : (x >= w ? x - w : x);
    y = clamp(y, 0, int(e.height) - 1);
    uint i = e.radiance_first + 3u * (uint(y) * e.width + uint(x));
    return vec3(scene.floats.at[i], scene.floats.at[i + 1u], scene.floats.at[i + 2u]);
}

// Radiance that arrives from a unit world direction.
FN vec3 environment_radiance(const_in(SceneView) scene, vec3 direction) {
    RECORD(Environment) e = scene.environment;
    if (e.width == 0u) return vec3(0.0f);
    if (e.width == 1u && e.height == 1u) return environment_texel(scene, e, 0, 0);
    vec2 uv = equirect_uv(e.world_to_local * direction);
    float x = uv.x * float(e.width);
    float y = uv.y * float(e.height);
    if (e.filter_kind == FILTER_NEAREST) return environment_texel(scene, e, min(int(x), int(e.width) - 1), int(y));
    x -= 0.5f;
    y -= 0.5f;
    int i = int(floor(x));
    int j = int(floor(y));
    float a = x - float(i);
    float b = y - float(j);
    return mix(mix(environment_texel(scene, e, i, j), environment_texel(scene, e, i + 1, j), a),
               mix(environment_texel(scene, e, i, j + 1), environment_texel(scene, e, i + 1, j + 1), a), b);
}

// Index of the step of a cumulative table c[0] = 0 … c[count] = 1 that holds u; the table starts at `first` of floats.
FN uint cumulative_find(const_in(SceneView) scene, uint first, uint count, float u) {
    uint lo = 0u;
    uint hi = count;
    while (hi - lo > 1u) {  // ends: the interval halves
        uint mid = (lo + hi) / 2u;
        if (scene.floats.at[first + mid] <= u) lo = mid;
        else hi = mid;
    }
    return lo;
}

// Density over solid angle [1/sr] of environment_sample: constant within a texel.
FN float environment_pdf(const_in(SceneView) scene, vec3 direction) {
    RECORD(Environment) e = scene.environment;
    if (e.light == NONE) return 0.0f;
    vec2 uv = equirect_uv(e.world_to_local * direction);
    uint x = min(uint(uv.x * float(e.width)), e.width - 1u);
    uint y = min(uint(uv.y * float(e.height)), e.height - 1u);
    uint row = e.conditional_first + y * (e.width + 1u);
    float p_row = scene.floats.at[e.marginal_first + y + 1u] - scene.floats.at[e.marginal_first + y];
    float p_column = scene.floats.at[row + x + 1u] - scene.floats.at[row + x];
    float solid_angle =
        2.0f * PI / float(e.width) * (cos(PI * float(y) / float(e.height)) - cos(PI * float(y + 1u) / float(e.height)));
    return p_row * p_column / solid_angle;
}

// A world direction, in proportion to luminance: a texel, then uniform over its solid angle.
FN vec3 environment_sample(const_in(SceneView) scene, vec2 u) {
    RECORD(Environment) e = scene.environment;
    uint y = cumulative_find(scene, e.marginal_first, e.height, u.y);
    float c0 = scene.floats.at[e.marginal_first + y];
    float c1 = scene.floats.at[e.marginal_first + y + 1u];
    float v = clamp((u.y - c0) / max(c1 - c0, 1.0e-30f), 0.0f, ONE_MINUS_EPSILON);
    float cos_theta = mix(cos(PI * float(y) / float(e.height)), cos(PI * float(y + 1u) / float(e.height)), v);
    uint row = e.conditional_first + y * (e.width + 1u);
    uint x = cumulative_find(scene, row, e.width, u.x);
    c0 = scene.floats.at[row + x];
    c1 = scene.floats.at[row + x + 1u];
    float phi =
        2.0f * PI * (float(x) + clamp((u.x - c0) / max(c1 - c0, 1.0e-30f), 0.0f, ONE_MINUS_EPSILON)) / float(e.width);
    float sin_theta = safe_sqrt(1.0f - cos_theta * cos_theta);
    return transpose(e.world_to_local) * vec3(sin(phi) * sin_theta, cos_theta, -cos(phi) * sin_theta);
}

KERNELS_END
#endif
