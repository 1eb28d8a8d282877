#ifndef SPINEL_KERNELS_SPHERE_H
#define SPINEL_KERNELS_SPHERE_H
// Rays against the unit sphere, without the cancellation of the schoolbook quadratic: the discriminant comes
// from the distance of the line to the centre, and the smaller root from the product of the roots. Haines,
// Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, chapter 7,
// 2019.
#include "ray.h"
KERNELS_BEGIN

// Hit.normal = the point on the sphere, pulled onto it; Hit.uv = 0.
FN void sphere_closest(Ray ray, inout(Hit) hit) {
    float a = dot(ray.direction, ray.direction);
    if (!(a > 0.0f)) return;
    float b = -dot(ray.origin, ray.direction);
    vec3 foot = ray.origin + (b / a) * ray.direction;  // of the perpendicular from the centre
    float discriminant = 1.0f - dot(foot, foot);       // of the quadratic, divided by a
    if (!(discriminant >= 0.0f)) return;
    float root = sqrt(a * discriminant);
    float q = b + (b < 0.0f ? -root : root);
    float distance = length(ray.origin);
    float c = (distance - 1.0f) * (distance + 1.0f);
    float first = q / a;
    float second = q == 0.0f ? first : c / q;
    float near = min(first, second);
    float t = near > ray.t_min ? near : max(first, second);
    if (!(t > ray.t_min && t < hit.t)) return;
    hit.t = t;
    hit.primitive = 0u;
    hit.face = 0u;
    hit.cell = ivec3(0);
    hit.uv = vec2(0.0f);
    hit.normal = normalize(ray_at(ray, t));
}

KERNELS_END
#endif
