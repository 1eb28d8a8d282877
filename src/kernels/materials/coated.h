#ifndef SPINEL_KERNELS_COATED_H
#define SPINEL_KERNELS_COATED_H
// A diffuse base under a smooth or rough specular layer: what plastic and principled share.
// Specular: GGX with Schlick's Fresnel and Kulla–Conty multiple scattering. Base: what the layer lets in and
// out again,
//   f = base · T(wo) T(wi) / (π T_average),  T = 1 − directional albedo of the layer,
// reciprocal, and it returns exactly what the layer did not reflect (Kelemen, Szirmay-Kalos, "A Microfacet
// Based Coupled Specular-Matte BRDF Model with Importance Sampling", Eurographics 2001).
#include "../bsdf_types.h"
#include "../fresnel.h"
#include "../microfacet_energy.h"
KERNELS_BEGIN

struct Coated {
    vec3 f0;          // of the specular layer
    float layer_f0;   // of the dielectric part of it, which covers the base
    vec3 base;        // reflectance of the base, as seen through a layer that lets everything pass
    vec3 again;       // colour of the layer's multiple scattering, see ggx_multiple_tint
    float roughness;  // of the layer
};

FN bool coated_is_smooth(const_in(Coated) c) { return ggx_alpha(c.roughness) < GGX_ALPHA_DELTA; }

// Cosine-weighted mean of Schlick's Fresnel over the hemisphere.
FN vec3 schlick_average(vec3 f0) { return mix(f0, vec3(1.0f), 1.0f / 21.0f); }

FN float coated_layer_albedo(float f0, float roughness, float mu) {
    if (ggx_alpha(roughness) < GGX_ALPHA_DELTA) return mix(f0, 1.0f, schlick_weight(mu));
    float missing = ggx_missing(roughness, mu);
    vec3 tint = ggx_multiple_tint(schlick_average(vec3(f0)), roughness);
    return min(mix(ggx_schlick_part(roughness, mu, missing), 1.0f - missing, f0) + tint.x * missing, 1.0f);
}
FN float coated_layer_albedo_average(float f0, float roughness) {
    if (ggx_alpha(roughness) < GGX_ALPHA_DELTA) return mix(f0, 1.0f, 1.0f / 21.0f);
    float missing = ggx_missing_average(roughness);
    vec3 tint = ggx_multiple_tint(schlick_average(vec3(f0)), roughness);
    return mix(ggx_schlick_part_average(roughness), 1.0f - missing, f0) + tint.x * missing;
}

// mix(schlick, whole, f0): Schlick's F = f0 (1 − w) + w, averaged over a lobe of albedo `whole`.
FN vec3 coated_specular_albedo(const_in(Coated) c, float mu) {
    if (coated_is_smooth(c)) return mix(vec3(schlick_weight(mu)), vec3(1.0f), c.f0);
    float missing = ggx_missing(c.roughness, mu);
    return mix(vec3(ggx_schlick_part(c.roughness, mu, missing)), vec3(1.0f - missing), c.f0);
}

// Value and density but for the specular part, with probability `p` of the specular lobe.
struct CoatedMatte {
    vec3 value;
    float specular_probability;
};
FN CoatedMatte coated_matte(const_in(Coated) c, vec3 wo, float mu_i) {
    float through_o = 1.0f - coated_layer_albedo(c.layer_f0, c.roughness, wo.z);
    float through_i = 1.0f - coated_layer_albedo(c.layer_f0, c.roughness, mu_i);
    float through_average = 1.0f - coated_layer_albedo_average(c.layer_f0, c.roughness);
    vec3 value = c.base * (through_o * through_i / max(through_average, 1e-6f));
    vec3 expected = c.base * through_o;
    if (!coated_is_smooth(c)) {
        float missing = ggx_missing(c.roughness, wo.z);
        value += c.again * ggx_multiple(c.roughness, missing, mu_i);
        expected += c.again * missing;
    }
    float specular = average(coated_specular_albedo(c, wo.z));
    float total = specular + average(expected);
    return CoatedMatte(value, total > 0.0f ? specular / total : 1.0f);
}

FN vec4 coated_eval_pdf(const_in(Coated) c, vec3 wo, vec3 wi) {
    if (wo.z <= 0.0f || wi.z <= 0.0f) return vec4(0.0f);
    CoatedMatte matte = coated_matte(c, wo, wi.z);
    float lambert = lambert_pdf(wi);
    vec3 value = matte.value * lambert;
    float pdf = (1.0f - matte.specular_probability) * lambert;
    if (!coated_is_smooth(c)) {
        vec3 m = normalize(wo + wi);
        vec2 once = ggx_reflection(ggx_alpha(c.roughness), wo, wi, m);
        value += mix(vec3(schlick_weight(dot(wo, m))), vec3(1.0f), c.f0) * once.x;
        pdf += matte.specular_probability * once.y;
    }
    return vec4(value, pdf);
}

FN BsdfSample coated_sample(const_in(Coated) c, vec3 wo, float u_lobe, vec2 u) {
    float p = coated_matte(c, wo, 1.0f).specular_probability;  // does not depend on wi
    vec3 wi = vec3(0.0f);
    if (u_lobe < p) {
        if (coated_is_smooth(c)) {
            return BsdfSample(vec3(-wo.x, -wo.y, wo.z), coated_specular_albedo(c, wo.z) / p, p, LOBE_DELTA);
        }
        vec3 m = ggx_sample(ggx_alpha(c.roughness), wo, u);
        wi = 2.0f * dot(wo, m) * m - wo;
        if (wi.z <= 0.0f) return bsdf_failed();
    } else {
        wi = square_to_cosine_hemisphere(u);
    }
    return bsdf_weighted(wi, coated_eval_pdf(c, wo, wi));
}

FN vec3 coated_albedo(const_in(Coated) c, vec3 wo) {
    return coated_specular_albedo(c, wo.z) +
           c.base * (1.0f - coated_layer_albedo(c.layer_f0, c.roughness, wo.z));
}

KERNELS_END
#endif
