#ifndef SPINEL_KERNELS_SPECTRAL_WEIGHTS_H
#define SPINEL_KERNELS_SPECTRAL_WEIGHTS_H
// What a path carries, and what a segment through media comes to: shared by the walks of medium.h and grey_medium.h.
#include "constants.h"
KERNELS_BEGIN

struct SpectralWeights {
    vec3 throughput;
    vec3 r_path;
    vec3 r_light;
    uint hero;  // 0, 1, 2
};

const uint MAX_MEDIUM_STEPS = 1u << 20u;  // of one segment: majorant cells and collisions

const float MOST_CONTROLLED = 60.0f;  // optical depth behind which a path's own chances count as nothing: e⁻⁶⁰
const float SHADOW_ROULETTE = 0.5f;   // part of a shadow ray's light below which it is left to luck

struct MediumEvent {
    bool scattered;  // a real collision before t_max
    float t;
    uint medium;   // whose phase function applies
    vec3 emitted;  // radiance gathered on the way, weighted
    bool bound_reached;
};

KERNELS_END
#endif
