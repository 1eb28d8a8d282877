#ifndef SPINEL_KERNELS_PATH_SETTINGS_H
#define SPINEL_KERNELS_PATH_SETTINGS_H
#include "portable.h"
KERNELS_BEGIN

// What the preview integrators are asked for (preview_shade.h).
struct PreviewSettings {
    float ao_radius;    // world units: how far a ray looks for what hides the sky
    float ao_strength;  // 0 … 1: of how much of the light ambient occlusion may take
    float glow;         // strength of the halo about voxels that emit; 0: none
    float glow_radius;  // world units; 0: four voxels of the set
};

// How the light that a shadow ray through a medium keeps is estimated (medium.h).
const uint TRANSMITTANCE_RATIO = 0u;     // product of the chances that collisions are none
const uint TRANSMITTANCE_RESIDUAL = 1u;  // the same about the least extinction of a cell, which counts in closed form
const uint TRANSMITTANCE_DELTA = 2u;     // all or nothing: the first real collision is a shadow

struct PathSettings {
    uint seed;
    int max_bounces;     // scattering events; −1: no limit
    float clamp;         // most that a path may add after its second scattering; 0: no limit
    int roulette_start;  // first bounce that Russian roulette may end
    PreviewSettings preview;
    uint transmittance;  // TRANSMITTANCE_…
};

KERNELS_END
#endif
