#ifndef SPINEL_KERNELS_EQUIANGULAR_H
#define SPINEL_KERNELS_EQUIANGULAR_H
// Places along a ray in proportion to the light that a point sends there: uniform over the angle under which the light
// sees the ray, so the density has the light's 1/distance².
// Kulla and Fajardo, "Importance Sampling Techniques for Path Tracing in Participating Media", EGSR 2012.
#include "constants.h"
KERNELS_BEGIN

struct Equiangular {
    float along;   // where the ray is nearest to the light, from its origin
    float beside;  // how near that is; not quite 0, where a ray meets the light
    float angle;   // under which the light sees the segment
};

const float EQUIANGULAR_END = 1.0e15f;  // rays without an end are looked at up to here

// The segment (0, t_max) of a ray with unit direction.
FN Equiangular equiangular_begin(vec3 origin, vec3 direction, float t_max, vec3 light) {
    vec3 to = light - origin;
    float along = dot(to, direction);
    float beside = max(length(to - along * direction), 1.0e-4f * (length(to) + 1.0e-20f));
    float end = min(t_max, EQUIANGULAR_END);
    // The angle from the origin to the end, without the difference of two that may be nearly equal.
    float x = (beside / end) * beside - along * (1.0f - along / end);
    return Equiangular(along, beside, atan(beside, x));
}

FN float equiangular_sample(const_in(Equiangular) e, float u) {
    float phi = u * e.angle;
    float s = sin(phi);
    return s * (sqr(e.beside) + sqr(e.along)) / max(e.beside * cos(phi) + e.along * s, 1.0e-30f);
}

// Density over distance.
FN float equiangular_pdf(const_in(Equiangular) e, float t) {
    return e.beside / (e.angle * (sqr(e.beside) + sqr(t - e.along)));
}

KERNELS_END
#endif
