#ifndef SPINEL_KERNELS_PLASTIC_H
#define SPINEL_KERNELS_PLASTIC_H
// plastic: a diffuse base under a clear dielectric coat (varnished wood, ceramics, toys). Light that the coat
// throws back onto the base from inside is followed to all orders, so colours grow more saturated as in
// reality and a white base under any coat reflects everything. Members of Material: color (reflectance of the
// base), roughness and ior of the coat.
#include "coated.h"
KERNELS_BEGIN

// Leaves in b.color what the base reflects through the coat, internal reflections included.
FN void plastic_make(inout(Bsdf) b) {
    b.roughness = clamp(b.roughness, 0.0f, 1.0f);
    b.ior = max(b.ior, 1.0f);
    float f0 = fresnel_f0(b.ior);
    b.energy = coated_energy(f0, b.roughness);
    b.again = vec3(b.energy.y);
    // Of diffuse light that comes up from the base, the coat lets T_average / n² out and reflects the rest.
    float out_share = b.energy.z / (b.ior * b.ior);
    b.color = b.color * out_share / (vec3(1.0f) - b.color * (1.0f - out_share));
}

FN Coated plastic_layers(const_in(Bsdf) b) {
    float f0 = fresnel_f0(b.ior);
    return Coated(vec3(f0), f0, b.color, b.roughness, b.again, b.energy);
}

FN vec4 plastic_eval_pdf(const_in(Bsdf) b, vec3 wo, vec3 wi) { return coated_eval_pdf(plastic_layers(b), wo, wi); }
FN BsdfSample plastic_sample(const_in(Bsdf) b, vec3 wo, float u_lobe, vec2 u) {
    return coated_sample(plastic_layers(b), wo, u_lobe, u);
}
FN vec3 plastic_albedo(const_in(Bsdf) b, vec3 wo) { return coated_albedo(plastic_layers(b), wo); }
FN bool plastic_is_delta(const_in(Bsdf)) { return false; }

KERNELS_END

#ifdef __cplusplus
#include "description.h"
namespace spinel::kernels {
inline constexpr MaterialParameter plastic_parameters[] = {
    {"color", &Material::color, vec3(0.8f), 0, 1, &Material::color_texture,
     "Reflectance of the base under the coat, linear Rec.709."},
    {"roughness", &Material::roughness, 0.0f, 0, 1, &Material::roughness_texture,
     "Of the coat, perceptual: GGX alpha = roughness squared; 0: a mirror finish."},
    {"ior", &Material::ior, 1.5f, 1, 3, nullptr, "Index of refraction of the coat."},
};
inline constexpr MaterialDescription plastic_description = {
    "A diffuse base under a clear coat, smooth or rough (GGX).", plastic_parameters, {}};
}  // namespace spinel::kernels
#endif
#endif
