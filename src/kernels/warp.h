#ifndef SPINEL_KERNELS_WARP_H
#define SPINEL_KERNELS_WARP_H
// Maps from the unit square (or interval) to the shapes that a renderer samples, each with its density beside
// it. Directions are about +z. Densities over directions are per solid angle [1/sr].
#include "constants.h"
KERNELS_BEGIN

// Disc of radius 1, area preserving, low distortion. Shirley, Chiu, "A Low Distortion Map Between Disk and
// Square", JGT 2(3), 1997, in the form of two equal branches.
FN vec2 square_to_disc(vec2 u) {
    vec2 p = 2.0f * u - vec2(1.0f);
    if (p.x == 0.0f && p.y == 0.0f) return vec2(0.0f);
    float r = p.x;
    float phi = 0.0f;
    if (abs(p.x) > abs(p.y)) {
        phi = (0.25f * PI) * (p.y / p.x);
    } else {
        r = p.y;
        phi = 0.5f * PI - (0.25f * PI) * (p.x / p.y);
    }
    return r * vec2(cos(phi), sin(phi));
}
FN float square_to_disc_pdf() { return INV_PI; }  // per unit area

FN vec3 square_to_cosine_hemisphere(vec2 u) {
    vec2 d = square_to_disc(u);
    // z by 1 − r² loses digits near the rim; a floor keeps pdf and cosine from being zero together.
    return vec3(d, sqrt(max(1.0f - dot(d, d), 1e-12f)));
}
FN float square_to_cosine_hemisphere_pdf(vec3 direction) { return max(direction.z, 0.0f) * INV_PI; }

FN vec3 square_to_sphere(vec2 u) {
    float z = 1.0f - 2.0f * u.y;
    float r = 2.0f * safe_sqrt(u.y * (1.0f - u.y));
    float phi = 2.0f * PI * u.x;
    return vec3(r * cos(phi), r * sin(phi), z);
}
FN float square_to_sphere_pdf() { return 0.25f * INV_PI; }

FN vec3 square_to_hemisphere(vec2 u) {
    float z = 1.0f - u.y;
    float r = safe_sqrt(u.y * (2.0f - u.y));
    float phi = 2.0f * PI * u.x;
    return vec3(r * cos(phi), r * sin(phi), z);
}
FN float square_to_hemisphere_pdf(vec3 direction) { return direction.z < 0.0f ? 0.0f : 0.5f * INV_PI; }

// Directions within an angle of +z. 1 − cos of the angle is passed, since cos itself has no digits left for a
// sun.
FN vec3 square_to_cone(vec2 u, float one_minus_cos) {
    float h = u.y * one_minus_cos;  // 1 − z
    float r = safe_sqrt(h * (2.0f - h));
    float phi = 2.0f * PI * u.x;
    return vec3(r * cos(phi), r * sin(phi), 1.0f - h);
}
FN float square_to_cone_pdf(float one_minus_cos) { return 1.0f / (2.0f * PI * one_minus_cos); }

// Barycentric weights of vertices 1 and 2 of a triangle, uniform by area.
// Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
FN vec2 square_to_triangle(vec2 u) {
    if (u.y > u.x) {
        float b = 0.5f * u.x;
        return vec2(b, u.y - b);
    }
    float b = 0.5f * u.y;
    return vec2(u.x - b, b);
}
FN float square_to_triangle_pdf() { return 2.0f; }  // per unit of barycentric area; divide by 2·area for a real one

// Tent over [−1, 1], density 1 − |x|.
FN float interval_to_tent(float u) { return u < 0.5f ? sqrt(2.0f * u) - 1.0f : 1.0f - sqrt(2.0f * (1.0f - u)); }
FN float interval_to_tent_pdf(float x) { return max(1.0f - abs(x), 0.0f); }

// Two independent standard normal numbers. Box, Muller, 1958.
FN vec2 square_to_gaussian(vec2 u) {
    float r = sqrt(-2.0f * log(1.0f - min(u.x, ONE_MINUS_EPSILON)));
    float phi = 2.0f * PI * u.y;
    return r * vec2(cos(phi), sin(phi));
}
FN float square_to_gaussian_pdf(vec2 x) { return 0.5f * INV_PI * exp(-0.5f * dot(x, x)); }

KERNELS_END
#endif
