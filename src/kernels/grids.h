#ifndef SPINEL_KERNELS_GRIDS_H
#define SPINEL_KERNELS_GRIDS_H
// Look-ups in the samples of a volume. They stand in bricks of 8³, found by a table with an entry for each brick of the
// box: one read where a tree takes three or four. Bricks carry no copy of their neighbours' samples: that would cost 42
// % of memory, and two look-ups in three stay within one brick anyway.
#include "scene_view.h"
KERNELS_BEGIN

FN bool grid_contains(const_in(DensityGrid) grid, vec3 p) {
    return p.x >= 0.0f && p.y >= 0.0f && p.z >= 0.0f && p.x < float(grid.size.x) && p.y < float(grid.size.y) &&
           p.z < float(grid.size.z);
}

// Sample `i`, 0 … 511, of the brick whose channel begins at word `first`.
FN float brick_sample(const_in(SceneView) scene, uint storage, uint first, uint i) {
    if (storage == GRID_FLOAT) return bits_float(scene.words.at[first + i]);
    if (storage == GRID_HALF) return half_float((scene.words.at[first + (i >> 1u)] >> (16u * (i & 1u))) & 0xffffu);
    float code = storage == GRID_BITS16 ? float((scene.words.at[first + 2u + (i >> 1u)] >> (16u * (i & 1u))) & 0xffffu)
                                        : float((scene.words.at[first + 2u + (i >> 2u)] >> (8u * (i & 3u))) & 0xffu);
    return bits_float(scene.words.at[first]) + bits_float(scene.words.at[first + 1u]) * code;
}

FN uint brick_entry(const_in(DensityGrid) grid, ivec3 i) {
    return uint(i.x >> 3) + uint(grid.brick_counts.x) * (uint(i.y >> 3) + uint(grid.brick_counts.y) * uint(i.z >> 3));
}

FN uint brick_offset(ivec3 i) { return uint(i.x & 7) + 8u * uint(i.y & 7) + 64u * uint(i.z & 7); }

// A sample of the box.
FN float grid_sample(const_in(SceneView) scene, const_in(DensityGrid) grid, ivec3 i, uint channel) {
    uint first = scene.words.at[grid.table_first + brick_entry(grid, i)] + channel * grid.channel_words;
    return brick_sample(scene, grid.storage, first, brick_offset(i));
}

// Where the eight samples around a place stand: in the brick of the first one's entry in the table, and how to get to
// the next one along each axis. Unsigned steps may lead back: they wrap around.
struct GridCorners {
    uint entry;  // into SceneView::words
    uvec3 next;  // entries to the next brick, 0 where the second sample stands in the same one
    uint at;     // the first sample's number in its brick
    uvec3 step;  // to the second one's
    vec3 weight;
};

// Clamped at the faces of the box, so that a full grid is a full box. p lies in the box.
FN GridCorners grid_corners(const_in(DensityGrid) grid, vec3 p) {
    // Truncation of what is positive is its floor, and far cheaper.
    int bx = int(p.x + 0.5f) - 1;
    int by = int(p.y + 0.5f) - 1;
    int bz = int(p.z + 0.5f) - 1;
    int x0 = max(bx, 0);
    int y0 = max(by, 0);
    int z0 = max(bz, 0);
    int x1 = min(bx + 1, grid.size.x - 1);
    int y1 = min(by + 1, grid.size.y - 1);
    int z1 = min(bz + 1, grid.size.z - 1);
    uint row = uint(grid.brick_counts.x);
    uint layer = row * uint(grid.brick_counts.y);
    GridCorners c;
    c.entry = grid.table_first + uint(x0 >> 3) + row * uint(y0 >> 3) + layer * uint(z0 >> 3);
    c.next = uvec3((x0 ^ x1) < 8 ? 0u : 1u, (y0 ^ y1) < 8 ? 0u : row, (z0 ^ z1) < 8 ? 0u : layer);
    c.at = uint(x0 & 7) + 8u * uint(y0 & 7) + 64u * uint(z0 & 7);
    c.step =
        uvec3(uint(x1 & 7) - uint(x0 & 7), 8u * (uint(y1 & 7) - uint(y0 & 7)), 64u * (uint(z1 & 7) - uint(z0 & 7)));
    c.weight = vec3((p.x - 0.5f) - float(bx), (p.y - 0.5f) - float(by), (p.z - 0.5f) - float(bz));
    return c;
}

FN float trilinear_mix(float v000, float v100, float v010, float v110, float v001, float v101, float v011, float v111,
                       vec3 w) {
    float c00 = v000 + w.x * (v100 - v000);
    float c10 = v010 + w.x * (v110 - v010);
    float c01 = v001 + w.x * (v101 - v001);
    float c11 = v011 + w.x * (v111 - v011);
    float c0 = c00 + w.y * (c10 - c00);
    float c1 = c01 + w.y * (c11 - c01);
    return c0 + w.z * (c1 - c0);
}

// Floats, the common case, in the fewest steps: measured, twice as fast as by way of brick_sample().
FN float trilinear_floats(const_in(SceneView) scene, const_in(GridCorners) c, uint shift) {
    uint first = c.at + shift;
    uint b000 = scene.words.at[c.entry] + first;
    if ((c.next.x | c.next.y | c.next.z) == 0u) {
        uint b001 = b000 + c.step.z;
        return trilinear_mix(bits_float(scene.words.at[b000]), bits_float(scene.words.at[b000 + c.step.x]),
                             bits_float(scene.words.at[b000 + c.step.y]),
                             bits_float(scene.words.at[b000 + c.step.x + c.step.y]), bits_float(scene.words.at[b001]),
                             bits_float(scene.words.at[b001 + c.step.x]), bits_float(scene.words.at[b001 + c.step.y]),
                             bits_float(scene.words.at[b001 + c.step.x + c.step.y]), c.weight);
    }
    uint ez = c.entry + c.next.z;
    uint b100 = scene.words.at[c.entry + c.next.x] + first + c.step.x;
    uint b010 = scene.words.at[c.entry + c.next.y] + first + c.step.y;
    uint b110 = scene.words.at[c.entry + c.next.x + c.next.y] + first + c.step.x + c.step.y;
    uint b001 = scene.words.at[ez] + first + c.step.z;
    uint b101 = scene.words.at[ez + c.next.x] + first + c.step.x + c.step.z;
    uint b011 = scene.words.at[ez + c.next.y] + first + c.step.y + c.step.z;
    uint b111 = scene.words.at[ez + c.next.x + c.next.y] + first + c.step.x + c.step.y + c.step.z;
    return trilinear_mix(bits_float(scene.words.at[b000]), bits_float(scene.words.at[b100]),
                         bits_float(scene.words.at[b010]), bits_float(scene.words.at[b110]),
                         bits_float(scene.words.at[b001]), bits_float(scene.words.at[b101]),
                         bits_float(scene.words.at[b011]), bits_float(scene.words.at[b111]), c.weight);
}

FN float grid_trilinear(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p, uint channel) {
    GridCorners c = grid_corners(grid, p);
    uint shift = channel * grid.channel_words;
    if (grid.storage == GRID_FLOAT) return trilinear_floats(scene, c, shift);
    float v[8];
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 far = uvec3(i & 1u, (i >> 1u) & 1u, i >> 2u);
        uvec3 next = far * c.next;
        uvec3 step = far * c.step;
        uint first = scene.words.at[c.entry + next.x + next.y + next.z] + shift;
        v[i] = brick_sample(scene, grid.storage, first, c.at + step.x + step.y + step.z);
    }
    return trilinear_mix(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], c.weight);
}

// Cubic B-spline over 4³ samples: twice continuously differentiable, a convex combination of what is around, so bounds
// of the samples are bounds of it. It smooths: at a sample it gives that sample's neighbourhood, not the sample.
FN float grid_tricubic(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p, uint channel) {
    vec3 q = p - 0.5f;
    vec3 base = floor(q);
    vec3 f = q - base;
    vec3 r = vec3(1.0f) - f;
    vec3 w0 = r * r * r * (1.0f / 6.0f);
    vec3 w3 = f * f * f * (1.0f / 6.0f);
    vec3 w1 = vec3(2.0f / 3.0f) - f * f * (vec3(1.0f) - 0.5f * f);
    vec3 w2 = vec3(2.0f / 3.0f) - r * r * (vec3(1.0f) - 0.5f * r);
    ivec3 last = grid.size - ivec3(1);
    float sum = 0.0f;
    for (int k = 0; k < 4; ++k) {
        float wz = k == 0 ? w0.z : (k == 1 ? w1.z : (k == 2 ? w2.z : w3.z));
        for (int j = 0; j < 4; ++j) {
            float wy = j == 0 ? w0.y : (j == 1 ? w1.y : (j == 2 ? w2.y : w3.y));
            ivec3 at = ivec3(base) + ivec3(-1, j - 1, k - 1);
            float a = grid_sample(scene, grid, clamp(at, ivec3(0), last), channel);
            float b = grid_sample(scene, grid, clamp(at + ivec3(1, 0, 0), ivec3(0), last), channel);
            float c = grid_sample(scene, grid, clamp(at + ivec3(2, 0, 0), ivec3(0), last), channel);
            float d = grid_sample(scene, grid, clamp(at + ivec3(3, 0, 0), ivec3(0), last), channel);
            sum += wz * wy * (w0.x * a + w1.x * b + w2.x * c + w3.x * d);
        }
    }
    return sum;
}

// A value at p in index space, where sample i sits at i + ½; outside it is the background.
FN float grid_value(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p, uint channel) {
    if (!grid_contains(grid, p)) return grid.background;
    if (grid.filter_kind == FILTER_TRILINEAR) return grid_trilinear(scene, grid, p, channel);
    if (grid.filter_kind == FILTER_NEAREST) return grid_sample(scene, grid, ivec3(p), channel);
    return grid_tricubic(scene, grid, p, channel);
}

// The only channel, in the data's own units.
FN float grid_density(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p) {
    return grid_value(scene, grid, p, 0u);
}

// All three.
FN vec3 grid_vector(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p) {
    float x = grid_value(scene, grid, p, 0u);
    float y = grid_value(scene, grid, p, 1u);
    float z = grid_value(scene, grid, p, 2u);
    return vec3(x, y, z);
}

KERNELS_END
#endif
