#ifndef SPINEL_KERNELS_DIFFUSE_H
#define SPINEL_KERNELS_DIFFUSE_H
// diffuse: matte paint, paper, clay. roughness 0 is exactly Lambert; above, the energy-preserving Oren–Nayar
// model of Portsmouth, Kutz, Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF", JCGT 14(1), 2025:
// Fujii's qualitative single scattering plus a reciprocal lobe for what scatters more than once, so that
// white stays white. Members of Material: color (reflectance), roughness (Fujii's σ, 0 … 1).
#include "../bsdf_types.h"
KERNELS_BEGIN

const float EON_C1 = 0.28779340f;  // 1/2 − 2/(3π)
const float EON_C2 = 0.07248800f;  // 2/3 − 28/(15π)

// Albedo of single scattering towards µ for a white surface, exact.
FN float eon_single_albedo(float mu, float r) {
    float si = safe_sqrt(1.0f - mu * mu);
    float g = si * (acos(clamp(mu, -1.0f, 1.0f)) - si * mu) +
              (2.0f / 3.0f) * ((si / max(mu, 1e-6f)) * (1.0f - si * si * si) - si);
    return (1.0f + r * INV_PI * g) / (1.0f + EON_C1 * r);
}

FN void diffuse_make(inout(Bsdf) b) { b.roughness = clamp(b.roughness, 0.0f, 1.0f); }

FN vec4 diffuse_eval_pdf(const_in(Bsdf) b, vec3 wo, vec3 wi) {
    if (wo.z <= 0.0f || wi.z <= 0.0f) return vec4(0.0f);
    float pdf = lambert_pdf(wi);
    float r = b.roughness;
    if (r == 0.0f) return vec4(b.color * pdf, pdf);
    float s = wo.x * wi.x + wo.y * wi.y;
    float s_by_t = s > 0.0f ? s / max(wo.z, wi.z) : s;
    float a = 1.0f / (1.0f + EON_C1 * r);
    float mean = a * (1.0f + EON_C2 * r);
    vec3 once = b.color * (a * (1.0f + r * s_by_t));
    vec3 tint = b.color * b.color * mean / (vec3(1.0f) - b.color * (1.0f - mean));
    float lost =
        max(1.0f - eon_single_albedo(wo.z, r), 0.0f) * max(1.0f - eon_single_albedo(wi.z, r), 0.0f) / (1.0f - mean);
    return vec4((once + tint * lost) * pdf, pdf);
}

FN BsdfSample diffuse_sample(const_in(Bsdf) b, vec3 wo, float, vec2 u) {
    vec3 wi = square_to_cosine_hemisphere(u);
    if (b.roughness == 0.0f) return BsdfSample(wi, b.color, lambert_pdf(wi), 0u);
    return bsdf_weighted(wi, diffuse_eval_pdf(b, wo, wi));
}

FN vec3 diffuse_albedo(const_in(Bsdf) b, vec3) { return b.color; }
FN bool diffuse_is_delta(const_in(Bsdf)) { return false; }

KERNELS_END

#ifdef __cplusplus
#include "description.h"
namespace spinel::kernels {
inline constexpr MaterialParameter diffuse_parameters[] = {
    {"color", &Material::color, vec3(0.8f), 0, 1, &Material::color_texture, "Reflectance, linear Rec.709."},
    {"roughness", &Material::roughness, 0.0f, 0, 1, &Material::roughness_texture,
     "0: Lambert; above, Oren-Nayar (energy preserving) up to 1, very rough."},
};
inline constexpr MaterialDescription diffuse_description = {
    "Matte: Lambert, or energy-preserving Oren-Nayar where roughness is above 0.", diffuse_parameters, {}};
}  // namespace spinel::kernels
#endif
#endif
