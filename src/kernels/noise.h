#ifndef SPINEL_KERNELS_NOISE_H
#define SPINEL_KERNELS_NOISE_H
// Value, Perlin and simplex noise, and their fractal sums.
// A lattice point's value is a hash of its coordinates; between points they are blended with quintic weights
// (Perlin, "Improving Noise", SIGGRAPH 2002), so the second derivative is continuous.
#include "random.h"
#include "scene_view.h"
KERNELS_BEGIN

// In [−1, 1).
FN float lattice_value(ivec3 p) {
    uint h = hash_uint(uint(p.x) * 0x8da6b343u + uint(p.y) * 0xd8163841u + uint(p.z) * 0xcb1ab31fu);
    return float(h >> 8) * 1.1920928955078125e-7f - 1.0f;
}

FN vec3 quintic_weights(vec3 t) { return t * t * t * (t * (t * 6.0f - vec3(15.0f)) + vec3(10.0f)); }

// Sound bound: |value_noise| ≤ 1, a convex combination of lattice values.
FN float value_noise(vec3 p) {
    // A lattice index has to fit an int with room for + 1; beyond, float has no fraction left anyway.
    p = clamp(p, vec3(-1.0e9f), vec3(1.0e9f));
    vec3 base = floor(p);
    vec3 w = clamp(quintic_weights(p - base), vec3(0.0f), vec3(1.0f));
    ivec3 c = ivec3(base);
    float x00 = mix(lattice_value(c), lattice_value(c + ivec3(1, 0, 0)), w.x);
    float x10 = mix(lattice_value(c + ivec3(0, 1, 0)), lattice_value(c + ivec3(1, 1, 0)), w.x);
    float x01 = mix(lattice_value(c + ivec3(0, 0, 1)), lattice_value(c + ivec3(1, 0, 1)), w.x);
    float x11 = mix(lattice_value(c + ivec3(0, 1, 1)), lattice_value(c + ivec3(1, 1, 1)), w.x);
    return clamp(mix(mix(x00, x10, w.y), mix(x01, x11, w.y), w.z), -1.0f, 1.0f);
}

// Gradient of a lattice point: one of the twelve directions to the edges of a cube, of length √2, four of them twice
// (Perlin 2002).
FN vec3 lattice_gradient(ivec3 p) {
    uint h = hash_uint(uint(p.x) * 0x8da6b343u + uint(p.y) * 0xd8163841u + uint(p.z) * 0xcb1ab31fu) & 15u;
    float s = (h & 1u) == 0u ? 1.0f : -1.0f;
    float t = (h & 2u) == 0u ? 1.0f : -1.0f;
    if (h < 4u || h == 12u || h == 14u) return vec3(s, t, 0.0f);
    if (h < 8u) return vec3(s, 0.0f, t);
    return vec3(0.0f, s, t);
}

// What a corner adds, at the offset d from it.
FN float lattice_slope(ivec3 corner, vec3 d) { return dot(lattice_gradient(corner), d); }

// Perlin's gradient noise, 0 at the lattice. Clamped: its extremes are a few percent beyond 1.
FN float perlin_noise(vec3 p) {
    p = clamp(p, vec3(-1.0e9f), vec3(1.0e9f));
    vec3 base = floor(p);
    vec3 d = p - base;
    vec3 w = clamp(quintic_weights(d), vec3(0.0f), vec3(1.0f));
    ivec3 c = ivec3(base);
    float x00 = mix(lattice_slope(c, d), lattice_slope(c + ivec3(1, 0, 0), d - vec3(1.0f, 0.0f, 0.0f)), w.x);
    float x10 = mix(lattice_slope(c + ivec3(0, 1, 0), d - vec3(0.0f, 1.0f, 0.0f)),
                    lattice_slope(c + ivec3(1, 1, 0), d - vec3(1.0f, 1.0f, 0.0f)), w.x);
    float x01 = mix(lattice_slope(c + ivec3(0, 0, 1), d - vec3(0.0f, 0.0f, 1.0f)),
                    lattice_slope(c + ivec3(1, 0, 1), d - vec3(1.0f, 0.0f, 1.0f)), w.x);
    float x11 = mix(lattice_slope(c + ivec3(0, 1, 1), d - vec3(0.0f, 1.0f, 1.0f)),
                    lattice_slope(c + ivec3(1, 1, 1), d - vec3(1.0f, 1.0f, 1.0f)), w.x);
    return clamp(mix(mix(x00, x10, w.y), mix(x01, x11, w.y), w.z), -1.0f, 1.0f);
}

const float SIMPLEX_SKEW = 1.0f / 3.0f;
const float SIMPLEX_UNSKEW = 1.0f / 6.0f;
const float SIMPLEX_SCALE = 74.0f;  // brings the sum to about −1 … 1
const float SIMPLEX_REACH = 0.5f;   // square of the distance to which a corner is felt: that of the opposite face

// What a corner of the skewed lattice adds at the offset d from it.
FN float simplex_corner(ivec3 corner, vec3 d) {
    float t = max(0.0f, SIMPLEX_REACH - dot(d, d));
    return t * t * t * t * dot(lattice_gradient(corner), d);
}

// Perlin's simplex noise: four corners in place of eight (Gustavson, "Simplex Noise Demystified", 2005). Clamped.
FN float simplex_noise(vec3 p) {
    p = clamp(p, vec3(-1.0e8f), vec3(1.0e8f));
    vec3 cell = floor(p + vec3((p.x + p.y + p.z) * SIMPLEX_SKEW));
    vec3 d = p - (cell - vec3((cell.x + cell.y + cell.z) * SIMPLEX_UNSKEW));
    // Which of the six simplices of the cell: the axes in falling order of the offset.
    ivec3 first =
        d.x >= d.y ? (d.x >= d.z ? ivec3(1, 0, 0) : ivec3(0, 0, 1)) : (d.y >= d.z ? ivec3(0, 1, 0) : ivec3(0, 0, 1));
    ivec3 spare =
        d.x < d.y ? (d.x < d.z ? ivec3(1, 0, 0) : ivec3(0, 0, 1)) : (d.y < d.z ? ivec3(0, 1, 0) : ivec3(0, 0, 1));
    ivec3 second = ivec3(1) - spare;
    ivec3 c = ivec3(cell);
    float sum = simplex_corner(c, d) + simplex_corner(c + first, d - vec3(first) + SIMPLEX_UNSKEW) +
                simplex_corner(c + second, d - vec3(second) + 2.0f * SIMPLEX_UNSKEW) +
                simplex_corner(c + ivec3(1), d - vec3(1.0f - 3.0f * SIMPLEX_UNSKEW));
    return clamp(SIMPLEX_SCALE * sum, -1.0f, 1.0f);
}

FN float basis_noise(uint kind, vec3 p) {
    if (kind == NOISE_PERLIN) return perlin_noise(p);
    if (kind == NOISE_SIMPLEX) return simplex_noise(p);
    return value_noise(p);
}

const uint FBM_MAX_OCTAVES = 24u;

// Added between octaves, so that they do not share their lattice points.
FN vec3 octave_shift() { return vec3(17.17f, 31.73f, 5.39f); }

// Fractal sum: each octave `lacunarity` times the frequency and `gain` times the amplitude of the one before, divided
// by the sum of the amplitudes. Sound bound: |fractal_noise| ≤ 1, a convex combination of what lies in [−1, 1]. Octaves
// are clamped to FBM_MAX_OCTAVES: a float has no finer detail.
FN float fractal_noise(uint kind, vec3 p, uint octaves, float gain, float lacunarity) {
    float sum = 0.0f;
    float amplitude = 1.0f;
    float total = 0.0f;
    uint count = clamp(octaves, 1u, FBM_MAX_OCTAVES);
    for (uint i = 0u; i < count; ++i) {
        sum += amplitude * basis_noise(kind, p);
        total += amplitude;
        amplitude *= gain;
        p = lacunarity * p + octave_shift();
    }
    return clamp(sum / total, -1.0f, 1.0f);
}

// Of value noise, each octave twice the frequency and half the amplitude.
FN float fbm_noise(vec3 p, uint octaves) { return fractal_noise(NOISE_VALUE, p, octaves, 0.5f, 2.0f); }

KERNELS_END
#endif
