#ifndef SPINEL_KERNELS_TRIANGLE_H
#define SPINEL_KERNELS_TRIANGLE_H
// Ray/triangle tests. t in units of |direction|; (u, v) are the barycentric weights of vertices 1 and 2; hits
// in the open interval (t_min, t_max) only, edges and vertices included, both sides.
//
// triangle_watertight: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. A shear
// carries the ray to the z axis; then three signs of 2D edge functions decide. A vertex is rounded once, the
// same way in every triangle that shares it, and the signs are exact for the rounded vertices; so neighbours
// never disagree about their edge, and no ray slips between. Two departures from the paper, so that it reads
// the same in C++ and GLSL:
//   · axes are permuted cyclically, without regard to winding, by selection: no dynamic indexing;
//   · instead of a fallback to double precision when an edge function is zero, it is always computed as Kahan's
//     difference of products, whose error of 1.5 ulp of the *result* leaves the sign exact (Jeannerod, Louvet, Muller,
//     "Further analysis of Kahan's algorithm for the accurate computation of 2×2 determinants", Math. Comp. 82, 2013).
//     Where hardware has no fused multiply-add, C++ takes exact products in double; GLSL may split fma, and then a sign
//     may come out as zero, which counts as a hit in both neighbours: still no gap.
// Vectorised walks (devices/cpu/mesh_walk_avx2.cpp) do the same operations in the same order.
// Coordinates between 1e-15 and 1e15 keep the products within range of a float.
//
// triangle_moller_trumbore: Möller, Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 2(1),
// 1997. Fewer operations, but two neighbours may both reject a ray through their edge. The determinant is
// compared to zero only: an absolute epsilon would lose small triangles.
#include "scene_view.h"
KERNELS_BEGIN

// Products and sums that must be rounded the same way wherever they are inlined: the compiler's own choice of
// contraction would differ from call to call.
#ifdef __cplusplus
#ifdef __FP_FAST_FMAF
FN float multiply_add(float a, float b, float c) { return __builtin_fmaf(a, b, c); }
FN float difference_of_products(float a, float b, float c, float d) {
    float cd = c * d;
    return __builtin_fmaf(a, b, -cd) + __builtin_fmaf(-c, d, cd);
}
#else
FN float multiply_add(float a, float b, float c) { return a * b + c; }
FN float difference_of_products(float a, float b, float c, float d) {
    return static_cast<float>(static_cast<double>(a) * static_cast<double>(b) -
                              static_cast<double>(c) * static_cast<double>(d));
}
#endif
#else
FN float multiply_add(float a, float b, float c) {
    precise float r = fma(a, b, c);
    return r;
}
FN float difference_of_products(float a, float b, float c, float d) {
    precise float cd = c * d;
    precise float r = fma(a, b, -cd) + fma(-c, d, cd);
    return r;
}
#endif

// The space in which the ray is the z axis, t grows along it at unit speed, and the origin is the ray's.
struct TriangleRay {
    vec3 origin;
    uint axis;  // of the direction's largest component: z
    vec3 shear;
};

// The components of v from the one behind `axis` on, cyclically: that of the axis itself is the last.
FN vec3 turned(vec3 v, uint axis) { return axis == 0u ? vec3(v.y, v.z, v.x) : (axis == 1u ? vec3(v.z, v.x, v.y) : v); }

FN TriangleRay triangle_ray(Ray ray) {
    vec3 m = abs(ray.direction);
    uint axis = m.x >= m.y && m.x >= m.z ? 0u : (m.y >= m.z ? 1u : 2u);
    // Winding does not matter here, so x and y need not be swapped by the sign of z.
    vec3 d = turned(ray.direction, axis);
    float s = 1.0f / d.z;
    return TriangleRay(ray.origin, axis, vec3(-d.x * s, -d.y * s, s));
}

FN vec3 sheared_vertex(const_in(TriangleRay) ray, vec3 vertex) {
    vec3 v = turned(vertex - ray.origin, ray.axis);
    return vec3(multiply_add(ray.shear.x, v.z, v.x), multiply_add(ray.shear.y, v.z, v.y), ray.shear.z * v.z);
}

struct TriangleHit {
    float t;
    float u;
    float v;
};

FN bool triangle_watertight(const_in(TriangleRay) ray, const_in(Triangle) triangle, float t_min, float t_max,
                            inout(TriangleHit) hit) {
    vec3 a = sheared_vertex(ray, triangle.a);
    vec3 b = sheared_vertex(ray, triangle.b);
    vec3 c = sheared_vertex(ray, triangle.c);
    // Twice the areas that the ray spans with the edges: weights of a, b and c.
    float u = difference_of_products(c.x, b.y, c.y, b.x);
    float v = difference_of_products(a.x, c.y, a.y, c.x);
    float w = difference_of_products(b.x, a.y, b.y, a.x);
    if (min(min(u, v), w) < 0.0f && max(max(u, v), w) > 0.0f) return false;
    float determinant = u + v + w;
    if (!(abs(determinant) > 0.0f)) return false;  // seen edge-on, or NaN
    float inverse = 1.0f / determinant;
    float t = multiply_add(u, a.z, multiply_add(v, b.z, w * c.z)) * inverse;
    if (!(t > t_min && t < t_max)) return false;
    hit.t = t;
    hit.u = v * inverse;
    hit.v = w * inverse;
    return true;
}

FN bool triangle_moller_trumbore(Ray ray, const_in(Triangle) triangle, float t_min, float t_max,
                                 inout(TriangleHit) hit) {
    vec3 e1 = triangle.b - triangle.a;
    vec3 e2 = triangle.c - triangle.a;
    vec3 p = cross(ray.direction, e2);
    float determinant = dot(e1, p);
    if (!(abs(determinant) > 0.0f)) return false;
    float inverse = 1.0f / determinant;
    vec3 s = ray.origin - triangle.a;
    float u = dot(s, p) * inverse;
    if (!(u >= 0.0f && u <= 1.0f)) return false;
    vec3 q = cross(s, e1);
    float v = dot(ray.direction, q) * inverse;
    if (!(v >= 0.0f && u + v <= 1.0f)) return false;
    float t = dot(e2, q) * inverse;
    if (!(t > t_min && t < t_max)) return false;
    hit.t = t;
    hit.u = u;
    hit.v = v;
    return true;
}

KERNELS_END
#endif
