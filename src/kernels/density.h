#ifndef SPINEL_KERNELS_DENSITY_H
#define SPINEL_KERNELS_DENSITY_H
// Density of a heterogeneous medium: a regular grid, optionally eaten by noise as in the volumetric Stanford bunny.
#include "noise.h"
#include "scene_view.h"
KERNELS_BEGIN

const uint EROSION_NONE = 0u;
const uint EROSION_VALUE = 1u;  // max(0, ½ + ½·strength·N(frequency·p)), N value noise in [−1, 1]
const uint EROSION_FBM = 2u;    // max(0, 5·strength·F(frequency·p) − 2), F fractal noise mapped to [0, 1]

FN float grid_sample(const_in(SceneView) scene, const_in(DensityGrid) grid, ivec3 i) {
    if (i.x < 0 || i.y < 0 || i.z < 0 || i.x >= grid.size.x || i.y >= grid.size.y || i.z >= grid.size.z) return 0.0f;
    return scene.floats
        .at[grid.value_first + uint(i.x) + uint(grid.size.x) * (uint(i.y) + uint(grid.size.y) * uint(i.z))];
}

// p in index space: sample i sits at i + ½, outside there is nothing.
FN float grid_density(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p) {
    if (p.x < 0.0f || p.y < 0.0f || p.z < 0.0f || p.x >= float(grid.size.x) || p.y >= float(grid.size.y) ||
        p.z >= float(grid.size.z))
        return 0.0f;
    if (grid.filter_kind == FILTER_NEAREST) return grid_sample(scene, grid, ivec3(floor(p)));
    // Clamped at the faces of the box, so that a full grid is a full box.
    vec3 q = p - 0.5f;
    vec3 base = floor(q);
    vec3 f = q - base;
    ivec3 last = grid.size - ivec3(1);
    ivec3 lo = clamp(ivec3(base), ivec3(0), last);
    ivec3 hi = clamp(ivec3(base) + ivec3(1), ivec3(0), last);
    uint row = uint(grid.size.x);
    uint layer = row * uint(grid.size.y);
    uint y0 = grid.value_first + row * uint(lo.y);
    uint y1 = grid.value_first + row * uint(hi.y);
    uint z0 = layer * uint(lo.z);
    uint z1 = layer * uint(hi.z);
    uint x0 = uint(lo.x);
    uint x1 = uint(hi.x);
    float c00 = mix(scene.floats.at[x0 + y0 + z0], scene.floats.at[x1 + y0 + z0], f.x);
    float c10 = mix(scene.floats.at[x0 + y1 + z0], scene.floats.at[x1 + y1 + z0], f.x);
    float c01 = mix(scene.floats.at[x0 + y0 + z1], scene.floats.at[x1 + y0 + z1], f.x);
    float c11 = mix(scene.floats.at[x0 + y1 + z1], scene.floats.at[x1 + y1 + z1], f.x);
    return mix(mix(c00, c10, f.y), mix(c01, c11, f.y), f.z);
}

// The factor that erosion leaves, in [0, erosion_bound]; p in the grid's [0,1]³ box.
FN float erosion_factor(const_in(Medium) m, vec3 p) {
    if (m.erosion == EROSION_VALUE)
        return max(0.0f, 0.5f + 0.5f * m.erosion_strength * value_noise(p * m.erosion_frequency + m.erosion_drift));
    if (m.erosion == EROSION_FBM) {
        float f = 0.5f + 0.5f * fbm_noise(p * m.erosion_frequency + m.erosion_drift, m.erosion_octaves);
        return max(0.0f, 5.0f * m.erosion_strength * f - 2.0f);
    }
    return 1.0f;
}

// Sound: value_noise and fbm_noise lie in [−1, 1].
FN float erosion_bound(uint kind, float strength) {
    if (kind == EROSION_VALUE) return 0.5f + 0.5f * abs(strength);
    if (kind == EROSION_FBM) return max(0.0f, 5.0f * strength - 2.0f);
    return 1.0f;
}

// The smallest densities of the coarse cells stand behind the greatest.
FN uint minorant_first(const_in(DensityGrid) grid) {
    return grid.majorant_first + uint(grid.majorant_size.x) * uint(grid.majorant_size.y) * uint(grid.majorant_size.z);
}

// Density at a position in the grid's space, ≥ 0.
FN float medium_density_in_grid(const_in(SceneView) scene, const_in(Medium) m, const_in(DensityGrid) grid, vec3 index) {
    float d = grid_density(scene, grid, index);
    if (d > 0.0f && m.erosion != EROSION_NONE) d *= erosion_factor(m, index / vec3(grid.size));
    return d;
}

// Density at a world position, ≥ 0.
FN float medium_density(const_in(SceneView) scene, const_in(Medium) m, vec3 p) {
    if (m.grid == NONE) return 1.0f;
    RECORD(DensityGrid) grid = scene.grids.at[m.grid];
    vec3 index = m.world_to_grid * vec4(p, 1.0f);
    float d = grid_density(scene, grid, index);
    if (d > 0.0f && m.erosion != EROSION_NONE) d *= erosion_factor(m, index / vec3(grid.size));
    return d;
}

KERNELS_END
#endif
