#ifndef SPINEL_KERNELS_BOX_H
#define SPINEL_KERNELS_BOX_H
// Rays against axis-aligned boxes: a conservative slab test for hierarchies, and the surface of the solid box
// [-1, 1]³.
//
// The slab test misses no box that the exact ray meets, nor one that holds a primitive which its test meets by
// rounding: boxes are widened on all sides by a length (slab_padding). A factor on t, which is all that the slab test's
// own roundings ask for (Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013), is not enough: a long edge is moved by the
// rounding of its far end, here by as much as there. The ray is moved in place of the planes, once for all boxes.
//
// Direction components below TINY_DIRECTION are kept away from 0·∞: such a ray is inside the slab for all t or for
// none, faces included. Directions of lengths between 1e-15 and 1e15 are supported.
#include "ray.h"
KERNELS_BEGIN

const float TINY_DIRECTION = 1.0e-30f;

// How far boxes are widened, so that none is missed that holds a triangle which triangle_watertight() finds, nor
// entered later than its t; lower and upper bound all of them. Let e = 2⁻²⁴, and E be the greatest distance along an
// axis from the ray's origin to the farther side. The test moves vertices by at most 10·e·E across the ray (Woop et al.
// 2013, section 3.3), its t is wrong by at most 13·e·E of the largest component; where rays meet planes is wrong by
// 3·e·E and e·|origin|.
FN float slab_padding(vec3 lower, vec3 upper, vec3 origin) {
    vec3 farther = max(abs(lower - origin), abs(upper - origin));
    vec3 o = abs(origin);
    return 1.9073486e-6f * max(max(farther.x, farther.y), farther.z) + 2.3841858e-7f * max(max(o.x, o.y), o.z);
}

// What the slab test needs of a ray, once for many boxes.
struct SlabRay {
    vec3 lower_origin;  // subtracted from lower planes: beyond the ray's own by the padding …
    vec3 upper_origin;  // … and from upper planes: before it
    vec3 inverse;       // of the direction, finite
    float t_min;
};

FN float safe_inverse(float d) { return abs(d) < TINY_DIRECTION ? 1.0f / TINY_DIRECTION : 1.0f / d; }

FN SlabRay slab_ray(Ray ray, float padding) {
    vec3 d = ray.direction;
    return SlabRay(ray.origin + vec3(padding), ray.origin - vec3(padding),
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
    return enter <= leave ? enter : INFINITE;
}

// Where the ray enters and leaves the box within (t_min, t_max); it misses if the first is greater.
FN vec2 slab_interval(vec3 lower, vec3 upper, const_in(SlabRay) ray, float t_max) {
    vec3 t0 = (lower - ray.lower_origin) * ray.inverse;
    vec3 t1 = (upper - ray.upper_origin) * ray.inverse;
    float enter = max(max(min(t0.x, t1.x), min(t0.y, t1.y)), max(min(t0.z, t1.z), ray.t_min));
    float leave = min(min(max(t0.x, t1.x), max(t0.y, t1.y)), min(max(t0.z, t1.z), t_max));
    return vec2(enter, leave);
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
