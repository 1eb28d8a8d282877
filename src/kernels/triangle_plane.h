#ifndef SPINEL_KERNELS_TRIANGLE_PLANE_H
#define SPINEL_KERNELS_TRIANGLE_PLANE_H
// The ray/triangle test that explains itself: where does the ray meet the plane, and is that point on the inner side of
// all three edges? The areas that it spans with them are its barycentric weights.
//
// The point is rounded before the edges are asked, so neighbours may both turn down, or both take, a ray through the
// edge that they share.
#include "triangle.h"
KERNELS_BEGIN

FN bool triangle_plane(Ray ray, const_in(Triangle) triangle, float t_min, float t_max, inout(TriangleHit) hit) {
    vec3 ab = triangle.b - triangle.a;
    vec3 bc = triangle.c - triangle.b;
    vec3 ca = triangle.a - triangle.c;
    vec3 normal = cross(ca, ab);  // twice the area long
    float slope = dot(normal, ray.direction);
    if (!(abs(slope) > 0.0f)) return false;  // along the plane, or NaN
    float t = dot(normal, triangle.a - ray.origin) / slope;
    if (!(t > t_min && t < t_max)) return false;
    vec3 p = ray_at(ray, t);
    float u = dot(normal, cross(bc, p - triangle.b));
    float v = dot(normal, cross(ca, p - triangle.c));
    float w = dot(normal, cross(ab, p - triangle.a));
    if (!(min(min(u, v), w) >= 0.0f)) return false;
    float inverse = 1.0f / dot(normal, normal);
    hit.t = t;
    hit.u = v * inverse;
    hit.v = w * inverse;
    return true;
}

KERNELS_END
#endif
