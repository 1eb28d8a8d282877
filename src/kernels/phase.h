#ifndef SPINEL_KERNELS_PHASE_H
#define SPINEL_KERNELS_PHASE_H
// Henyey–Greenstein phase function. Henyey, Greenstein, "Diffuse radiation in the Galaxy", 1941.
// cosine is between the directions of travel before and after the scattering: g > 0 scatters forward.
// The value is a density over directions [1/sr], so one function is both eval and pdf.
#include "frame.h"
KERNELS_BEGIN

const float PHASE_G_MAX = 0.9999f;  // |g| is clamped to this: 1 is a delta

FN float phase_eval(float g, float cosine) {
    g = clamp(g, -PHASE_G_MAX, PHASE_G_MAX);
    // 1 + g² − 2gµ as (1 − |g|)² + 2|g|(1 ∓ µ): a sum of positive terms, so nothing cancels at the peak.
    float a = abs(g);
    float off_peak = max(g < 0.0f ? 1.0f + cosine : 1.0f - cosine, 0.0f);
    float d = sqr(1.0f - a) + 2.0f * a * off_peak;
    return (0.25f * INV_PI) * (1.0f - a) * (1.0f + a) / (d * sqrt(d));
}
FN float phase_pdf(float g, float cosine) { return phase_eval(g, cosine); }

struct PhaseSample {
    vec3 direction;
    float pdf;  // [1/sr]; the weight eval/pdf is 1
};

// `forward` is the direction of travel, unit.
FN PhaseSample phase_sample(float g, vec3 forward, vec2 u) {
    g = clamp(g, -PHASE_G_MAX, PHASE_G_MAX);
    float a = abs(g);
    // The inverse of the cumulative distribution, as t = 1 − µ measured from the peak, rearranged until
    // nothing divides by g (isotropic is no special case) and nothing cancels at the peak.
    float s = u.x;  // 0: the peak
    float q = 1.0f - a + 2.0f * a * (1.0f - s);
    // µ = (1 + a² − ((1 − a²)/q)²) / 2a  ⇒  1 − µ = ((1 − a²)² − (1 − a)² q²) / (2a q²)
    //   = (1 − a)² ((1 + a)² − q²) / (2a q²), and (1 + a) − q = 2 a s, (1 + a) + q = 2 + 2a(1 − s).
    float t = sqr(1.0f - a) * s * (2.0f + 2.0f * a * (1.0f - s)) / (q * q);
    t = clamp(t, 0.0f, 2.0f);
    float cosine = g < 0.0f ? t - 1.0f : 1.0f - t;
    float sine = safe_sqrt(t * (2.0f - t));
    float phi = 2.0f * PI * u.y;
    Frame frame = make_frame(forward);
    vec3 direction = to_world(frame, vec3(sine * cos(phi), sine * sin(phi), cosine));
    return PhaseSample(direction, phase_eval(g, cosine));
}

KERNELS_END
#endif
