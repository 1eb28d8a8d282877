#ifndef SPINEL_KERNELS_MICROFACET_H
#define SPINEL_KERNELS_MICROFACET_H
// The GGX (Trowbridge–Reitz) distribution of microfacet normals and its Smith masking, isotropic.
//   Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007;
//   Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014.
// Local frame, z the normal of the macrosurface; α = roughness². Normals are sampled as seen from wo, by
// spherical caps:
//   Dupuy, Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG 2023.
#include "warp.h"
KERNELS_BEGIN

const float GGX_ALPHA_DELTA =
    1e-3f;  // below, a surface is a perfect mirror: the lobe is narrower than float directions resolve well

FN float ggx_alpha(float roughness) { return sqr(clamp(roughness, 0.0f, 1.0f)); }

// Density of normals per solid angle; ∫ D (m·z) dm = 1.
FN float ggx_d(float alpha, vec3 m) {
    if (m.z <= 0.0f) return 0.0f;
    // x² + y² + α²z² rather than 1 + (α² − 1)z²: no cancellation for a smooth surface.
    float t = m.x * m.x + m.y * m.y + sqr(alpha * m.z);
    return sqr(alpha) / max(PI * t * t, 1e-30f);
}

// Smith's Λ.
FN float ggx_lambda(float alpha, vec3 w) {
    float tan2 = (w.x * w.x + w.y * w.y) / max(w.z * w.z, 1e-20f);
    return 0.5f * (sqrt(1.0f + sqr(alpha) * tan2) - 1.0f);
}
FN float ggx_g1(float alpha, vec3 w) { return 1.0f / (1.0f + ggx_lambda(alpha, w)); }
// Masking and shadowing, correlated by height.
FN float ggx_g2(float alpha, vec3 wo, vec3 wi) { return 1.0f / (1.0f + ggx_lambda(alpha, wo) + ggx_lambda(alpha, wi)); }

// A normal as seen from wo (wo.z > 0).
FN vec3 ggx_sample(float alpha, vec3 wo, vec2 u) {
    vec3 stretched = normalize(vec3(alpha * wo.x, alpha * wo.y, wo.z));
    // A cap of the sphere, uniform, seen along −wo: half vectors with wo are what a sphere shows.
    float phi = 2.0f * PI * u.x;
    float z = 1.0f - u.y * (1.0f + stretched.z);
    float r = safe_sqrt(1.0f - z * z);
    vec3 h = vec3(r * cos(phi), r * sin(phi), z) + stretched;
    vec3 m = vec3(alpha * h.x, alpha * h.y, max(h.z, 1e-9f));
    return normalize(m);
}
// Density over normals [1/sr] of ggx_sample: G1(wo) (wo·m) D(m) / wo.z.
FN float ggx_sample_pdf(float alpha, vec3 wo, vec3 m) {
    // G1/wo.z = 2 / (wo.z + sqrt(wo.z² + α²(x² + y²))): finite at grazing incidence.
    float g1_by_cos = 2.0f / (wo.z + sqrt(wo.z * wo.z + sqr(alpha) * (wo.x * wo.x + wo.y * wo.y)));
    return g1_by_cos * max(dot(wo, m), 0.0f) * ggx_d(alpha, m);
}

// A single reflection by a perfectly reflecting surface, f·cos θi in x; the density of wi that ggx_sample
// gives, in y.
FN vec2 ggx_reflection(float alpha, vec3 wo, vec3 wi, vec3 m) {
    float om = dot(wo, m);
    if (om <= 0.0f) return vec2(0.0f);
    float pdf = ggx_sample_pdf(alpha, wo, m) / (4.0f * om);  // dm/dwi = 1 / (4 wo·m)
    float lambda = ggx_lambda(alpha, wo);
    return vec2(pdf * (1.0f + lambda) / (1.0f + lambda + ggx_lambda(alpha, wi)), pdf);
}

KERNELS_END
#endif
