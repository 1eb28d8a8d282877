#ifndef SPINEL_KERNELS_VOXEL_ROUNDING_H
#define SPINEL_KERNELS_VOXEL_ROUNDING_H
// Voxels with rounded edges. A voxel is its cell cut with a rounded box: all points no farther than the radius from a
// core, which keeps that distance from the faces where air lies across and goes on without end through the others. So
// an edge is round if air lies across both of its faces, a corner if it does across all three; faces towards other
// voxels stay flat, and equal neighbours join smoothly.
//
// Cell and rounded box are convex: along a ray the squared distance from the core is a convex function, quadratic
// between the planes of the core, and is solved piece by piece.
#include "voxels.h"
KERNELS_BEGIN

struct RoundedVoxel {
    vec3 lower;  // of the core, in the cell's own space [0, 1]³
    vec3 upper;
    float radius_squared;
};

// `exposed`: bit 2·axis + (1 if on the + side) for each face with air across.
FN RoundedVoxel rounded_voxel(float radius, uint exposed) {
    float endless = 4.0f;
    RoundedVoxel v;
    v.lower = vec3((exposed & 1u) != 0u ? radius : -endless, (exposed & 4u) != 0u ? radius : -endless,
                   (exposed & 16u) != 0u ? radius : -endless);
    v.upper = vec3((exposed & 2u) != 0u ? 1.0f - radius : endless, (exposed & 8u) != 0u ? 1.0f - radius : endless,
                   (exposed & 32u) != 0u ? 1.0f - radius : endless);
    v.radius_squared = radius * radius * 1.000002f;  // so that rounding does not open the flat part of a face
    return v;
}

FN vec3 rounded_from_core(const_in(RoundedVoxel) v, vec3 p) { return p - clamp(p, v.lower, v.upper); }

FN bool rounded_holds(const_in(RoundedVoxel) v, vec3 p) {
    vec3 d = rounded_from_core(v, p);
    return dot(d, d) <= v.radius_squared;
}

// The first s in [0, extent] at which p + s·d is in the rounded box; INFINITE: nowhere. p is outside.
FN float rounded_entry(const_in(RoundedVoxel) v, vec3 p, vec3 d, float extent) {
    float s = 0.0f;
    for (uint piece = 0u; piece < 7u && s < extent; ++piece) {
        float next = extent;
        float a = 0.0f;
        float b = 0.0f;
        float c = -v.radius_squared;
        for (uint axis = 0u; axis < 3u; ++axis) {
            float o = component(p, axis);
            float w = component(d, axis);
            float lower = component(v.lower, axis);
            float upper = component(v.upper, axis);
            bool still = abs(w) < TINY_DIRECTION;
            // First plane of the core along the ray, and the second.
            float first = w > 0.0f ? lower : upper;
            float second = w > 0.0f ? upper : lower;
            float at_first = still ? INFINITE : (first - o) / w;
            float at_second = still ? INFINITE : (second - o) / w;
            float q = 0.0f;
            if (still) {
                q = o - clamp(o, lower, upper);
            } else if (s < at_first) {
                q = o - first;
                next = min(next, at_first);
            } else if (s < at_second) {
                w = 0.0f;
                next = min(next, at_second);
            } else {
                q = o - second;
            }
            a += w * w;
            b += q * w;
            c += q * q;
        }
        float here = c + s * (2.0f * b + s * a);
        if (here <= 0.0f && b + s * a < 0.0f) return s;
        float discriminant = b * b - a * c;
        if (b < 0.0f && c > 0.0f && discriminant >= 0.0f) {
            float root = c / (sqrt(discriminant) - b);
            if (root >= s && root <= next) return root;
        }
        s = next;
    }
    return INFINITE;
}

KERNELS_END
#endif
