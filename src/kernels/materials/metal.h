#ifndef SPINEL_KERNELS_METAL_H
#define SPINEL_KERNELS_METAL_H
// metal: GGX microfacets of a conductor. Light that bounces more than once between microfacets is put back by
// a reciprocal lobe: Kulla, Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017 course;
// tinted after Hill, "A Multi-Faceted Exploration", 2018. A metal that reflects everything then loses nothing
// at any roughness. Members of Material: either eta and k (complex index, exact Fresnel), or color (F0) and
// edge_color (reflectance at 82° as a fraction of Schlick's: the F82-tint model); roughness.
#include "../bsdf_types.h"
#include "../fresnel.h"
#include "../microfacet_energy.h"
KERNELS_BEGIN

// Leaves F0 in b.color and the F82 dip in b.edge_color; both also stand for an exact metal in the mean
// Fresnel of the multiple scattering. energy.x: mean of what a single bounce loses.
FN void metal_make(inout(Bsdf) b) {
    b.roughness = clamp(b.roughness, 0.0f, 1.0f);
    if (is_black(b.eta) && is_black(b.k)) {
        b.edge_color = fresnel_f82_dip(b.color, b.edge_color);
    } else {
        b.color = fresnel_conductor(1.0f, b.eta, b.k);
        vec3 schlick = b.color + (vec3(1.0f) - b.color) * schlick_weight(1.0f / 7.0f);
        b.edge_color = fresnel_f82_dip(b.color, fresnel_conductor(1.0f / 7.0f, b.eta, b.k) / max(schlick, vec3(1e-6f)));
    }
    b.energy.x = ggx_missing_average(b.roughness);
    b.again = ggx_multiple_tint(fresnel_f82_average(b.color, b.edge_color), b.energy.x);
}

FN vec3 metal_fresnel(const_in(Bsdf) b, float cosine) {
    if (is_black(b.eta) && is_black(b.k)) return fresnel_f82(cosine, b.color, b.edge_color);
    return fresnel_conductor(cosine, b.eta, b.k);
}

FN bool metal_is_delta(const_in(Bsdf) b) { return ggx_alpha(b.roughness) < GGX_ALPHA_DELTA; }

FN vec4 metal_eval_pdf_missing(const_in(Bsdf) b, vec3 wo, vec3 wi, float missing) {
    vec3 m = normalize(wo + wi);
    vec2 once = ggx_reflection(ggx_alpha(b.roughness), wo, wi, m);
    float lambert = lambert_pdf(wi);
    float again = ggx_multiple(missing, ggx_missing(b.roughness, wi.z), b.energy.x) * lambert;
    return vec4(metal_fresnel(b, dot(wo, m)) * once.x + b.again * again, mix(once.y, lambert, missing));
}

FN vec4 metal_eval_pdf(const_in(Bsdf) b, vec3 wo, vec3 wi) {
    if (wo.z <= 0.0f || wi.z <= 0.0f || metal_is_delta(b)) return vec4(0.0f);
    return metal_eval_pdf_missing(b, wo, wi, ggx_missing(b.roughness, wo.z));
}

FN BsdfSample metal_sample(const_in(Bsdf) b, vec3 wo, float u_lobe, vec2 u) {
    if (metal_is_delta(b)) return BsdfSample(vec3(-wo.x, -wo.y, wo.z), metal_fresnel(b, wo.z), 1.0f, LOBE_DELTA);
    float missing = ggx_missing(b.roughness, wo.z);  // as much as goes to the second lobe
    vec3 wi = vec3(0.0f);
    if (u_lobe < missing) {
        wi = square_to_cosine_hemisphere(u);
    } else {
        vec3 m = ggx_sample(ggx_alpha(b.roughness), wo, u);
        wi = 2.0f * dot(wo, m) * m - wo;
        if (wi.z <= 0.0f) return bsdf_failed();
    }
    return bsdf_weighted(wi, metal_eval_pdf_missing(b, wo, wi, missing));
}

FN vec3 metal_albedo(const_in(Bsdf) b, vec3 wo) { return metal_fresnel(b, wo.z); }

KERNELS_END

#ifdef __cplusplus
#include "description.h"
namespace spinel::kernels {
inline constexpr MaterialParameter metal_parameters[] = {
    {"color", &Material::color, vec3(0.9f), 0, 1, &Material::color_texture,
     "Reflectance at normal incidence (F0), linear Rec.709; not used where eta and k are given."},
    {"edge_color", &Material::edge_color, vec3(1.0f), 0, 1, nullptr,
     "Reflectance at 82 degrees as a fraction of Schlick's curve (F82 tint); 1: Schlick."},
    {"eta", &Material::eta, vec3(0.0f), 0, 20, nullptr, "Real part of the complex index of refraction, per channel."},
    {"k", &Material::k, vec3(0.0f), 0, 20, nullptr, "Imaginary part of the complex index of refraction, per channel."},
    {"roughness", &Material::roughness, 0.2f, 0, 1, &Material::roughness_texture,
     "Perceptual: GGX alpha = roughness squared; 0: a mirror."},
};
// Au, Ag, Cu: Johnson, Christy, Phys. Rev. B 6, 1972. Cr, Fe: Johnson, Christy, Phys. Rev. B 9, 1974. Al:
// Rakić 1995.
inline constexpr MaterialPreset metal_presets[] = {
    {"gold", vec3(0.143f, 0.375f, 1.442f), vec3(3.983f, 2.386f, 1.603f)},
    {"silver", vec3(0.155f, 0.117f, 0.138f), vec3(4.828f, 3.122f, 2.147f)},
    {"copper", vec3(0.200f, 0.924f, 1.102f), vec3(3.913f, 2.453f, 2.142f)},
    {"aluminium", vec3(1.657f, 0.880f, 0.521f), vec3(9.224f, 6.270f, 4.837f)},
    {"chromium", vec3(4.370f, 2.917f, 1.655f), vec3(5.206f, 4.231f, 3.755f)},
    {"iron", vec3(2.911f, 2.950f, 2.585f), vec3(3.089f, 2.932f, 2.767f)},
};
inline constexpr MaterialDescription metal_description = {
    "Conductor: GGX microfacets with multiple scattering, by complex index or by colour.", metal_parameters,
    metal_presets};
}  // namespace spinel::kernels
#endif
#endif
