#ifndef SPINEL_KERNELS_PRINCIPLED_H
#define SPINEL_KERNELS_PRINCIPLED_H
// principled: the metallic-roughness material of glTF 2.0 (specification, Appendix B), with the specular
// layer and the diffuse base coupled so that energy is conserved at every angle, which the appendix leaves to
// the implementation. Members of Material: color (base colour), metallic, roughness, ior (of the dielectric
// part; glTF: 1.5).
#include "coated.h"
KERNELS_BEGIN

FN void principled_make(inout(Bsdf) b) {
    b.roughness = clamp(b.roughness, 0.0f, 1.0f);
    b.metallic = clamp(b.metallic, 0.0f, 1.0f);
    b.ior = max(b.ior, 1.0f);
    b.energy = coated_energy(fresnel_f0(b.ior), b.roughness);
    b.again = mix(vec3(b.energy.y), ggx_multiple_tint(schlick_average(b.color), b.energy.x), b.metallic);
}

// Single scattering is linear in F0, so the mix of a dielectric and a metal is one lobe of mixed F0.
FN Coated principled_layers(const_in(Bsdf) b) {
    float f0 = fresnel_f0(b.ior);
    return Coated(mix(vec3(f0), b.color, b.metallic), f0, b.color * (1.0f - b.metallic), b.roughness, b.again,
                  b.energy);
}

FN vec4 principled_eval_pdf(const_in(Bsdf) b, vec3 wo, vec3 wi) {
    return coated_eval_pdf(principled_layers(b), wo, wi);
}
FN BsdfSample principled_sample(const_in(Bsdf) b, vec3 wo, float u_lobe, vec2 u) {
    return coated_sample(principled_layers(b), wo, u_lobe, u);
}
FN vec3 principled_albedo(const_in(Bsdf) b, vec3 wo) { return coated_albedo(principled_layers(b), wo); }
FN bool principled_is_delta(const_in(Bsdf) b) { return b.metallic == 1.0f && ggx_alpha(b.roughness) < GGX_ALPHA_DELTA; }

KERNELS_END

#ifdef __cplusplus
#include "description.h"
namespace spinel::kernels {
inline constexpr MaterialParameter principled_parameters[] = {
    {"color", &Material::color, vec3(1.0f), 0, 1, &Material::color_texture,
     "Base colour: reflectance of the diffuse base, or F0 of a metal, linear Rec.709."},
    {"metallic", &Material::metallic, 0.0f, 0, 1, &Material::metallic_texture, "0: dielectric, 1: metal."},
    {"roughness", &Material::roughness, 0.5f, 0, 1, &Material::roughness_texture,
     "Perceptual: GGX alpha = roughness squared."},
    {"ior", &Material::ior, 1.5f, 1, 3, nullptr, "Index of refraction of the dielectric part; sets its F0."},
};
inline constexpr MaterialDescription principled_description = {
    "Metallic-roughness material of glTF 2.0.", principled_parameters, {}};
}  // namespace spinel::kernels
#endif
#endif
