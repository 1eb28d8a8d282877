#ifndef SPINEL_KERNELS_PRINCIPLED_H
#define SPINEL_KERNELS_PRINCIPLED_H
// principled: the metallic-roughness material of glTF 2.0 (specification, Appendix B), with the specular
// layer and the diffuse base coupled so that energy is conserved at every angle, which the appendix leaves to
// the implementation. Members of Material: color (base colour), metallic, roughness, ior (of the dielectric
// part; glTF: 1.5); coat, coat_roughness, transmission: principled_layers.h.
#include "principled_layers.h"
KERNELS_BEGIN

FN bool principled_is_layered(const_in(Bsdf) b) { return b.coat > 0.0f || b.transmission > 0.0f; }

// Single scattering is linear in F0, so the mix of a dielectric and a metal is one lobe of mixed F0.
FN Coated principled_base(const_in(Bsdf) b) {
    float f0 = fresnel_f0(b.ior);
    return Coated(mix(vec3(f0), b.color, b.metallic), f0, b.color * ((1.0f - b.metallic) * (1.0f - b.transmission)),
                  b.roughness, b.again, b.energy);
}

FN PrincipledLayers principled_layers(const_in(Bsdf) b) {
    return PrincipledLayers(principled_base(b), b.color * ((1.0f - b.metallic) * b.transmission), b.coat,
                            b.coat_roughness, b.coated_through);
}

FN void principled_make(inout(Bsdf) b) {
    b.roughness = clamp(b.roughness, 0.0f, 1.0f);
    b.metallic = clamp(b.metallic, 0.0f, 1.0f);
    b.ior = max(b.ior, 1.0f);
    b.energy = coated_energy(fresnel_f0(b.ior), b.roughness);
    b.again = mix(vec3(b.energy.y), ggx_multiple_tint(schlick_average(b.color), b.energy.x), b.metallic);
    b.coat = clamp(b.coat, 0.0f, 1.0f);
    b.coat_roughness = clamp(b.coat_roughness, 0.0f, 1.0f);
    b.transmission = clamp(b.transmission, 0.0f, 1.0f);
    if (principled_is_layered(b)) b.coated_through = principled_coated_through(principled_layers(b));
}

FN vec4 principled_eval_pdf(const_in(Bsdf) b, vec3 wo, vec3 wi) {
    if (principled_is_layered(b)) return principled_layered_eval_pdf(principled_layers(b), wo, wi);
    return coated_eval_pdf(principled_base(b), wo, wi);
}
FN BsdfSample principled_sample(const_in(Bsdf) b, vec3 wo, float u_lobe, vec2 u) {
    if (principled_is_layered(b)) return principled_layered_sample(principled_layers(b), wo, u_lobe, u);
    return coated_sample(principled_base(b), wo, u_lobe, u);
}
FN vec3 principled_albedo(const_in(Bsdf) b, vec3 wo) {
    if (principled_is_layered(b)) return principled_layered_albedo(principled_layers(b), wo);
    return coated_albedo(principled_base(b), wo);
}
FN bool principled_is_delta(const_in(Bsdf) b) {
    if (b.coat > 0.0f && !coated_is_smooth(b.coat_roughness)) return false;
    return (b.metallic == 1.0f || b.transmission == 1.0f) && coated_is_smooth(b.roughness);
}

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
    {"coat", &Material::coat, 0.0f, 0, 1, &Material::coat_texture,
     "Share that lies under a clear coat of index 1.5; of a texture, channel r."},
    {"coat_roughness", &Material::coat_roughness, 0.0f, 0, 1, &Material::coat_roughness_texture,
     "Of the coat, perceptual; of a texture, channel g."},
    {"transmission", &Material::transmission, 0.0f, 0, 1, &Material::transmission_texture,
     "Share of the dielectric base that is a thin wall: light passes with the base colour and is not bent (solid glass "
     "is `dielectric`); of a texture, channel r."},
};
inline constexpr MaterialDescription principled_description = {
    "Metallic-roughness material of glTF 2.0, with its clear coat and thin transmission.", principled_parameters, {}};
}  // namespace spinel::kernels
#endif
#endif
