#ifndef SPINEL_TESTS_VULKAN_KERNEL_CASES_H
#define SPINEL_TESTS_VULKAN_KERNEL_CASES_H
// Kernel functions on inputs drawn from a hash of the case's index. This header is itself in the common
// subset: the Vulkan shader kernel_cases.comp and the C++ test both compile it, and the test compares what
// they answer.
#include "kernels/box.h"
#include "kernels/fresnel.h"
#include "kernels/materials/diffuse.h"
#include "kernels/microfacet.h"
#include "kernels/phase.h"
#include "kernels/random.h"
#include "kernels/sphere.h"
#include "kernels/triangle.h"
#include "kernels/warp.h"
KERNELS_BEGIN

const uint CASE_RANDOM = 0u;
const uint CASE_WARP = 1u;
const uint CASE_BOX = 2u;
const uint CASE_TRIANGLE = 3u;
const uint CASE_SPHERE = 4u;
const uint CASE_MICROFACET = 5u;
const uint CASE_SCATTER = 6u;

struct CaseResult {
    uvec4 exact;  // integers and decisions
    vec4 a;       // numbers, within a tolerance
    vec4 b;
};

FN float draw(inout(Rng) r, float lower, float upper) { return mix(lower, upper, rng_1d(r)); }
FN vec3 draw_vector(inout(Rng) r, float lower, float upper) {
    float x = draw(r, lower, upper);
    float y = draw(r, lower, upper);
    float z = draw(r, lower, upper);
    return vec3(x, y, z);
}
FN vec2 draw_2d(inout(Rng) r) {
    float x = rng_1d(r);
    float y = rng_1d(r);
    return vec2(x, y);
}

FN CaseResult random_case(uint i) {
    Sampler s = make_sampler(uvec2(i % 64u, i / 64u), i * 7u, 42u);
    Rng stream = make_rng(s, 3u);
    vec2 first = sampler_2d(s);
    float second = sampler_1d(s);
    vec2 third = sampler_2d(s);
    uint word = rng_uint(stream);
    return CaseResult(uvec4(hash_uint(i), hash_combine(i, word), word, float_bits(second)),
                      vec4(first.x, first.y, third.x, third.y), vec4(rng_1d(stream), 0.0f, 0.0f, 0.0f));
}

FN CaseResult warp_case(uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    vec2 u = draw_2d(r);
    vec3 cosine = square_to_cosine_hemisphere(u);
    vec3 cone = square_to_cone(u, 0.25f);
    vec2 weights = square_to_triangle(u);
    vec3 sphere = square_to_sphere(u);
    return CaseResult(uvec4(0u), vec4(cosine, interval_to_tent(u.x)),
                      vec4(cone.x + weights.x, weights.y, sphere.x, sphere.z));
}

FN CaseResult box_case(uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    vec3 origin = draw_vector(r, -3.0f, 3.0f);
    vec3 target = draw_vector(r, -1.5f, 1.5f);
    Ray ray = Ray(origin, 0.0f, target - origin, INFINITE);
    float entry = slab_entry(vec3(-1.0f), vec3(1.0f), slab_ray(ray), ray.t_max);
    Hit hit = no_hit(ray.t_max);
    box_closest(ray, hit);
    bool found = hit.t < ray.t_max;
    return CaseResult(uvec4(entry < INFINITE ? 1u : 0u, found ? 1u : 0u, hit.primitive, 0u),
                      vec4(entry < INFINITE ? entry : 0.0f, found ? hit.t : 0.0f, hit.uv.x, hit.uv.y),
                      vec4(hit.normal, 0.0f));
}

FN CaseResult triangle_case(uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    // Neither slivers nor grazing rays: there the two compilers' roundings are amplified, and only the tests
    // of watertightness have something to say.
    Triangle triangle;
    triangle.a = vec3(-1.0f, -1.0f, 0.0f) + draw_vector(r, -0.5f, 0.5f);
    triangle.b = vec3(1.0f, -1.0f, 0.0f) + draw_vector(r, -0.5f, 0.5f);
    triangle.c = vec3(0.0f, 1.0f, 0.0f) + draw_vector(r, -0.5f, 0.5f);
    vec3 origin = draw_vector(r, -3.0f, 3.0f);
    origin.z = origin.z < 0.0f ? origin.z - 2.0f : origin.z + 2.0f;
    // Aimed at the parallelogram of two edges, so that about half of the rays hit.
    vec2 at = draw_2d(r);
    vec3 target = triangle.a + at.x * (triangle.b - triangle.a) + at.y * (triangle.c - triangle.a);
    Ray ray = Ray(origin, 0.0f, target - origin, INFINITE);
    TriangleHit watertight = TriangleHit(0.0f, 0.0f, 0.0f);
    TriangleHit moller = TriangleHit(0.0f, 0.0f, 0.0f);
    bool first = triangle_watertight(triangle_ray(ray), triangle, ray.t_min, ray.t_max, watertight);
    bool second = triangle_moller_trumbore(ray, triangle, ray.t_min, ray.t_max, moller);
    return CaseResult(uvec4(first ? 1u : 0u, second ? 1u : 0u, 0u, 0u),
                      vec4(watertight.t, watertight.u, watertight.v, 0.0f), vec4(moller.t, moller.u, moller.v, 0.0f));
}

FN CaseResult sphere_case(uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    vec3 origin = draw_vector(r, -3.0f, 3.0f);
    vec3 target = draw_vector(r, -1.0f, 1.0f);
    Ray ray = Ray(origin, 0.0f, target - origin, INFINITE);
    Hit hit = no_hit(ray.t_max);
    sphere_closest(ray, hit);
    bool found = hit.t < ray.t_max;
    return CaseResult(uvec4(found ? 1u : 0u, 0u, 0u, 0u), vec4(found ? hit.t : 0.0f, hit.normal), vec4(0.0f));
}

FN CaseResult microfacet_case(uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    float alpha = ggx_alpha(draw(r, 0.2f, 1.0f));
    float ior = draw(r, 1.1f, 2.5f);
    vec3 wo = square_to_cosine_hemisphere(draw_2d(r));
    vec3 wi = square_to_cosine_hemisphere(draw_2d(r));
    vec3 m = ggx_sample(alpha, wo, draw_2d(r));
    vec3 metal = fresnel_conductor(wo.z, vec3(0.2f, 0.9f, 1.3f), vec3(3.9f, 2.5f, 1.9f));
    return CaseResult(uvec4(0u), vec4(m, ggx_g2(alpha, wo, wi)),
                      vec4(fresnel_dielectric(wo.z, ior), fresnel_dielectric(wo.z, 1.0f / ior), metal.x, metal.z));
}

// Rough matte surfaces, and a phase function.
FN CaseResult scatter_case(uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    vec3 color = draw_vector(r, 0.1f, 0.9f);
    Bsdf b;
    b.color = color;
    b.roughness = rng_1d(r);
    diffuse_make(b);
    vec3 wo = square_to_cosine_hemisphere(draw_2d(r));
    vec3 wi = square_to_sphere(draw_2d(r));
    BsdfSample s = diffuse_sample(b, wo, 0.0f, draw_2d(r));
    float g = draw(r, -0.9f, 0.9f);
    PhaseSample phase = phase_sample(g, wo, draw_2d(r));
    return CaseResult(uvec4(s.flags, 0u, 0u, 0u), diffuse_eval_pdf(b, wo, wi),
                      vec4(s.direction.x + s.direction.z, s.weight.y, phase.direction.x, phase_eval(g, wi.z)));
}

FN CaseResult kernel_case(uint kind, uint i) {
    if (kind == CASE_RANDOM) return random_case(i);
    if (kind == CASE_WARP) return warp_case(i);
    if (kind == CASE_BOX) return box_case(i);
    if (kind == CASE_TRIANGLE) return triangle_case(i);
    if (kind == CASE_SPHERE) return sphere_case(i);
    if (kind == CASE_MICROFACET) return microfacet_case(i);
    return scatter_case(i);
}

KERNELS_END
#endif
