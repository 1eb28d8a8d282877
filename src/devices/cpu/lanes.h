#pragma once
// Eight numbers at once, in the compilers' own vector types: AVX2 where there is AVX2, narrower code elsewhere.

#include <cmath>
#include <cstdint>

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace spinel {

using Float8 = float __attribute__((vector_size(32)));
using Int8 = std::int32_t __attribute__((vector_size(32)));
using Uint8 = std::uint32_t __attribute__((vector_size(32)));
using Double8 = double __attribute__((vector_size(64)));

// A vector that is wider than the machine's registers comes back in memory, which g++ remarks; nothing but this program
// calls it.
#pragma GCC diagnostic ignored "-Wpsabi"

inline Float8 splat(float x) { return Float8{x, x, x, x, x, x, x, x}; }
inline Int8 splat(std::int32_t x) { return Int8{x, x, x, x, x, x, x, x}; }
inline Float8 to_float(Int8 x) { return __builtin_convertvector(x, Float8); }
inline Int8 to_int(Float8 x) { return __builtin_convertvector(x, Int8); }  // towards zero

inline Double8 to_double(Int8 x) { return __builtin_convertvector(x, Double8); }

inline Float8 minimum(Float8 a, Float8 b) { return a < b ? a : b; }
inline Float8 maximum(Float8 a, Float8 b) { return a > b ? a : b; }
inline Int8 minimum(Int8 a, Int8 b) { return a < b ? a : b; }
inline Int8 maximum(Int8 a, Int8 b) { return a > b ? a : b; }
inline Float8 mix8(Float8 a, Float8 b, Float8 t) { return a + (b - a) * t; }

// Of numbers that an int holds.
inline Float8 floor8(Float8 x) {
    const Float8 t = to_float(to_int(x));
    return t > x ? t - 1.0f : t;
}

inline Float8 absolute(Float8 x) { return (Float8)((Int8)x & 0x7fffffff); }

// Masks have all bits of a lane or none.
inline bool any(Int8 mask) {
#ifdef __AVX2__
    return _mm256_movemask_ps(__m256(mask)) != 0;
#else
    for (int i = 0; i < 8; ++i)
        if (mask[i]) return true;
    return false;
#endif
}

inline std::int32_t least(Int8 x) {
#ifdef __AVX2__
    __m128i m = _mm_min_epi32(_mm256_castsi256_si128(__m256i(x)), _mm256_extracti128_si256(__m256i(x), 1));
    m = _mm_min_epi32(m, _mm_shuffle_epi32(m, 0x4e));
    m = _mm_min_epi32(m, _mm_shuffle_epi32(m, 0xb1));
    return _mm_cvtsi128_si32(m);
#else
    std::int32_t m = x[0];
    for (int i = 1; i < 8; ++i) m = x[i] < m ? x[i] : m;
    return m;
#endif
}

// Entries of a table.
inline Float8 gather(const float* table, Int8 at) {
#ifdef __AVX2__
    return Float8(_mm256_i32gather_ps(table, __m256i(at), 4));
#else
    Float8 out;
    for (int i = 0; i < 8; ++i) out[i] = table[at[i]];
    return out;
#endif
}
inline Uint8 gather(const std::uint32_t* table, Int8 at) {
#ifdef __AVX2__
    return Uint8(_mm256_i32gather_epi32(reinterpret_cast<const int*>(table), __m256i(at), 4));
#else
    Uint8 out;
    for (int i = 0; i < 8; ++i) out[i] = table[at[i]];
    return out;
#endif
}
// Of bytes, behind which three more may be read.
inline Int8 gather(const std::uint8_t* table, Int8 at) {
#ifdef __AVX2__
    return Int8(_mm256_i32gather_epi32(reinterpret_cast<const int*>(table), __m256i(at), 1)) & 0xff;
#else
    Int8 out;
    for (int i = 0; i < 8; ++i) out[i] = table[at[i]];
    return out;
#endif
}

// Linear between entries 0 … last, last ≥ 1, of a table; x from 0 to last.
inline Float8 gather_linear(const float* table, Float8 x, int last) {
    const Int8 i = minimum(to_int(x), splat(last - 1));
    return mix8(gather(table, i), gather(table + 1, i), x - to_float(i));
}

inline Float8 square_root(Float8 x) {
#ifdef __AVX2__
    return Float8(_mm256_sqrt_ps(__m256(x)));
#else
    for (int i = 0; i < 8; ++i) x[i] = std::sqrt(x[i]);
    return x;
#endif
}

// exp(x) for x ≤ 0 within 2 units of rounding, 0 below −87: 2^n by the exponent's bits, e^r for |r| ≤ ln 2 / 2 by its
// series.
inline Float8 exp_negative(Float8 x) {
    const Float8 bounded = maximum(x, splat(-87.0f));
    const Float8 n = floor8(bounded * 1.44269504f + 0.5f);
    const Float8 r = (bounded - n * 0.693359375f) + n * 2.12194440e-4f;
    Float8 p = splat(1.0f / 5040);
    p = p * r + 1.0f / 720;
    p = p * r + 1.0f / 120;
    p = p * r + 1.0f / 24;
    p = p * r + 1.0f / 6;
    p = p * r + 0.5f;
    p = p * r + 1.0f;
    p = p * r + 1.0f;
    const Float8 scale = (Float8)((to_int(n) + 127) << 23);
    return x < -87.0f ? splat(0.0f) : p * scale;
}

}  // namespace spinel
