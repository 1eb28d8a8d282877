#ifndef SPINEL_TESTS_VULKAN_KERNEL_CASES_H
#define SPINEL_TESTS_VULKAN_KERNEL_CASES_H
// Kernel functions on inputs drawn from a hash of the case's index, and on the scene of case_scene.h. This header is
// itself in the common subset: the Vulkan shader kernel_cases.comp and the C++ test both compile it, and the test
// compares what they answer.
#include "kernels/box.h"
#include "kernels/bsdf.h"
#include "kernels/density.h"
#include "kernels/fresnel.h"
#include "kernels/medium.h"
#include "kernels/microfacet.h"
#include "kernels/phase.h"
#include "kernels/random.h"
#include "kernels/sky.h"
#include "kernels/sphere.h"
#include "kernels/traverse.h"
#include "kernels/triangle.h"
#include "kernels/warp.h"
KERNELS_BEGIN

const uint CASE_RANDOM = 0u;
const uint CASE_WARP = 1u;
const uint CASE_BOX = 2u;
const uint CASE_TRIANGLE = 3u;
const uint CASE_SPHERE = 4u;
const uint CASE_MICROFACET = 5u;
const uint CASE_PHASE = 6u;
const uint CASE_NOISE = 7u;
const uint CASE_DENSITY = 8u;
const uint CASE_SKY = 9u;
const uint CASE_SDF = 10u;
const uint CASE_VOXELS = 11u;
const uint CASE_SCENE = 12u;
const uint CASE_TRANSMITTANCE = 13u;
const uint CASE_OCCLUDED = 14u;
// Of each material of the table two kinds: its value and density, and its samples.
const uint CASE_MATERIAL = 64u;
const uint MATERIAL_VARIANTS = 256u;  // of each kind in SceneView::materials, in the order of the kinds' numbers

// What case_scene.h holds.
const uint CASE_SDF_COUNT = 4u;
const uint CASE_HOMOGENEOUS_COUNT = 2u;  // interiors, the first ones
const uint CASE_DENSITY_FIRST = 2u;      // media with a grid
const uint CASE_DENSITY_COUNT = 6u;

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
    float entry =
        slab_entry(vec3(-1.0f), vec3(1.0f), slab_ray(ray, slab_padding(vec3(-1.0f), vec3(1.0f), origin)), ray.t_max);
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

FN CaseResult phase_case(uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    float g = draw(r, -0.9f, 0.9f);
    vec3 wo = square_to_sphere(draw_2d(r));
    PhaseSample phase = phase_sample(g, wo, draw_2d(r));
    float value = phase_eval(g, draw(r, -1.0f, 1.0f));
    return CaseResult(uvec4(0u), vec4(phase.direction, phase.pdf), vec4(value, 0.0f, 0.0f, 0.0f));
}

// A unit vector without sines, which Vulkan leaves free to be wrong by 2^-11: what is made of it is compared more
// closely.
FN vec3 draw_direction(inout(Rng) r) {
    vec3 v = draw_vector(r, -1.0f, 1.0f);
    float squared = dot(v, v);
    return squared > 1e-4f ? v * inversesqrt(squared) : vec3(0.0f, 0.0f, 1.0f);
}

FN CaseResult noise_case(uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    vec3 p = draw_vector(r, -50.0f, 50.0f);
    return CaseResult(uvec4(0u), vec4(value_noise(p), fbm_noise(p, 1u + i % 6u), 0.0f, 0.0f), vec4(0.0f));
}

// Densities with either erosion, on the grids of the scene.
FN CaseResult density_case(const_in(SceneView) scene, uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    vec3 p = draw_vector(r, -1.2f, 1.2f);
    RECORD(Medium) m = scene.media.at[CASE_DENSITY_FIRST + i % CASE_DENSITY_COUNT];
    float erosion = erosion_factor(m, 0.5f * p + 0.5f);
    return CaseResult(uvec4(0u), vec4(medium_density(scene, m, p), erosion, 0.0f, 0.0f), vec4(0.0f));
}

FN CaseResult sky_case(uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    vec3 direction = draw_direction(r);
    vec3 to_sun = draw_direction(r);
    to_sun.y = max(to_sun.y, -0.1f);
    to_sun = normalize(to_sun);
    float haze = draw(r, 0.0f, 3.0f);
    return CaseResult(uvec4(0u), vec4(sky_radiance(direction, to_sun, haze), 0.0f),
                      vec4(sun_irradiance(to_sun, haze), 0.0f));
}

FN CaseResult sdf_case(const_in(SceneView) scene, uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    uint sdf = i % CASE_SDF_COUNT;
    vec3 p = 0.5f * (scene.sdfs.at[sdf].lower + scene.sdfs.at[sdf].upper) + draw_vector(r, -1.0f, 1.0f);
    return CaseResult(uvec4(0u), sdf_distance_gradient(scene, sdf, p),
                      vec4(sdf_distance(scene, sdf, p), 0.0f, 0.0f, 0.0f));
}

// A ray from anywhere towards a box that holds what is asked for.
FN Ray draw_ray(inout(Rng) r, vec3 lower, vec3 upper) {
    vec3 extent = upper - lower;
    vec3 origin = lower + extent * draw_vector(r, -0.5f, 1.5f);
    vec3 target = lower + extent * draw_vector(r, 0.0f, 1.0f);
    return Ray(origin, 0.0f, target - origin, INFINITE);
}

FN CaseResult voxels_case(const_in(SceneView) scene, uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    vec3 size = vec3(scene.voxel_grids.at[0].size);
    Ray ray = draw_ray(r, vec3(0.0f), size);
    Hit hit = no_hit(ray.t_max);
    voxels_closest(scene, 0u, 0u, ray, hit);
    bool found = hit.t < ray.t_max;
    return CaseResult(uvec4(found ? 1u : 0u, hit.primitive, hit.face, 0u),
                      vec4(found ? hit.t : 0.0f, hit.uv.x, hit.uv.y, 0.0f), vec4(hit.normal, 0.0f));
}

// The whole walk: instances, mesh, implicit surface, voxels, sphere and box. `found` and the instance decide; an edge
// between two faces of one thing may fall either way, so what lies there is left out of the exact part.
FN CaseResult scene_case(const_in(SceneView) scene, uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    Ray ray = draw_ray(r, vec3(-4.0f, -2.0f, -2.0f), vec3(4.0f, 2.0f, 2.0f));
    Hit hit = trace_closest(scene, ray, TRACE_ALL);
    return CaseResult(uvec4(hit.instance, 0u, 0u, 0u), vec4(is_hit(hit) ? hit.t : 0.0f, 0.0f, 0.0f, 0.0f), vec4(0.0f));
}

// A case of its own: two walks in one shader would take a driver several times as long to compile as one.
FN CaseResult occluded_case(const_in(SceneView) scene, uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    Ray ray = draw_ray(r, vec3(-4.0f, -2.0f, -2.0f), vec3(4.0f, 2.0f, 2.0f));
    return CaseResult(uvec4(trace_any(scene, ray, TRACE_ALL) ? 1u : 0u, 0u, 0u, 0u), vec4(0.0f), vec4(0.0f));
}

// Through all homogeneous interiors of the scene at once.
FN CaseResult transmittance_case(const_in(SceneView) scene, uint i) {
    Rng r = Rng(hash_uint(i), 0u);
    float way = draw(r, 0.0f, 4.0f);
    vec3 origin = draw_vector(r, -1.0f, 1.0f);
    vec3 direction = draw_direction(r);
    Inside inside = inside_nothing();
    for (uint k = 0u; k < CASE_HOMOGENEOUS_COUNT; ++k) {
        if (((i >> k) & 1u) != 0u) inside_enter(inside, k);
    }
    ActiveMedia media = active_media(scene, inside);
    SpectralWeights w = SpectralWeights(vec3(1.0f), vec3(1.0f), vec3(1.0f), i % 3u);
    bool bound = attenuate(scene, media, origin, direction, way, i / 3u % 3u, w, r);
    return CaseResult(uvec4(bound ? 1u : 0u, media.count, 0u, 0u), vec4(w.throughput, w.r_path.x),
                      vec4(w.r_light, w.r_path.y));
}

// -------------------------------------------------------------------------------------------------------- materials
// A material of the scene's table, from either side of its surface.
FN Bsdf draw_bsdf(const_in(SceneView) scene, uint material, uint i, inout(Rng) r) {
    RECORD(Material) m = scene.materials.at[material * MATERIAL_VARIANTS + i % MATERIAL_VARIANTS];
    float relative_ior = rng_1d(r) < 0.5f ? m.ior : 1.0f / m.ior;
    return make_bsdf(m, m.color, m.roughness, m.metallic, relative_ior);
}

FN vec3 draw_upper_direction(inout(Rng) r) {
    vec3 w = draw_direction(r);
    w.z = abs(w.z) + 0.01f;
    return normalize(w);
}

// Half of the directions lie about those of mirror reflection and of refraction, where narrow lobes are.
FN CaseResult material_value_case(const_in(SceneView) scene, uint material, uint i) {
    Rng r = Rng(hash_uint(i), material);
    Bsdf b = draw_bsdf(scene, material, i, r);
    vec3 wo = draw_upper_direction(r);
    vec3 wi = draw_direction(r);
    float alpha = ggx_alpha(b.roughness);
    vec3 m = draw_vector(r, -1.0f, 1.0f);
    m = normalize(vec3(alpha * m.x, alpha * m.y, 1.0f));
    uint choice = rng_uint(r) % 4u;
    float om = dot(wo, m);
    if (choice == 0u) wi = 2.0f * om * m - wo;
    if (choice == 1u && fresnel_dielectric(om, b.relative_ior) < 1.0f)
        wi = normalize((om / b.relative_ior - refracted_cosine(om, b.relative_ior)) * m - wo / b.relative_ior);
    vec4 value_pdf = bsdf_eval_pdf(b, wo, wi);
    return CaseResult(uvec4(bsdf_is_delta(b) ? 1u : 0u, 0u, 0u, 0u), value_pdf, vec4(bsdf_albedo(b, wo), 0.0f));
}

FN CaseResult material_sample_case(const_in(SceneView) scene, uint material, uint i) {
    Rng r = Rng(hash_uint(i), material);
    Bsdf b = draw_bsdf(scene, material, i, r);
    vec3 wo = draw_upper_direction(r);
    float u_lobe = rng_1d(r);
    BsdfSample s = bsdf_sample(b, wo, u_lobe, draw_2d(r));
    // Densities of narrow lobes are huge and steep: their root is compared.
    return CaseResult(uvec4(s.flags, 0u, 0u, 0u), vec4(s.direction, sqrt(s.pdf)), vec4(s.weight, 0.0f));
}

FN CaseResult kernel_case(const_in(SceneView) scene, uint kind, uint i) {
    if (kind >= CASE_MATERIAL) {
        uint material = (kind - CASE_MATERIAL) / 2u;
        if ((kind & 1u) == 0u) return material_value_case(scene, material, i);
        return material_sample_case(scene, material, i);
    }
    switch (kind) {
        case CASE_RANDOM: return random_case(i);
        case CASE_WARP: return warp_case(i);
        case CASE_BOX: return box_case(i);
        case CASE_TRIANGLE: return triangle_case(i);
        case CASE_SPHERE: return sphere_case(i);
        case CASE_MICROFACET: return microfacet_case(i);
        case CASE_PHASE: return phase_case(i);
        case CASE_NOISE: return noise_case(i);
        case CASE_DENSITY: return density_case(scene, i);
        case CASE_SKY: return sky_case(i);
        case CASE_SDF: return sdf_case(scene, i);
        case CASE_VOXELS: return voxels_case(scene, i);
        case CASE_SCENE: return scene_case(scene, i);
        case CASE_OCCLUDED: return occluded_case(scene, i);
        default: return transmittance_case(scene, i);
    }
}

KERNELS_END
#endif
