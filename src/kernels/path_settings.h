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

// What `single-scatter` is asked for (single_scatter.h). World units.
struct MarchSettings {
    float step;                  // of the camera's march
    float shadow_step;           // from within media towards lights …
    float shadow_reach;          // … as far as this
    float surface_shadow_step;   // from surfaces towards lights …
    float surface_shadow_reach;  // … as far as this
    float light_reach;           // points give nothing beyond; 0: inverse square alone
    uint naive;                  // 1: the integration that does not conserve energy
    uint jitter;                 // 1: marches begin at a random part of a step
    uint shortcuts;              // 1: a device may take its own
};

// What `dvr` shows and how (dvr.h). World units, if not told otherwise.
struct DvrSettings {
    uint medium;  // whose grid is shown; NONE: none
    uint mode;    // DVR_…
    // The transfer function: entry (value − low)·scale of two tables in SceneView::floats (transfer.h).
    uint table_first;
    uint table_size;
    float low;
    float scale;
    float step;
    float voxel;  // the shortest edge of a voxel
    float iso;
    vec3 iso_color;
    uint shaded;
    uint headlight;  // 1: light comes from the camera, else from to_light
    vec3 to_light;
    float ambient;
    float diffuse;
    float specular;
    float shininess;
    float shadow;
    float shadow_reach;
    vec3 clip_lower;  // index space
    vec3 clip_upper;
    uint plane_count;
    vec4 planes[4];
    vec3 background;
    uint jitter;
    uint shortcuts;
};
// How the light that a shadow ray through a medium keeps is estimated (medium.h).
const uint TRANSMITTANCE_RATIO = 0u;     // product of the chances that collisions are none
const uint TRANSMITTANCE_RESIDUAL = 1u;  // the same about the least extinction of a cell, which counts in closed form
const uint TRANSMITTANCE_DELTA = 2u;     // all or nothing: the first real collision is a shadow

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
    MarchSettings march;
    DvrSettings dvr;
    uint transmittance;  // TRANSMITTANCE_…
    GaugeSettings gauge;
    uint equiangular;  // 1: media look for the light of points where it is strong, too (equiangular.h)
};

KERNELS_END
#endif
