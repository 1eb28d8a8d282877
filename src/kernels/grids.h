#ifndef SPINEL_KERNELS_GRIDS_H
#define SPINEL_KERNELS_GRIDS_H
// Look-ups in the samples of a volume. They stand in bricks of 8³, found by a table with an entry for each brick of the
// box: one read where a tree takes three or four. Bricks carry no copy of their neighbours' samples: that would cost 42
// % of memory, and two look-ups in three stay within one brick anyway.
#include "scene_view.h"
KERNELS_BEGIN

FN bool grid_contains(const_in(DensityGrid) grid, vec3 p) {
    // Comparisons alone say no to what is not a number; all are made, since that is cheaper than to branch.
    uint lower = uint(p.x >= 0.0f) & uint(p.y >= 0.0f) & uint(p.z >= 0.0f);
    uint upper = uint(p.x < float(grid.size.x)) & uint(p.y < float(grid.size.y)) & uint(p.z < float(grid.size.z));
    return (lower & upper) != 0u;
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

// Along z first: what is next to each other in memory stays together, for compilers that make vectors of it.
FN float trilinear_mix(float v000, float v100, float v010, float v110, float v001, float v101, float v011, float v111,
                       vec3 w) {
    vec4 low = vec4(v000, v100, v010, v110);
    vec4 high = vec4(v001, v101, v011, v111);
    vec4 c = low + w.z * (high - low);
    vec2 near = vec2(c.x, c.y);
    vec2 far = vec2(c.z, c.w);
    vec2 d = near + w.y * (far - near);
    return d.x + w.x * (d.y - d.x);
}

// The sample before a place in the box on each axis, clamped at its lower faces, so that a full grid is a full box.
FN ivec3 sample_before(vec3 p) {
    // Truncation of what is not negative is its floor, and far cheaper.
    return ivec3(int(max(p.x - 0.5f, 0.0f)), int(max(p.y - 0.5f, 0.0f)), int(max(p.z - 0.5f, 0.0f)));
}
FN vec3 sample_weights(vec3 p, ivec3 i) {
    return vec3(max(p.x - 0.5f, 0.0f) - float(i.x), max(p.y - 0.5f, 0.0f) - float(i.y),
                max(p.z - 0.5f, 0.0f) - float(i.z));
}

// From the brick of the sample i to that of i + 1 on each axis, in entries of the table; and from its place in its
// brick to the other's. Behind the upper faces is the last sample again. Unsigned steps may lead back: they wrap
// around.
struct NextSample {
    uvec3 entries;
    uvec3 step;
};

FN NextSample next_sample(const_in(DensityGrid) grid, ivec3 i) {
    uint row = uint(grid.brick_counts.x);
    ivec3 n = min(i + ivec3(1), grid.size - ivec3(1));
    ivec3 e = (n >> 3) - (i >> 3);
    ivec3 s = (n & 7) - (i & 7);
    return NextSample(uvec3(uint(e.x), uint(e.y) * row, uint(e.z) * row * uint(grid.brick_counts.y)),
                      uvec3(uint(s.x), 8u * uint(s.y), 64u * uint(s.z)));
}

// Of samples of any kind.
FN_APART float trilinear_coded(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p, ivec3 i, uint channel) {
    NextSample next = next_sample(grid, i);
    uint entry = grid.table_first + brick_entry(grid, i);
    uint at = brick_offset(i);
    float v[8];
    for (uint k = 0u; k < 8u; ++k) {
        uvec3 far = uvec3(k & 1u, (k >> 1u) & 1u, k >> 2u);
        uvec3 over = far * next.entries;
        uvec3 step = far * next.step;
        uint first = scene.words.at[entry + over.x + over.y + over.z] + channel * grid.channel_words;
        v[k] = brick_sample(scene, grid.storage, first, at + step.x + step.y + step.z);
    }
    return trilinear_mix(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], sample_weights(p, i));
}

// Of floats in several bricks.
FN_APART float trilinear_across(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p, ivec3 i, uint channel) {
    NextSample next = next_sample(grid, i);
    uint e = grid.table_first + brick_entry(grid, i);
    uint ez = e + next.entries.z;
    uint b000 = brick_offset(i) + channel * grid.channel_words;
    uint b100 = b000 + next.step.x;
    uint b010 = b000 + next.step.y;
    uint b110 = b010 + next.step.x;
    return trilinear_mix(
        bits_float(scene.words.at[scene.words.at[e] + b000]),
        bits_float(scene.words.at[scene.words.at[e + next.entries.x] + b100]),
        bits_float(scene.words.at[scene.words.at[e + next.entries.y] + b010]),
        bits_float(scene.words.at[scene.words.at[e + next.entries.x + next.entries.y] + b110]),
        bits_float(scene.words.at[scene.words.at[ez] + b000 + next.step.z]),
        bits_float(scene.words.at[scene.words.at[ez + next.entries.x] + b100 + next.step.z]),
        bits_float(scene.words.at[scene.words.at[ez + next.entries.y] + b010 + next.step.z]),
        bits_float(scene.words.at[scene.words.at[ez + next.entries.x + next.entries.y] + b110 + next.step.z]),
        sample_weights(p, i));
}

// Floats in one brick, which is most look-ups, in the fewest steps; bricks at the upper faces repeat the last sample.
FN float grid_trilinear(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p, uint channel) {
    ivec3 i = sample_before(p);
#ifdef __cplusplus
    if (grid.storage != GRID_FLOAT) return trilinear_coded(scene, grid, p, i, channel);
    if ((((i.x ^ (i.x + 1)) | (i.y ^ (i.y + 1)) | (i.z ^ (i.z + 1))) & 8) != 0)
        return trilinear_across(scene, grid, p, i, channel);
    uint b = scene.words.at[grid.table_first + brick_entry(grid, i)] + channel * grid.channel_words + brick_offset(i);
    return trilinear_mix(
        bits_float(scene.words.at[b]), bits_float(scene.words.at[b + 1u]), bits_float(scene.words.at[b + 8u]),
        bits_float(scene.words.at[b + 9u]), bits_float(scene.words.at[b + 64u]), bits_float(scene.words.at[b + 65u]),
        bits_float(scene.words.at[b + 72u]), bits_float(scene.words.at[b + 73u]), sample_weights(p, i));
#else  // shaders hold a copy of this for each place where a grid is asked: one way for all is the shortest
    return trilinear_coded(scene, grid, p, i, channel);
#endif
}

// Cubic B-spline over 4³ samples: twice continuously differentiable, a convex combination of what is around, so bounds
// of the samples are bounds of it. It smooths: at a sample it gives that sample's neighbourhood, not the sample.
FN_APART float grid_tricubic(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p, uint channel) {
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

// A value at p in index space, where sample i sits at i + ½, in the box.
FN float grid_value_within(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p, uint channel) {
    if (grid.filter_kind == FILTER_TRILINEAR) return grid_trilinear(scene, grid, p, channel);
    if (grid.filter_kind == FILTER_NEAREST) return grid_sample(scene, grid, ivec3(p), channel);
    return grid_tricubic(scene, grid, p, channel);
}

// Anywhere: outside of the box is the background.
FN float grid_value(const_in(SceneView) scene, const_in(DensityGrid) grid, vec3 p, uint channel) {
    return grid_contains(grid, p) ? grid_value_within(scene, grid, p, channel) : grid.background;
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
