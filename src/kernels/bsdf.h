#ifndef SPINEL_KERNELS_BSDF_H
#define SPINEL_KERNELS_BSDF_H
// Scattering at a surface: one switch per question over the table of materials. Conventions: bsdf_types.h.
#include "materials.h"
KERNELS_BEGIN

// color, roughness and metallic are the material's own with their textures applied; relative_ior is
// n_transmitted / n_incident as seen from wo.
FN Bsdf make_bsdf(const_in(Material) m, vec3 color, float roughness, float metallic, float relative_ior) {
    Bsdf b = Bsdf(m.kind, color, roughness, metallic, m.eta, m.k, m.edge_color, m.ior, relative_ior, vec3(0.0f),
                  vec3(0.0f), m.coat, m.coat_roughness, 1.0f, m.transmission);
#define SPINEL_MATERIAL_CASE(number, CONSTANT, name) \
    case MATERIAL_##CONSTANT: name##_make(b); break;
    switch (b.kind) { SPINEL_MATERIALS(SPINEL_MATERIAL_CASE) }
#undef SPINEL_MATERIAL_CASE
    return b;
}

// rgb: f·|cos θi|; a: density [1/sr]. Delta lobes count for nothing in either.
FN vec4 bsdf_eval_pdf(const_in(Bsdf) b, vec3 wo, vec3 wi) {
#define SPINEL_MATERIAL_CASE(number, CONSTANT, name) \
    case MATERIAL_##CONSTANT: return name##_eval_pdf(b, wo, wi);
    switch (b.kind) { SPINEL_MATERIALS(SPINEL_MATERIAL_CASE) }
#undef SPINEL_MATERIAL_CASE
    return vec4(0.0f);
}

FN vec3 bsdf_eval(const_in(Bsdf) b, vec3 wo, vec3 wi) {
    vec4 value_pdf = bsdf_eval_pdf(b, wo, wi);
    return vec3(value_pdf.x, value_pdf.y, value_pdf.z);
}

FN float bsdf_pdf(const_in(Bsdf) b, vec3 wo, vec3 wi) { return bsdf_eval_pdf(b, wo, wi).w; }

// u_lobe picks among lobes, u a direction within one.
FN BsdfSample bsdf_sample(const_in(Bsdf) b, vec3 wo, float u_lobe, vec2 u) {
    if (!(wo.z > 0.0f)) return bsdf_failed();
#define SPINEL_MATERIAL_CASE(number, CONSTANT, name) \
    case MATERIAL_##CONSTANT: return name##_sample(b, wo, u_lobe, u);
    switch (b.kind) { SPINEL_MATERIALS(SPINEL_MATERIAL_CASE) }
#undef SPINEL_MATERIAL_CASE
    return bsdf_failed();
}

// A cheap estimate of the fraction of light that is scattered, by colour: for denoisers, not for transport.
FN vec3 bsdf_albedo(const_in(Bsdf) b, vec3 wo) {
#define SPINEL_MATERIAL_CASE(number, CONSTANT, name) \
    case MATERIAL_##CONSTANT: return name##_albedo(b, wo);
    switch (b.kind) { SPINEL_MATERIALS(SPINEL_MATERIAL_CASE) }
#undef SPINEL_MATERIAL_CASE
    return vec3(0.0f);
}

// Whether all its lobes are deltas: then eval is 0 everywhere and next-event estimation is of no use.
FN bool bsdf_is_delta(const_in(Bsdf) b) {
#define SPINEL_MATERIAL_CASE(number, CONSTANT, name) \
    case MATERIAL_##CONSTANT: return name##_is_delta(b);
    switch (b.kind) { SPINEL_MATERIALS(SPINEL_MATERIAL_CASE) }
#undef SPINEL_MATERIAL_CASE
    return false;
}

KERNELS_END
#endif
