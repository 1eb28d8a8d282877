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
    float roughness;  // of the layer
    vec3 again;       // colour of the layer's multiple scattering, see ggx_multiple_tint
    vec3 energy;      // coated_energy()
};

// Cosine-weighted mean of Schlick's Fresnel over the hemisphere.
FN vec3 schlick_average(vec3 f0) { return mix(f0, vec3(1.0f), 1.0f / 21.0f); }

FN bool coated_is_smooth(float roughness) { return ggx_alpha(roughness) < GGX_ALPHA_DELTA; }

// x: mean of what a single bounce loses; y: the dielectric layer's colour of multiple scattering; z: its mean
// T.
FN vec3 coated_energy(float f0, float roughness) {
    if (coated_is_smooth(roughness)) return vec3(0.0f, 0.0f, 1.0f - schlick_average(vec3(f0)).x);
    float missing = ggx_missing_average(roughness);
    float again = ggx_multiple_tint(schlick_average(vec3(f0)), missing).x;
    return vec3(missing, again, 1.0f - mix(ggx_schlick_part_average(roughness), 1.0f - missing, f0) - again * missing);
}

// The layer towards a direction.
struct CoatedView {
    float missing;  // by a single bounce
    float weight;   // albedo of a single bounce with Schlick's (1 − µ)⁵ for its reflectance
    float through;  // T
};
FN CoatedView coated_view(const_in(Coated) c, float mu) {
    if (coated_is_smooth(c.roughness)) {
        float weight = schlick_weight(mu);
        return CoatedView(0.0f, weight, (1.0f - weight) * (1.0f - c.layer_f0));
    }
    float missing = ggx_missing(c.roughness, mu);
    float weight = ggx_schlick_part(c.roughness, mu, missing);
    float albedo = mix(weight, 1.0f - missing, c.layer_f0) + c.energy.y * missing;
    return CoatedView(missing, weight, max(1.0f - albedo, 0.0f));
}

// Schlick's F = f0 (1 − w) + w averaged over a single bounce.
FN vec3 coated_specular_albedo(const_in(Coated) c, const_in(CoatedView) o) {
    return mix(vec3(o.weight), vec3(1.0f - o.missing), c.f0);
}
FN vec3 coated_matte_albedo(const_in(Coated) c, const_in(CoatedView) o) {
    return c.base * o.through + c.again * o.missing;
}

FN float coated_specular_probability(const_in(Coated) c, const_in(CoatedView) o) {
    float specular = average(coated_specular_albedo(c, o));
    float total = specular + average(coated_matte_albedo(c, o));
    return total > 0.0f ? specular / total : 1.0f;
}

FN vec4 coated_eval_pdf_view(const_in(Coated) c, vec3 wo, vec3 wi, const_in(CoatedView) o, float specular_probability) {
    CoatedView i = coated_view(c, wi.z);
    float lambert = lambert_pdf(wi);
    vec3 value = (c.base * (o.through * i.through / max(c.energy.z, 1e-6f)) +
                  c.again * ggx_multiple(o.missing, i.missing, c.energy.x)) *
                 lambert;
    float pdf = (1.0f - specular_probability) * lambert;
    if (!coated_is_smooth(c.roughness)) {
        vec3 m = normalize(wo + wi);
        vec2 once = ggx_reflection(ggx_alpha(c.roughness), wo, wi, m);
        value += mix(vec3(schlick_weight(dot(wo, m))), vec3(1.0f), c.f0) * once.x;
        pdf += specular_probability * once.y;
    }
    return vec4(value, pdf);
}

FN vec4 coated_eval_pdf(const_in(Coated) c, vec3 wo, vec3 wi) {
    if (wo.z <= 0.0f || wi.z <= 0.0f) return vec4(0.0f);
    CoatedView o = coated_view(c, wo.z);
    return coated_eval_pdf_view(c, wo, wi, o, coated_specular_probability(c, o));
}

FN BsdfSample coated_sample(const_in(Coated) c, vec3 wo, float u_lobe, vec2 u) {
    CoatedView o = coated_view(c, wo.z);
    float p = coated_specular_probability(c, o);
    vec3 wi = vec3(0.0f);
    if (u_lobe < p) {
        if (coated_is_smooth(c.roughness)) {
            return BsdfSample(vec3(-wo.x, -wo.y, wo.z), coated_specular_albedo(c, o) / p, p, LOBE_DELTA);
        }
        vec3 m = ggx_sample(ggx_alpha(c.roughness), wo, u);
        wi = 2.0f * dot(wo, m) * m - wo;
        if (wi.z <= 0.0f) return bsdf_failed();
    } else {
        wi = square_to_cosine_hemisphere(u);
    }
    return bsdf_weighted(wi, coated_eval_pdf_view(c, wo, wi, o, p));
}

FN vec3 coated_albedo(const_in(Coated) c, vec3 wo) {
    CoatedView o = coated_view(c, wo.z);
    return min(coated_specular_albedo(c, o) + coated_matte_albedo(c, o), vec3(1.0f));
}

KERNELS_END
#endif
