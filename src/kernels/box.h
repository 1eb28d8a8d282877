#ifndef SPINEL_KERNELS_BOX_H
#define SPINEL_KERNELS_BOX_H
// Rays against axis-aligned boxes: a conservative slab test for hierarchies, and the surface of the solid box
// [-1, 1]³.
//
// The slab test never misses a box that the exact ray meets, nor one that a primitive test meets by rounding:
// the exit distance is widened by the error of the arithmetic. Ize, "Robust BVH Ray Traversal", JCGT 2(2),
// 2013. Direction components below TINY_DIRECTION count as zero and are kept away from 0·∞: such a ray is
// inside the slab for all t or for none, faces included. Directions of lengths between 1e-15 and 1e15 are
// supported.
#include "ray.h"
KERNELS_BEGIN

const float TINY_DIRECTION = 1.0e-30f;

// γn bounds the relative error of n roundings, n·2⁻²⁴ / (1 − n·2⁻²⁴). Three for the slab test itself (Ize),
// three more for a primitive test that moves the vertices by rounding (triangle.h); both ends of the
// interval, hence 2γ6.
const float SLAB_WIDENING = 1.0f + 12.0f * 5.9604645e-8f * 1.000001f;

// What the slab test needs of a ray, once for many boxes.
struct SlabRay {
    vec3 lower_origin;  // subtracted from lower planes …
    vec3 upper_origin;  // … and from upper planes: a hair less where the direction is zero, so that faces are
                        // inside
    vec3 inverse;       // of the direction, finite
    float t_min;
};

FN float safe_inverse(float d) { return abs(d) < TINY_DIRECTION ? 1.0f / TINY_DIRECTION : 1.0f / d; }

FN float slab_upper_origin(float origin, float d) {
    return abs(d) < TINY_DIRECTION ? origin - max(abs(origin) * 2.4e-7f, 1.0e-15f) : origin;
}

FN SlabRay slab_ray(Ray ray) {
    vec3 d = ray.direction;
    return SlabRay(ray.origin,
                   vec3(slab_upper_origin(ray.origin.x, d.x), slab_upper_origin(ray.origin.y, d.y),
                        slab_upper_origin(ray.origin.z, d.z)),
                   vec3(safe_inverse(d.x), safe_inverse(d.y), safe_inverse(d.z)), ray.t_min);
}

// Where the ray enters the box, at least t_min; INFINITE if it misses within (t_min, t_max).
FN float slab_entry(vec3 lower, vec3 upper, const_in(SlabRay) ray, float t_max) {
    float x0 = (lower.x - ray.lower_origin.x) * ray.inverse.x;
    float x1 = (upper.x - ray.upper_origin.x) * ray.inverse.x;
    float y0 = (lower.y - ray.lower_origin.y) * ray.inverse.y;
    float y1 = (upper.y - ray.upper_origin.y) * ray.inverse.y;
    float z0 = (lower.z - ray.lower_origin.z) * ray.inverse.z;
    float z1 = (upper.z - ray.upper_origin.z) * ray.inverse.z;
    float enter = max(max(min(x0, x1), min(y0, y1)), max(min(z0, z1), ray.t_min));
    float leave = min(min(max(x0, x1), max(y0, y1)), min(max(z0, z1), t_max));
    return enter <= leave * SLAB_WIDENING ? enter : INFINITE;
}

// Where the ray enters and leaves the box within (t_min, t_max), the latter widened as slab_entry() does; it misses if
// the first is greater.
FN vec2 slab_interval(vec3 lower, vec3 upper, const_in(SlabRay) ray, float t_max) {
    vec3 t0 = (lower - ray.lower_origin) * ray.inverse;
    vec3 t1 = (upper - ray.upper_origin) * ray.inverse;
    float enter = max(max(min(t0.x, t1.x), min(t0.y, t1.y)), max(min(t0.z, t1.z), ray.t_min));
    float leave = min(min(max(t0.x, t1.x), max(t0.y, t1.y)), min(max(t0.z, t1.z), t_max));
    return vec2(enter, leave * SLAB_WIDENING);
}

// The surface of the solid [-1, 1]³, from outside the face where the ray enters, from inside the one where it
// leaves. Hit.primitive = 2·axis + (1 if the face is on the + side); Hit.uv = position on the face along the
// axes axis + 1 and axis + 2 (cyclic), in [0,1]².
FN void box_closest(Ray ray, inout(Hit) hit) {
    float enter = -INFINITE;
    float leave = INFINITE;
    uint enter_axis = 0u;
    uint leave_axis = 0u;
    for (uint axis = 0u; axis < 3u; ++axis) {
        float o = component(ray.origin, axis);
        float d = component(ray.direction, axis);
        if (abs(d) < TINY_DIRECTION) {
            if (abs(o) > 1.0f) return;
        } else {
            float s = d > 0.0f ? 1.0f : -1.0f;
            float t0 = (-s - o) / d;
            float t1 = (s - o) / d;
            if (t0 > enter) {
                enter = t0;
                enter_axis = axis;
            }
            if (t1 < leave) {
                leave = t1;
                leave_axis = axis;
            }
        }
    }
    if (enter > leave) return;
    bool entering = enter > ray.t_min;
    float t = entering ? enter : leave;
    uint axis = entering ? enter_axis : leave_axis;
    if (!(t > ray.t_min && t < hit.t)) return;
    bool positive = (component(ray.direction, axis) > 0.0f) != entering;
    vec3 p = clamp(ray_at(ray, t) * 0.5f + vec3(0.5f), vec3(0.0f), vec3(1.0f));
    float s = positive ? 1.0f : -1.0f;
    hit.t = t;
    hit.primitive = 2u * axis + (positive ? 1u : 0u);
    hit.face = 0u;
    hit.cell = ivec3(0);
    hit.uv = vec2(component(p, (axis + 1u) % 3u), component(p, (axis + 2u) % 3u));
    hit.normal = vec3(axis == 0u ? s : 0.0f, axis == 1u ? s : 0.0f, axis == 2u ? s : 0.0f);
}

KERNELS_END
#endif
