#ifndef SPINEL_KERNELS_PRINCIPLED_LAYERS_H
#define SPINEL_KERNELS_PRINCIPLED_LAYERS_H
// What principled has over and in place of its base: a clear coat (KHR_materials_clearcoat) and a thin wall that light
// passes without being bent (KHR_materials_transmission), both with any roughness.
//
// A coat of index 1.5 reflects E(µ) and lets T(µ) = 1 − E(µ) pass. The diffuse base under it is seen through both
// layers, as in coated.h: base · T'(o) T'(i) / (π T'_average), T' = T times what the specular layer lets pass. All else
// under it is multiplied by min(T(o), T(i)): reciprocal, never more than what the coat let in, and exactly that for a
// mirror, whose light goes to and fro between the layers until it is out.
//
// The wall transmits what its layer does not reflect, the mirror image of the reflected lobe; what bounces more than
// once between microfacets goes through diffusely. Both of its sides are alike, the coat included.
#include "coated.h"
KERNELS_BEGIN

const float COAT_F0 = 0.04f;

struct PrincipledLayers {
    Coated base;  // its matte part without what the wall lets through
    vec3 wall;    // colour of the wall times its share
    float coat;   // share of the coat
    float coat_roughness;
    float coated_through;  // T'_average
};

// Towards a direction.
struct PrincipledView {
    CoatedView base;
    float coat;  // E
};
FN PrincipledView principled_view(const_in(PrincipledLayers) p, float mu) {
    PrincipledView view = PrincipledView(coated_view(p.base, mu), 0.0f);
    if (p.coat == 0.0f) return view;
    float missing = 0.0f;
    float weight = schlick_weight(mu);
    if (!coated_is_smooth(p.coat_roughness)) {
        missing = ggx_missing(p.coat_roughness, mu);
        weight = ggx_schlick_part(p.coat_roughness, mu, missing);
    }
    view.coat = p.coat * mix(weight, 1.0f - missing, COAT_F0);
    return view;
}

// T'_average, by Gauss's rule of four points over µ².
FN float principled_coated_through(const_in(PrincipledLayers) p) {
    if (p.coat == 0.0f) return p.base.energy.z;
    float sum = 0.0f;
    for (uint i = 0u; i < 4u; ++i) {
        bool inner = i == 1u || i == 2u;
        float offset = inner ? 0.1699905f : 0.4305682f;
        PrincipledView view = principled_view(p, sqrt(i < 2u ? 0.5f - offset : 0.5f + offset));
        sum += (inner ? 0.3260726f : 0.1739274f) * view.base.through * (1.0f - view.coat);
    }
    return sum;
}

// Probabilities of the lobes: the coat's, the specular one, the matte one, the wall's.
FN vec4 principled_lobes(const_in(PrincipledLayers) p, const_in(PrincipledView) o) {
    vec4 lobes = vec4(o.coat, (1.0f - o.coat) * average(coated_specular_albedo(p.base, o.base)),
                      (1.0f - o.coat) * average(coated_matte_albedo(p.base, o.base)),
                      (1.0f - o.coat) * average(p.wall) * o.base.through);
    float sum = lobes.x + lobes.y + lobes.z + lobes.w;
    return sum > 0.0f ? lobes / sum : vec4(0.0f, 1.0f, 0.0f, 0.0f);
}

FN vec4 principled_layered_eval_pdf_view(const_in(PrincipledLayers) p, vec3 wo, vec3 wi, const_in(PrincipledView) o,
                                         vec4 lobes) {
    Coated c = p.base;
    PrincipledView i = principled_view(p, abs(wi.z));
    float under = min(1.0f - o.coat, 1.0f - i.coat);
    float lambert = lambert_pdf(wi);
    float again = ggx_multiple(o.base.missing, i.base.missing, c.energy.x) * lambert;
    if (wi.z < 0.0f) {
        if (coated_is_smooth(c.roughness)) return vec4(0.0f);
        vec3 mirrored = vec3(wi.x, wi.y, -wi.z);
        vec3 m = normalize(wo + mirrored);
        vec2 once = ggx_reflection(ggx_alpha(c.roughness), wo, mirrored, m);
        float fresnel = mix(schlick_weight(dot(wo, m)), 1.0f, c.layer_f0);
        vec3 value = p.wall * (under * ((1.0f - fresnel) * once.x + (1.0f - c.energy.y) * again));
        return vec4(value, lobes.w * mix(once.y, lambert, o.base.missing));
    }
    float matte = o.base.through * i.base.through * (1.0f - o.coat) * (1.0f - i.coat) / max(p.coated_through, 1e-6f);
    vec3 value = c.base * (matte * lambert) + c.again * (under * again);
    float pdf = lobes.z * lambert;
    vec3 m = normalize(wo + wi);
    if (!coated_is_smooth(c.roughness)) {
        vec2 once = ggx_reflection(ggx_alpha(c.roughness), wo, wi, m);
        value += mix(vec3(schlick_weight(dot(wo, m))), vec3(1.0f), c.f0) * (under * once.x);
        pdf += lobes.y * once.y;
    }
    if (p.coat > 0.0f && !coated_is_smooth(p.coat_roughness)) {
        vec2 once = ggx_reflection(ggx_alpha(p.coat_roughness), wo, wi, m);
        value += vec3(p.coat * mix(schlick_weight(dot(wo, m)), 1.0f, COAT_F0) * once.x);
        pdf += lobes.x * once.y;
    }
    return vec4(value, pdf);
}

FN vec4 principled_layered_eval_pdf(const_in(PrincipledLayers) p, vec3 wo, vec3 wi) {
    if (wo.z <= 0.0f || wi.z == 0.0f) return vec4(0.0f);
    if (wi.z < 0.0f && is_black(p.wall)) return vec4(0.0f);
    PrincipledView o = principled_view(p, wo.z);
    return principled_layered_eval_pdf_view(p, wo, wi, o, principled_lobes(p, o));
}

FN BsdfSample principled_layered_sample(const_in(PrincipledLayers) p, vec3 wo, float u_lobe, vec2 u) {
    PrincipledView o = principled_view(p, wo.z);
    vec4 lobes = principled_lobes(p, o);
    vec3 mirror = vec3(-wo.x, -wo.y, wo.z);
    vec3 wi = vec3(0.0f);
    float roughness = -1.0f;  // of the microfacets that reflect
    bool wall = false;
    if (u_lobe < lobes.x) {
        if (coated_is_smooth(p.coat_roughness)) return BsdfSample(mirror, vec3(o.coat / lobes.x), lobes.x, LOBE_DELTA);
        roughness = p.coat_roughness;
    } else if (u_lobe < lobes.x + lobes.y) {
        if (coated_is_smooth(p.base.roughness))
            return BsdfSample(mirror, coated_specular_albedo(p.base, o.base) * ((1.0f - o.coat) / lobes.y), lobes.y,
                              LOBE_DELTA);
        roughness = p.base.roughness;
    } else if (u_lobe < lobes.x + lobes.y + lobes.z || lobes.w == 0.0f) {
        wi = square_to_cosine_hemisphere(u);
    } else {
        if (coated_is_smooth(p.base.roughness))
            return BsdfSample(-wo, p.wall * ((1.0f - o.coat) * o.base.through / lobes.w), lobes.w,
                              LOBE_DELTA | LOBE_TRANSMISSION);
        wall = true;
        if (u_lobe - (lobes.x + lobes.y + lobes.z) < lobes.w * o.base.missing) wi = square_to_cosine_hemisphere(u);
        else roughness = p.base.roughness;
    }
    if (roughness >= 0.0f) {
        vec3 m = ggx_sample(ggx_alpha(roughness), wo, u);
        wi = 2.0f * dot(wo, m) * m - wo;
        if (wi.z <= 0.0f) return bsdf_failed();
    }
    if (wall) wi.z = -wi.z;
    return bsdf_weighted(wi, principled_layered_eval_pdf_view(p, wo, wi, o, lobes));
}

FN vec3 principled_layered_albedo(const_in(PrincipledLayers) p, vec3 wo) {
    PrincipledView o = principled_view(p, wo.z);
    vec3 under = coated_specular_albedo(p.base, o.base) + coated_matte_albedo(p.base, o.base) + p.wall * o.base.through;
    return min(vec3(o.coat) + (1.0f - o.coat) * under, vec3(1.0f));
}

KERNELS_END
#endif
