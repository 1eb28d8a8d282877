#ifndef SPINEL_KERNELS_PLANE_H
#define SPINEL_KERNELS_PLANE_H
// Rays against the plane y = 0 and the rectangle |x| ≤ 1, |z| ≤ 1 in it, both with normal +y.
#include "ray.h"
KERNELS_BEGIN

// Hit.uv = 0: the plane has no natural unit.
FN void plane_closest(Ray ray, inout(Hit) hit) {
    if (ray.direction.y == 0.0f) return;
    float t = -ray.origin.y / ray.direction.y;
    if (!(t > ray.t_min && t < hit.t)) return;
    hit.t = t;
    hit.primitive = 0u;
    hit.face = 0u;
    hit.cell = ivec3(0);
    hit.uv = vec2(0.0f);
    hit.normal = vec3(0.0f, 1.0f, 0.0f);
}

// Hit.uv: u grows with +x and v with −z, so that (∂p/∂u, ∂p/∂v, normal) is right-handed.
FN void rectangle_closest(Ray ray, inout(Hit) hit) {
    if (ray.direction.y == 0.0f) return;
    float t = -ray.origin.y / ray.direction.y;
    if (!(t > ray.t_min && t < hit.t)) return;
    float x = ray.origin.x + t * ray.direction.x;
    float z = ray.origin.z + t * ray.direction.z;
    if (!(abs(x) <= 1.0f && abs(z) <= 1.0f)) return;
    hit.t = t;
    hit.primitive = 0u;
    hit.face = 0u;
    hit.cell = ivec3(0);
    hit.uv = vec2(0.5f + 0.5f * x, 0.5f - 0.5f * z);
    hit.normal = vec3(0.0f, 1.0f, 0.0f);
}

KERNELS_END
#endif
