#ifndef SPINEL_KERNELS_TRIANGLE_UNIT_H
#define SPINEL_KERNELS_TRIANGLE_UNIT_H
// The unit-triangle test: an affine map, kept for each triangle, carries it to (0,0,0), (1,0,0), (0,1,0), and the ray
// with it; what is left is a plane z = 0 and three comparisons. Woop, "A Ray Tracing Hardware Architecture for Dynamic
// Scenes", 2004; Woop, Schmittler, Slusallek, "RPU", SIGGRAPH 2005.
//
// 48 bytes in place of 36, and the fewest operations. Each triangle rounds the ray in its own way, so neighbours may
// disagree about their edge, the more the longer and thinner they are.
#include "triangle.h"
KERNELS_BEGIN

FN bool triangle_unit(Ray ray, const_in(UnitTriangle) map, float t_min, float t_max, inout(TriangleHit) hit) {
    vec4 origin = vec4(ray.origin, 1.0f);
    vec4 direction = vec4(ray.direction, 0.0f);
    float slope = dot(map.z_row, direction);
    if (!(abs(slope) > 0.0f)) return false;
    float t = -dot(map.z_row, origin) / slope;
    if (!(t > t_min && t < t_max)) return false;
    float u = dot(map.x_row, origin) + t * dot(map.x_row, direction);
    if (!(u >= 0.0f)) return false;
    float v = dot(map.y_row, origin) + t * dot(map.y_row, direction);
    if (!(v >= 0.0f && u + v <= 1.0f)) return false;
    hit.t = t;
    hit.u = u;
    hit.v = v;
    return true;
}

KERNELS_END
#endif
