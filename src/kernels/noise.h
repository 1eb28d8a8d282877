#ifndef SPINEL_KERNELS_NOISE_H
#define SPINEL_KERNELS_NOISE_H
// Value noise on the integer lattice and its fractal sum.
// A lattice point's value is a hash of its coordinates; between points they are blended with quintic weights
// (Perlin, "Improving Noise", SIGGRAPH 2002), so the second derivative is continuous.
#include "random.h"
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

const uint FBM_MAX_OCTAVES = 24u;

// Fractal sum, each octave twice the frequency and half the amplitude of the one before, divided by the sum
// of the amplitudes. Sound bound: |fbm_noise| ≤ 1, a convex combination of value noises. Octaves are clamped
// to FBM_MAX_OCTAVES: a float has no finer detail.
FN float fbm_noise(vec3 p, uint octaves) {
    float sum = 0.0f;
    float amplitude = 1.0f;
    float total = 0.0f;
    uint count = clamp(octaves, 1u, FBM_MAX_OCTAVES);
    for (uint i = 0u; i < count; ++i) {
        sum += amplitude * value_noise(p);
        total += amplitude;
        amplitude *= 0.5f;
        p = 2.0f * p + vec3(17.17f, 31.73f, 5.39f);  // octaves do not share their lattice points
    }
    return clamp(sum / total, -1.0f, 1.0f);
}

KERNELS_END
#endif
