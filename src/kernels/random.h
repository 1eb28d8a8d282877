#ifndef SPINEL_KERNELS_RANDOM_H
#define SPINEL_KERNELS_RANDOM_H
// Random numbers as pure functions of (pixel, sample index, dimension, seed): threads, tiles, ranks and
// devices agree.
//
// A pixel's samples are Owen-scrambled Sobol points, padded by pairs of dimensions: every pair reuses the
// first two Sobol dimensions, with its own scrambling and its own (nested uniform) shuffle of the sample
// index.
//   Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020;
//   Laine, Karras, "Stratified Sampling for Stochastic Transparency", EGSR 2011: the hash, here with the
//   constants of Vegdahl, "Building a Better LK Hash" (2021), which come closer to a true Owen scramble.
// Every power-of-two run of indices that starts at a multiple of its length is a (0, m, 2)-net in each pair,
// and different pairs and pixels are independent of each other.
//
// Scrambling works on bit-reversed numbers (the most significant digit first becomes the lowest bit first),
// so the sampler keeps the index reversed, and the Sobol matrices are applied in reversed form: dimension 0
// is the identity, dimension 1 Pascal's triangle modulo 2.
#include "constants.h"
KERNELS_BEGIN

// A bijection of 32 bits without visible bias. Multiply–xorshift rounds after Wellons, "Hash Function
// Prospector".
FN uint hash_uint(uint x) {
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0x735a2d97u;
    x ^= x >> 15;
    return x;
}

FN uint hash_combine(uint hash, uint value) {
    return hash_uint(hash ^ (value + 0x9e3779b9u + (hash << 6) + (hash >> 2)));
}

// The top 24 bits as a number in [0, ONE_MINUS_EPSILON].
FN float uint_to_unit_float(uint x) { return float(x >> 8) * 5.9604644775390625e-8f; }

// Owen scrambling of a bit-reversed number: bit i is flipped by a hash of the bits below it.
FN uint laine_karras_permutation(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

// The second Sobol dimension, bit-reversed. Its generator matrix is Pascal's triangle modulo 2, C(j, i) = 1
// where the bits of i are a subset of those of j (Lucas): a sum over supersets, five stages of a butterfly.
FN uint sobol_reversed_1(uint index) {
    index ^= (index >> 1) & 0x55555555u;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 8) & 0x00ff00ffu;
    index ^= (index >> 16) & 0x0000ffffu;
    return index;
}

struct Sampler {
    uint pixel_hash;      // of pixel and seed
    uint reversed_index;  // the sample index, its bits reversed
    uint dimension;       // how many pairs have been drawn
    uint seed;
};

FN Sampler make_sampler(uvec2 pixel, uint index, uint seed) {
    uint pixel_hash = hash_combine(hash_combine(hash_uint(seed ^ 0x5f356495u), pixel.x), pixel.y);
    return Sampler(pixel_hash, reverse_bits32(index), 0u, seed);
}

// The next pair of dimensions.
FN vec2 sampler_2d(inout(Sampler) s) {
    uint hash = hash_uint(s.pixel_hash + s.dimension * 0x9e3779b9u);
    s.dimension += 1u;
    uint index = reverse_bits32(laine_karras_permutation(s.reversed_index, hash));
    uint x = laine_karras_permutation(index, hash * 0x85ebca6bu + 0x68bc21ebu);
    uint y = laine_karras_permutation(sobol_reversed_1(index), hash * 0xc2b2ae35u + 0x02e5be93u);
    uvec2 point = reverse_bits32(uvec2(x, y));
    return vec2(uint_to_unit_float(point.x), uint_to_unit_float(point.y));
}

// The next dimension; it takes up a pair.
FN float sampler_1d(inout(Sampler) s) {
    uint hash = hash_uint(s.pixel_hash + s.dimension * 0x9e3779b9u);
    s.dimension += 1u;
    uint index = reverse_bits32(laine_karras_permutation(s.reversed_index, hash));
    uint x = laine_karras_permutation(index, hash * 0x85ebca6bu + 0x68bc21ebu);
    return uint_to_unit_float(reverse_bits32(x));
}

// An independent stream, for loops without a known number of dimensions (null collisions). Counter-based, in the manner
// of Salmon et al., "Parallel Random Numbers: As Easy as 1, 2, 3", 2011: the key permutes the hashed counter, so that
// streams do not run into each other as those of one long cycle would.
struct Rng {
    uint key;
    uint counter;
};

// Streams of one sample differ by salt; the sampler's dimension plays no part.
FN Rng make_rng(Sampler s, uint salt) {
    return Rng(hash_combine(hash_combine(s.pixel_hash, s.reversed_index), salt), 0u);
}

FN uint rng_uint(inout(Rng) r) {
    uint counter = r.counter;
    r.counter = counter + 1u;
    return hash_uint(hash_uint(counter + 0x9e3779b9u) ^ r.key);
}

FN float rng_1d(inout(Rng) r) { return uint_to_unit_float(rng_uint(r)); }

KERNELS_END
#endif
