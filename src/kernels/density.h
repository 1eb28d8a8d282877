#ifndef SPINEL_KERNELS_DENSITY_H
#define SPINEL_KERNELS_DENSITY_H
// What a heterogeneous medium is at a point: its density, by a grid that noise may eat as in the volumetric Stanford
// bunny; the colour that it scatters; what it glows.
#include "grids.h"
#include "noise.h"
KERNELS_BEGIN

// The factor that erosion leaves, at least 0; p in the grid's [0,1]³ box.
FN float erosion_factor(const_in(Medium) m, vec3 p) {
    if (m.noise == NOISE_NONE) return 1.0f;
    float n = fractal_noise(m.noise, p * m.noise_frequency + m.noise_drift, m.noise_octaves, m.noise_gain,
                            m.noise_lacunarity);
    return max(0.0f, m.noise_offset + m.noise_scale * n);
}

// Density that a value of the medium's grid means, before erosion; rises with the value, so it carries bounds over.
FN float scaled_density(const_in(Medium) m, float value) {
    return max(0.0f, m.density_scale * value + m.density_offset);
}

// Density at a position in the grid's space, ≥ 0; 0 outside of the grid.
FN float medium_density_in_grid(const_in(SceneView) scene, const_in(Medium) m, const_in(DensityGrid) grid, vec3 index) {
    if (!grid_contains(grid, index)) return 0.0f;
    float d = scaled_density(m, grid_value_within(scene, grid, index, 0u));
    if (d > 0.0f && m.noise != NOISE_NONE) d *= erosion_factor(m, index / vec3(grid.size));
    return d;
}

// Density at a world position, ≥ 0; 0 outside of the grid.
FN float medium_density(const_in(SceneView) scene, const_in(Medium) m, vec3 p) {
    if (m.grid == NONE) return 1.0f;
    RECORD(DensityGrid) grid = scene.grids.at[m.grid];
    vec3 index = m.world_to_grid * vec4(p, 1.0f);
    return medium_density_in_grid(scene, m, grid, index);
}

// σs at density 1: the part of σs that the colour at p leaves; the rest absorbs, so the extinction is that of the
// medium.
FN vec3 medium_scattering(const_in(SceneView) scene, const_in(Medium) m, vec3 p) {
    if (m.albedo_grid == NONE) return m.scattering;
    vec3 color = grid_vector(scene, scene.grids.at[m.albedo_grid], m.world_to_albedo * vec4(p, 1.0f));
    return m.scattering * clamp(color, vec3(0.0f), vec3(1.0f));
}

// Emission at density 1.
FN vec3 medium_emission(const_in(SceneView) scene, const_in(Medium) m, vec3 p) {
    if (m.temperature_grid == NONE) return m.emission;
    float value = grid_density(scene, scene.grids.at[m.temperature_grid], m.world_to_temperature * vec4(p, 1.0f));
    float entry = clamp(m.temperature_scale * value + m.temperature_offset, 0.0f, float(TEMPERATURE_ENTRIES - 1u));
    uint i = min(uint(entry), TEMPERATURE_ENTRIES - 2u);
    float f = entry - float(i);
    uint first = m.temperature_first + 3u * i;
    vec3 a = vec3(scene.floats.at[first], scene.floats.at[first + 1u], scene.floats.at[first + 2u]);
    vec3 b = vec3(scene.floats.at[first + 3u], scene.floats.at[first + 4u], scene.floats.at[first + 5u]);
    return m.emission * mix(a, b, f);
}

KERNELS_END
#endif
