#ifndef SPINEL_KERNELS_DIELECTRIC_H
#define SPINEL_KERNELS_DIELECTRIC_H
// dielectric: glass, water, ice. Smooth: mirror and Snell's refraction. Rough: GGX reflection and refraction,
//   Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007,
// with masking correlated by height for both, and lobes that put back what a single scattering loses, shared
// between reflection and transmission so that the whole stays reciprocal (after Kulla, Conty, SIGGRAPH 2017
// course). Transmitted radiance is scaled by 1/η², η = relative_ior. Equal indices on both sides: nothing
// there, whatever the roughness. Members of Material: color (tint of what is transmitted; 1: physical),
// roughness, ior; absorption, priority and interior belong to the inside.
#include "../bsdf_types.h"
#include "../fresnel.h"
#include "../microfacet_energy.h"
KERNELS_BEGIN

FN bool dielectric_is_delta(const_in(Bsdf) b) {
    return ggx_alpha(b.roughness) < GGX_ALPHA_DELTA || abs(b.relative_ior - 1.0f) < 1e-3f;
}

// energy: mean of what single scattering loses on wo's side (x) and on the other (y); z: the share of it that
// the compensation transmits, as flux. The rest is reflected.
FN void dielectric_make(inout(Bsdf) b) {
    b.roughness = clamp(b.roughness, 0.0f, 1.0f);
    if (dielectric_is_delta(b)) return;
    float average = max(dielectric_missing_average(b.roughness, b.relative_ior), 1e-6f);
    float other = max(dielectric_missing_average(b.roughness, 1.0f / b.relative_ior), 1e-6f);
    // Reciprocity (f/n² is symmetric) asks for share · average = η² · share' · average'. Both sides get at
    // most what a diffuse interface passes: 1 − F_average from the thin side, that over n² from the dense
    // one.
    float n = max(b.relative_ior, 1.0f / b.relative_ior);
    float passed = 1.0f - fresnel_dielectric_average(n);
    float share = (b.relative_ior > 1.0f ? passed : passed / (n * n)) * other / max(average, other);
    b.energy = vec3(average, other, share);
}

FN vec4 dielectric_eval_pdf_missing(const_in(Bsdf) b, vec3 wo, vec3 wi, float missing) {
    float eta = b.relative_ior;
    float alpha = ggx_alpha(b.roughness);
    float lambert = lambert_pdf(wi);
    if (wi.z > 0.0f) {
        vec3 m = normalize(wo + wi);
        float fresnel = fresnel_dielectric(dot(wo, m), eta);
        vec2 once = ggx_reflection(alpha, wo, wi, m) * fresnel;
        float share = 1.0f - b.energy.z;
        float again = ggx_multiple(missing, dielectric_missing(b.roughness, wi.z, eta), b.energy.x) * lambert;
        float value = once.x + share * again;
        return vec4(vec3(value), mix(once.y, share * lambert, missing));
    }
    float once_value = 0.0f;
    float once_pdf = 0.0f;
    vec3 h = wo + eta * wi;
    float h2 = dot(h, h);
    if (h2 > 1e-12f) {
        vec3 m = h * ((h.z < 0.0f ? -1.0f : 1.0f) * inversesqrt(h2));
        float om = dot(wo, m);
        float im = dot(wi, m);
        if (om > 0.0f && im < 0.0f) {
            float fresnel = fresnel_dielectric(om, eta);
            // dm/dwi = η² |wi·m| / |h|², h = wo + η wi.
            once_pdf = (1.0f - fresnel) * ggx_sample_pdf(alpha, wo, m) * (eta * eta * -im / h2);
            once_value = once_pdf * ggx_g2(alpha, wo, wi) / ggx_g1(alpha, wo);
        }
    }
    float again = ggx_multiple(missing, dielectric_missing(b.roughness, -wi.z, 1.0f / eta), b.energy.y) * lambert;
    float value = (once_value + b.energy.z * again) / (eta * eta);
    return vec4(b.color * value, mix(once_pdf, b.energy.z * lambert, missing));
}

FN vec4 dielectric_eval_pdf(const_in(Bsdf) b, vec3 wo, vec3 wi) {
    if (wo.z <= 0.0f || wi.z == 0.0f || dielectric_is_delta(b)) return vec4(0.0f);
    return dielectric_eval_pdf_missing(b, wo, wi, dielectric_missing(b.roughness, wo.z, b.relative_ior));
}

FN BsdfSample dielectric_sample(const_in(Bsdf) b, vec3 wo, float u_lobe, vec2 u) {
    float eta = b.relative_ior;
    if (dielectric_is_delta(b)) {
        if (abs(eta - 1.0f) < 1e-3f) return BsdfSample(-wo, b.color, 1.0f, LOBE_DELTA | LOBE_TRANSMISSION);
        float fresnel = fresnel_dielectric(wo.z, eta);
        if (u_lobe < fresnel) return BsdfSample(vec3(-wo.x, -wo.y, wo.z), vec3(1.0f), fresnel, LOBE_DELTA);
        vec3 refracted = normalize(vec3(-wo.x / eta, -wo.y / eta, -refracted_cosine(wo.z, eta)));
        return BsdfSample(refracted, b.color / (eta * eta), 1.0f - fresnel, LOBE_DELTA | LOBE_TRANSMISSION);
    }
    float missing = dielectric_missing(b.roughness, wo.z, eta);  // as much as goes to the diffuse lobes
    vec3 wi = vec3(0.0f);
    if (u_lobe < missing) {
        wi = square_to_cosine_hemisphere(u);
        if (u_lobe < missing * b.energy.z) wi.z = -wi.z;
    } else {
        u_lobe = (u_lobe - missing) / (1.0f - missing);
        vec3 m = ggx_sample(ggx_alpha(b.roughness), wo, u);
        float om = dot(wo, m);
        float fresnel = fresnel_dielectric(om, eta);
        if (u_lobe < fresnel) {
            wi = 2.0f * om * m - wo;
            if (wi.z <= 0.0f) return bsdf_failed();
        } else {
            wi = normalize((om / eta - refracted_cosine(om, eta)) * m - wo / eta);
            if (wi.z >= 0.0f) return bsdf_failed();
        }
    }
    return bsdf_weighted(wi, dielectric_eval_pdf_missing(b, wo, wi, missing));
}

FN vec3 dielectric_albedo(const_in(Bsdf) b, vec3 wo) {
    float fresnel = fresnel_dielectric(wo.z, b.relative_ior);
    return mix(b.color, vec3(1.0f), fresnel);
}

KERNELS_END

#ifdef __cplusplus
#include "description.h"
namespace spinel::kernels {
inline constexpr MaterialParameter dielectric_parameters[] = {
    {"color", &Material::color, vec3(1.0f), 0, 1, &Material::color_texture,
     "Tint of light that crosses the surface; 1: physical (colour glass by absorption)."},
    {"roughness", &Material::roughness, 0.0f, 0, 1, &Material::roughness_texture,
     "Perceptual: GGX alpha = roughness squared; 0: clear."},
    {"ior", &Material::ior, 1.5f, 1, 3, nullptr, "Index of refraction of the inside."},
    {"absorption", &Material::absorption, vec3(0.0f), 0, 1e6f, nullptr,
     "Absorption coefficient of the inside per unit length (Beer-Lambert)."},
    {"priority", &Material::priority, 0, -1000, 1000, nullptr, "Where dielectrics overlap, the highest priority wins."},
};
inline constexpr MaterialDescription dielectric_description = {
    "Glass, water, ice: reflection and refraction, smooth or rough (GGX).", dielectric_parameters, {}};
}  // namespace spinel::kernels
#endif
#endif
