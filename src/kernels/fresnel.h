#ifndef SPINEL_KERNELS_FRESNEL_H
#define SPINEL_KERNELS_FRESNEL_H
// How much of the light that meets an interface is reflected; unpolarised.
#include "constants.h"
KERNELS_BEGIN

// Cosine of the transmitted ray, 0 for total internal reflection. relative_ior = n_transmitted / n_incident.
FN float refracted_cosine(float cos_incident, float relative_ior) {
    return safe_sqrt(1.0f - (1.0f - sqr(cos_incident)) / sqr(relative_ior));
}

// Dielectric interface, exact.
FN float fresnel_dielectric(float cos_incident, float relative_ior) {
    float cos_transmitted = refracted_cosine(cos_incident, relative_ior);
    if (cos_transmitted == 0.0f) return 1.0f;
    float parallel = (relative_ior * cos_incident - cos_transmitted) / (relative_ior * cos_incident + cos_transmitted);
    float perpendicular =
        (cos_incident - relative_ior * cos_transmitted) / (cos_incident + relative_ior * cos_transmitted);
    return clamp(0.5f * (sqr(parallel) + sqr(perpendicular)), 0.0f, 1.0f);
}

// At normal incidence.
FN float fresnel_f0(float relative_ior) { return sqr((relative_ior - 1.0f) / (relative_ior + 1.0f)); }

// Cosine-weighted mean over the hemisphere, ∫ F 2µ dµ, for n ≥ 1. A fit, good to 0.006 up to n = 3:
// Kulla, Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017 course.
FN float fresnel_dielectric_average(float n) { return (n - 1.0f) / (4.08567f + 1.00071f * n); }

// A conductor in air, complex index η + iκ per channel, exact (Born, Wolf, "Principles of Optics", §14.2).
FN vec3 fresnel_conductor(float cos_incident, vec3 eta, vec3 k) {
    float c = clamp(cos_incident, 0.0f, 1.0f);
    float c2 = c * c;
    float s2 = 1.0f - c2;
    vec3 t0 = eta * eta - k * k - vec3(s2);
    vec3 a2b2 = sqrt(t0 * t0 + 4.0f * eta * eta * k * k);
    vec3 a = sqrt(max(0.5f * (a2b2 + t0), vec3(0.0f)));
    vec3 perpendicular = (a2b2 + vec3(c2) - 2.0f * c * a) / (a2b2 + vec3(c2) + 2.0f * c * a);
    vec3 t3 = c2 * a2b2 + vec3(s2 * s2);
    vec3 t4 = (2.0f * c * s2) * a;
    return clamp(0.5f * perpendicular * (vec3(1.0f) + (t3 - t4) / max(t3 + t4, vec3(1e-20f))), vec3(0.0f), vec3(1.0f));
}

// Schlick's (1 − µ)⁵, "An Inexpensive BRDF Model for Physically-based Rendering", 1994.
FN float schlick_weight(float cosine) {
    float m = clamp(1.0f - cosine, 0.0f, 1.0f);
    float m2 = m * m;
    return m2 * m2 * m;
}

// Metals by colour: Schlick's curve from F0, minus a dip that makes the reflectance at 82° (µ = 1/7) `edge`
// times Schlick's. edge = 1 is Schlick. Kutz, Hašan, Edmondson, "Novel Aspects of the Adobe Standard
// Material", 2021.
FN vec3 fresnel_f82_dip(vec3 f0, vec3 edge) {
    float m = 6.0f / 7.0f;
    float m5 = m * m * m * m * m;
    vec3 schlick = f0 + (vec3(1.0f) - f0) * m5;
    return schlick * (vec3(1.0f) - edge) * (7.0f / (m5 * m));
}
FN vec3 fresnel_f82(float cosine, vec3 f0, vec3 dip) {
    float w = schlick_weight(cosine);
    float m = clamp(1.0f - cosine, 0.0f, 1.0f);
    return clamp(f0 + (vec3(1.0f) - f0) * w - dip * (cosine * w * m), vec3(0.0f), vec3(1.0f));
}
// Cosine-weighted mean over the hemisphere (but for the clamp).
FN vec3 fresnel_f82_average(vec3 f0, vec3 dip) {
    return clamp(f0 + (vec3(1.0f) - f0) * (1.0f / 21.0f) - dip * (1.0f / 126.0f), vec3(0.0f), vec3(1.0f));
}

KERNELS_END
#endif
