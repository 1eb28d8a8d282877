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

// What `heatmap` and `depth` are asked for.
struct GaugeSettings {
    int counter;      // HEATMAP_… (heatmap.h)
    float most;       // the count that has the hottest colour
    float depth_end;  // world units: the distance that is black
};

struct PathSettings {
    uint seed;
    int max_bounces;     // scattering events; −1: no limit
    float clamp;         // most that a path may add after its second scattering; 0: no limit
    int roulette_start;  // first bounce that Russian roulette may end
    PreviewSettings preview;
    GaugeSettings gauge;
};

KERNELS_END
#endif
