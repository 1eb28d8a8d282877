#ifndef SPINEL_KERNELS_MICROFACET_ENERGY_H
#define SPINEL_KERNELS_MICROFACET_ENERGY_H
// How much energy one bounce between GGX microfacets loses, and the reciprocal lobe that puts it back:
// Kulla, Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017 course.
// The losses are tabulated (microfacet_tables.h, written by tools/make_microfacet_tables.cpp) by roughness, µ
// = cos θo and, for dielectrics, relative index, and interpolated linearly in coordinates that follow their
// shape. The lobe
//   f = (1 − E(o)) (1 − E(i)) / (π (1 − E_average))
// has albedo 1 − E(o), so the sum is one up to the tables' error (below 0.3 % for conductors).
//
// C++ reads the table where it stands. A shader reads it from the scene's words, as some compilers copy a
// constant array at every use: microfacet_begin(scene) must come before a material is evaluated (surface_bsdf
// sees to it).
#include "microfacet.h"
#include "scene_view.h"
#ifdef __cplusplus
#include "microfacet_tables.h"
KERNELS_BEGIN
FN void microfacet_begin(const_in(SceneView)) {}
FN uint microfacet_word(uint i) { return MICROFACET_TABLE[i]; }
KERNELS_END
#else
#define SPINEL_TABLE_ELSEWHERE
#include "microfacet_tables.h"
Words microfacet_words;
uint microfacet_first;
void microfacet_begin(const in SceneView scene) {
    microfacet_words = scene.words;
    microfacet_first = scene.microfacet_first;
}
uint microfacet_word(uint i) { return microfacet_words.at[microfacet_first + i]; }
#endif
KERNELS_BEGIN

// Two values to a word, 16 bits each, over [0, 1].
FN float microfacet_table(uint i) {
    uint word = microfacet_word(i >> 1);
    return float((i & 1u) == 0u ? word & 0xffffu : word >> 16) * (1.0f / 65535.0f);
}

// Linear interpolation; x and y in [0, 1].
FN float microfacet_table_1d(uint first, uint width, float x) {
    float fx = clamp(x, 0.0f, 1.0f) * float(width - 1u);
    uint ix = min(uint(fx), width - 2u);
    return mix(microfacet_table(first + ix), microfacet_table(first + ix + 1u), fx - float(ix));
}
FN float microfacet_table_2d(uint first, uint width, uint height, float x, float y) {
    float fy = clamp(y, 0.0f, 1.0f) * float(height - 1u);
    uint iy = min(uint(fy), height - 2u);
    uint row = first + iy * width;
    return mix(microfacet_table_1d(row, width, x), microfacet_table_1d(row + width, width, x), fy - float(iy));
}
FN float microfacet_table_3d(uint first, uint width, uint height, uint depth, float x, float y, float z) {
    float fz = clamp(z, 0.0f, 1.0f) * float(depth - 1u);
    uint iz = min(uint(fz), depth - 2u);
    uint slice = first + iz * width * height;
    return mix(microfacet_table_2d(slice, width, height, x, y),
               microfacet_table_2d(slice + width * height, width, height, x, y), fz - float(iz));
}

// Coordinates in which the losses are nearly linear. Masking changes fastest where µ is about α (or α^½).
FN float microfacet_warp(float mu, float scale) { return mu / (mu + scale) * (1.0f + scale); }
FN float microfacet_table_alpha(float roughness) { return max(sqr(roughness), 1e-4f); }

// Position along the table of relative indices, n ≥ 1: linear in (n − 1) / (n + 1), so that 1.5 is a node.
FN float microfacet_ior_coordinate(float n) { return 2.0f * (n - 1.0f) / (n + 1.0f); }

// Seen from the dense side a kink lies at the critical angle: half of the table below it, half above.
FN float microfacet_critical_coordinate(float mu, float alpha, float n) {
    float critical = sqrt(max(1.0f - 1.0f / (n * n), 1e-6f));
    if (mu < critical) return 0.5f * mu / (mu + alpha) * (critical + alpha) / critical;
    return 0.5f + 0.5f * (mu - critical) / (1.0f - critical);
}

// -------------------------------------------------------------------------------------------------------
// conductors 1 − E(µ): what a perfectly reflecting rough surface loses in a single bounce.
FN float ggx_missing(float roughness, float mu) {
    float x = sqrt(microfacet_warp(max(mu, 0.0f), microfacet_table_alpha(roughness)));
    return microfacet_table_2d(GGX_MISSING_FIRST, GGX_MISSING_WIDTH, GGX_MISSING_HEIGHT, x, roughness);
}
FN float ggx_missing_average(float roughness) {
    return microfacet_table_1d(GGX_MISSING_AVERAGE_FIRST, GGX_MISSING_HEIGHT, roughness);
}

// The lobe over lambert: (1 − E(o)) (1 − E(i)) / (1 − E_average).
FN float ggx_multiple(float missing_o, float missing_i, float missing_average) {
    return missing_o * missing_i / max(missing_average, 1e-6f);
}

// Colour of that lobe: light that bounced at least twice, off microfacets of mean reflectance `fresnel`.
FN vec3 ggx_multiple_tint(vec3 fresnel, float missing_average) {
    return fresnel * fresnel * (1.0f - missing_average) / max(vec3(1.0f) - fresnel * missing_average, vec3(1e-6f));
}

// Albedo of a single bounce with reflectance (1 − o·m)⁵, the other half of Schlick's Fresnel, given missing =
// 1 − E(µ). The table holds the cosine that has this weight, relative to µ.
FN float ggx_schlick_part(float roughness, float mu, float missing) {
    float x = microfacet_warp(max(mu, 0.0f), sqrt(microfacet_table_alpha(roughness)));
    float shift = microfacet_table_2d(GGX_SCHLICK_FIRST, GGX_SCHLICK_WIDTH, GGX_SCHLICK_HEIGHT, x, roughness) - 0.5f;
    float c = clamp(1.0f - mu - shift, 0.0f, 1.0f);
    return (1.0f - missing) * c * c * c * c * c;
}
FN float ggx_schlick_part_average(float roughness) {
    return microfacet_table_1d(GGX_SCHLICK_AVERAGE_FIRST, GGX_SCHLICK_HEIGHT, roughness);
}

// -------------------------------------------------------------------------------------------------------
// dielectrics What a rough interface loses of flux from wo in a single reflection or refraction. relative_ior
// as in Bsdf.
FN float dielectric_missing(float roughness, float mu, float relative_ior) {
    float alpha = microfacet_table_alpha(roughness);
    mu = max(mu, 0.0f);
    if (relative_ior > 1.0f) {
        return microfacet_table_3d(THIN_MISSING_FIRST, THIN_MISSING_WIDTH, DIELECTRIC_HEIGHT, DIELECTRIC_DEPTH,
                                   sqrt(microfacet_warp(mu, alpha)), roughness,
                                   microfacet_ior_coordinate(relative_ior));
    }
    float n = 1.0f / relative_ior;
    return microfacet_table_3d(DENSE_MISSING_FIRST, DENSE_MISSING_WIDTH, DIELECTRIC_HEIGHT, DIELECTRIC_DEPTH,
                               microfacet_critical_coordinate(mu, alpha, n), roughness, microfacet_ior_coordinate(n));
}
FN float dielectric_missing_average(float roughness, float relative_ior) {
    uint first = relative_ior > 1.0f ? THIN_MISSING_AVERAGE_FIRST : DENSE_MISSING_AVERAGE_FIRST;
    float n = relative_ior > 1.0f ? relative_ior : 1.0f / relative_ior;
    return microfacet_table_2d(first, DIELECTRIC_HEIGHT, DIELECTRIC_DEPTH, roughness, microfacet_ior_coordinate(n));
}

KERNELS_END
#endif
