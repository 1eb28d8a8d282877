#ifndef SPINEL_KERNELS_SDF_GRID_H
#define SPINEL_KERNELS_SDF_GRID_H
// A volume as an implicit surface: where its look-up crosses a level. Points are in the grid's index space, lengths in
// samples.
//
// In SceneView::words stands the grid's index, and behind it a word for each coarse cell of its box: 0 near the
// surface, else a length that no point of the cell is nearer to it than, and in the highest bit whether that is inside.
// So values count near the surface alone: a narrow band is crossed in as few steps as distances known everywhere, and
// a density serves as well as a distance.
#include "grids.h"
KERNELS_BEGIN

const uint SDF_GRID_INSIDE = 0x80000000u;

// The samples' own box; beyond it values stay what they are at its faces. In this order what is not a number becomes a
// place in it, too.
FN vec3 sdf_grid_place(const_in(DensityGrid) grid, vec3 p) {
    return min(max(vec3(0.5f), p), vec3(grid.size) - vec3(0.5f));
}

// What the table says of a place: 0 near the surface, else a length that no point of the surface is nearer than,
// negative inside.
FN float sdf_grid_clearance(const_in(SceneView) scene, uint first, const_in(DensityGrid) grid, vec3 place) {
    ivec3 i = ivec3(place) / grid.majorant_cell;
    int cell = i.x + grid.majorant_size.x * (i.y + grid.majorant_size.y * i.z);
    uint away = scene.words.at[first + 1u + uint(cell)];
    float clearance = float(away & ~SDF_GRID_INSIDE);
    return (away & SDF_GRID_INSIDE) != 0u ? -clearance : clearance;
}

// data.y · (value − data.x) near the surface, but not more than the edge of a coarse cell: how steep values are is
// known near the surface alone, and a way to it that leads past what is near is at least so long.
FN float sdf_grid(const_in(SceneView) scene, uint first, vec3 p, vec2 data) {
    RECORD(DensityGrid) grid = scene.grids.at[scene.words.at[first]];
    vec3 q = sdf_grid_place(grid, p);
    float clearance = sdf_grid_clearance(scene, first, grid, q);
    if (clearance != 0.0f) return clearance;
    float edge = float(grid.majorant_cell);
    return clamp(data.y * (grid_value_within(scene, grid, q, 0u) - data.x), -edge, edge);
}

// (gradient of the look-up, look-up), by the samples of one cell.
FN vec4 trilinear_gradient(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p) {
    ivec3 i = sample_before(p);
    vec3 w = sample_weights(p, i);
    ivec3 n = min(i + ivec3(1), grid.size - ivec3(1));
    float v[8];
    for (uint k = 0u; k < 8u; ++k)
        v[k] = grid_sample(
            scene, grid, ivec3((k & 1u) != 0u ? n.x : i.x, (k & 2u) != 0u ? n.y : i.y, (k & 4u) != 0u ? n.z : i.z), 0u);
    vec4 low = vec4(v[0], v[1], v[2], v[3]);
    vec4 high = vec4(v[4], v[5], v[6], v[7]);
    vec4 c = mix(low, high, w.z);
    vec4 z = high - low;
    return vec4(mix(c.y - c.x, c.w - c.z, w.y), mix(c.z - c.x, c.w - c.y, w.x),
                mix(mix(z.x, z.y, w.x), mix(z.z, z.w, w.x), w.y), mix(mix(c.x, c.y, w.x), mix(c.z, c.w, w.x), w.y));
}

// What the four samples around a place count in a cubic B-spline, f behind the second, and in its derivative.
struct SplineWeights {
    vec4 value;
    vec4 slope;
};

FN SplineWeights spline_weights(float f) {
    float r = 1.0f - f;
    return SplineWeights(
        vec4(r * r * r, 4.0f - 3.0f * f * f * (2.0f - f), 4.0f - 3.0f * r * r * (2.0f - r), f * f * f) * (1.0f / 6.0f),
        0.5f * vec4(-r * r, f * (3.0f * f - 4.0f), r * (4.0f - 3.0f * r), f * f));
}

FN vec4 tricubic_gradient(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p) {
    vec3 base = floor(p - vec3(0.5f));
    vec3 f = p - vec3(0.5f) - base;
    SplineWeights x = spline_weights(f.x);
    SplineWeights y = spline_weights(f.y);
    SplineWeights z = spline_weights(f.z);
    ivec3 last = grid.size - ivec3(1);
    vec4 sum = vec4(0.0f);
    for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < 4; ++j) {
            ivec3 at = ivec3(base) + ivec3(-1, j - 1, k - 1);
            vec4 row;
            for (int i = 0; i < 4; ++i)
                row[i] = grid_sample(scene, grid, clamp(at + ivec3(i, 0, 0), ivec3(0), last), 0u);
            float value = dot(x.value, row);
            sum += vec4(y.value[j] * z.value[k] * dot(x.slope, row), y.slope[j] * z.value[k] * value,
                        y.value[j] * z.slope[k] * value, y.value[j] * z.value[k] * value);
        }
    }
    return sum;
}

// (gradient of sdf_grid(), itself). Values count near the surface alone here too: on a face that cuts off a solid, the
// grid must not seem nearer to its surface than the face.
FN vec4 sdf_grid_gradient(const_in(SceneView) scene, uint first, vec3 p, vec2 data) {
    RECORD(DensityGrid) grid = scene.grids.at[scene.words.at[first]];
    vec3 q = sdf_grid_place(grid, p);
    float clearance = sdf_grid_clearance(scene, first, grid, q);
    if (clearance != 0.0f) return vec4(0.0f, 0.0f, 0.0f, clearance);
    vec4 g =
        grid.filter_kind == FILTER_TRICUBIC ? tricubic_gradient(scene, grid, q) : trilinear_gradient(scene, grid, q);
    return data.y * (g - vec4(0.0f, 0.0f, 0.0f, data.x));
}

KERNELS_END
#endif
