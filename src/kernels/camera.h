#ifndef SPINEL_KERNELS_CAMERA_H
#define SPINEL_KERNELS_CAMERA_H
// Thin-lens and orthographic cameras. The pixel filter is importance sampled (Ernst, Stamminger, Greiner, "Filter
// Importance Sampling", 2006): a sample belongs to one pixel, so that crops and tiles are parts of the whole, bit by
// bit.
#include "scene_view.h"
#include "warp.h"
KERNELS_BEGIN

const uint PIXEL_FILTER_BOX = 0u;
const uint PIXEL_FILTER_TENT = 1u;
const uint PIXEL_FILTER_GAUSSIAN = 2u;         // σ = radius / 3, cut at the radius
const uint PIXEL_FILTER_BLACKMAN_HARRIS = 3u;  // Harris 1978, 4 terms, 92 dB

// Offset from the pixel's centre in pixels along one axis, distributed as the filter.
FN float sample_pixel_filter(uint kind, float radius, float u) {
    if (kind == PIXEL_FILTER_BOX) return radius * (2.0f * u - 1.0f);
    if (kind == PIXEL_FILTER_TENT) return radius * interval_to_tent(u);
    // The others by inverting their cumulative distribution, which is closed or close to it, x in [−1, 1]: Newton's
    // steps inside a bracket that shrinks.
    float lo = -1.0f;
    float hi = 1.0f;
    float x = 0.0f;
    for (uint i = 0u; i < 8u; ++i) {
        float c;
        float density;
        if (kind == PIXEL_FILTER_GAUSSIAN) {
            // Error function after Abramowitz and Stegun 7.1.26, exact to 1.5e-7.
            float z = abs(x) * 3.0f * 0.70710678f;
            float t = 1.0f / (1.0f + 0.3275911f * z);
            float bell = exp(-z * z);
            float erf =
                1.0f -
                t * (0.254829592f + t * (-0.284496736f + t * (1.421413741f + t * (-1.453152027f + t * 1.061405429f)))) *
                    bell;
            c = 0.5f + (x < 0.0f ? -0.5f : 0.5f) * erf / 0.9973002f;
            density = 3.0f * 0.39894228f * bell / 0.9973002f;
        } else {
            // sin and cos of multiples of the angle by the angle's own.
            float a = PI * (x + 1.0f);
            float s1 = sin(a);
            float c1 = cos(a);
            float s2 = 2.0f * s1 * c1;
            float c2 = 2.0f * c1 * c1 - 1.0f;
            float s3 = s2 * c1 + c2 * s1;
            float c3 = c2 * c1 - s2 * s1;
            c = (0.35875f * a - 0.48829f * s1 + 0.14128f * 0.5f * s2 - 0.01168f / 3.0f * s3) / (0.35875f * 2.0f * PI);
            density = (0.35875f - 0.48829f * c1 + 0.14128f * c2 - 0.01168f * c3) / (0.35875f * 2.0f);
        }
        if (c < u) lo = x;
        else hi = x;
        float next = density > 1.0e-4f ? x - (c - u) / density : 0.5f * (lo + hi);
        x = next >= lo && next <= hi ? next : 0.5f * (lo + hi);
    }
    return radius * x;
}

// A ray of unit direction through a pixel; u_film and u_lens are uniform. Row 0 is the top.
FN Ray camera_ray(const_in(Camera) camera, uvec2 pixel, vec2 u_film, vec2 u_lens) {
    float x = float(pixel.x) + 0.5f + sample_pixel_filter(camera.filter_kind, camera.filter_radius, u_film.x);
    float y = float(pixel.y) + 0.5f + sample_pixel_filter(camera.filter_kind, camera.filter_radius, u_film.y);
    float aspect = float(camera.resolution.x) / float(camera.resolution.y);
    float px = (2.0f * x / float(camera.resolution.x) - 1.0f) * aspect * camera.half_height;
    float py = (1.0f - 2.0f * y / float(camera.resolution.y)) * camera.half_height;
    vec3 origin = vec3(0.0f);
    vec3 direction = vec3(px, py, -1.0f);
    if (camera.kind == CAMERA_ORTHOGRAPHIC) {
        origin = vec3(px, py, 0.0f);
        direction = vec3(0.0f, 0.0f, -1.0f);
    }
    if (camera.lens_radius > 0.0f) {
        vec3 focus = origin + camera.focus_distance * direction;
        vec2 lens = camera.lens_radius * square_to_disc(u_lens);
        origin += vec3(lens.x, lens.y, 0.0f);
        direction = focus - origin;
    }
    mat3 rotation = mat3(camera.camera_to_world);
    return Ray(camera.camera_to_world * vec4(origin, 1.0f), 0.0f, normalize(rotation * direction), INFINITE);
}

KERNELS_END
#endif
