#ifndef SPINEL_KERNELS_PORTABLE_H
#define SPINEL_KERNELS_PORTABLE_H
// The kernel language: the common subset of C++20 and GLSL 4.60 in which Spinel's physics is written once.
//
// A kernel header is compiled by g++ (with GLM for GLSL's vocabulary) and by glslc to SPIR-V. This file is the whole
// difference between the two:
//
//   FN               marks a function: `inline` in C++, nothing in GLSL
//   FN_ANEW          the same, compiled anew wherever it is called: what is constant there costs nothing
//   FN_APART         never so: what is rare beside a common case that should stay small
//   inout(T)         a parameter that is read and written; GLSL copies in and out, so never alias two
//   const_in(T)      a large read-only parameter: a reference in C++, `const in` in GLSL
//   RECORD(T)        a local name for a record of a buffer: a reference in C++, a copy in GLSL; never written to
//   ALIGNED(bytes)   of a record: for vector loads in C++
//   BUFFER(Name, T)  a read-only array that lives in device memory; element i is `name.at[i]`
//   KERNELS_BEGIN    opens namespace spinel::kernels in C++, nothing in GLSL; KERNELS_END closes it
//
// Rules: float literals end in f; no swizzles, templates, member functions, recursion, pointers or enums; array
// parameters are wrapped in a struct; no GLSL reserved word as a name (active, sample, input, output, filter, common,
// buffer, shared, flat, smooth, patch, half, fixed, ...). Every loop has a bound.

#ifdef __cplusplus

#ifndef GLM_FORCE_XYZW_ONLY
#define GLM_FORCE_XYZW_ONLY  // no swizzle members: a vec3 stays three floats, as in GLSL's scalar layout
#endif
#ifndef GLM_FORCE_INLINE
#define GLM_FORCE_INLINE  // g++ leaves some of GLM's one-line functions out of line in large kernels
#endif
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>
#ifdef __F16C__
#include <immintrin.h>
#endif

#define FN inline
#define FN_ANEW inline __attribute__((always_inline))
#define FN_APART inline __attribute__((noinline))
#define inout(T) T&
#define const_in(T) const T&
#define RECORD(T) const T&
#define ALIGNED(bytes) alignas(bytes)
#define BUFFER(Name, T) \
    struct Name {       \
        const T* at;    \
    };
#define KERNELS_BEGIN           \
    namespace spinel::kernels { \
    using namespace glm;
#define KERNELS_END }

namespace spinel::kernels {
using uint = std::uint32_t;
using mask64 = std::uint64_t;

inline uint popcount32(uint x) { return static_cast<uint>(std::popcount(x)); }
inline uint popcount64(mask64 x) { return static_cast<uint>(std::popcount(x)); }
inline uint trailing_zeros64(mask64 x) { return static_cast<uint>(std::countr_zero(x)); }
inline bool mask64_bit(mask64 m, uint i) { return ((m >> i) & 1u) != 0; }
// Bits below i, for rank queries: i in [0, 63].
inline mask64 mask64_below(mask64 m, uint i) { return m & ((mask64(1) << i) - 1); }
inline mask64 make_mask64(uint low, uint high) { return low | mask64(high) << 32; }
inline uint mask64_low(mask64 m) { return static_cast<uint>(m); }
inline mask64 mask64_shift_right(mask64 m, uint i) { return m >> i; }  // i in [0, 63]
inline uint leading_zeros32(uint x) { return static_cast<uint>(std::countl_zero(x)); }
inline uint reverse_bits32(uint x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    return __builtin_bswap32(x);
}
// Two at once for the price of one.
inline glm::uvec2 reverse_bits32(glm::uvec2 v) {
    constexpr std::uint64_t ones = ~std::uint64_t(0);  // glslc reads this too, and refuses literals of 64 bits
    std::uint64_t x = v.x | (std::uint64_t(v.y) << 32);
    x = ((x >> 1) & (ones / 3)) | ((x & (ones / 3)) << 1);
    x = ((x >> 2) & (ones / 5)) | ((x & (ones / 5)) << 2);
    x = ((x >> 4) & (ones / 17)) | ((x & (ones / 17)) << 4);
    x = __builtin_bswap64(x);  // and the halves change places
    return glm::uvec2(uint(x >> 32), uint(x));
}
inline uint float_bits(float x) { return std::bit_cast<uint>(x); }
inline float bits_float(uint x) { return std::bit_cast<float>(x); }
// Of IEEE's 16 bits.
inline float half_float(uint x) {
#ifdef __F16C__
    return _cvtsh_ss(static_cast<unsigned short>(x));
#else
    return glm::unpackHalf1x16(static_cast<std::uint16_t>(x));
#endif
}
}  // namespace spinel::kernels

#else  // GLSL

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require

#define FN
#define FN_ANEW
#define FN_APART
#define inout(T) inout T
#define const_in(T) const in T
#define RECORD(T) T
#define ALIGNED(bytes)
#define BUFFER(Name, T) \
    layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Name { T at[]; };
#define KERNELS_BEGIN
#define KERNELS_END

#define mask64 uvec2
FN uint popcount32(uint x) { return uint(bitCount(x)); }
FN uint popcount64(mask64 x) { return uint(bitCount(x.x) + bitCount(x.y)); }
FN uint trailing_zeros64(mask64 x) {
    return x.x != 0u ? uint(findLSB(x.x)) : (x.y != 0u ? 32u + uint(findLSB(x.y)) : 64u);
}
FN bool mask64_bit(mask64 m, uint i) { return (((i < 32u ? m.x : m.y) >> (i & 31u)) & 1u) != 0u; }
FN mask64 mask64_below(mask64 m, uint i) {
    return i < 32u ? uvec2(m.x & ((1u << i) - 1u), 0u) : uvec2(m.x, m.y & ((1u << (i - 32u)) - 1u));
}
FN mask64 make_mask64(uint low, uint high) { return uvec2(low, high); }
FN uint mask64_low(mask64 m) { return m.x; }
FN mask64 mask64_shift_right(mask64 m, uint i) {
    if (i >= 32u) return uvec2(m.y >> (i - 32u), 0u);
    return i == 0u ? m : uvec2((m.x >> i) | (m.y << (32u - i)), m.y >> i);
}
FN uint leading_zeros32(uint x) { return x == 0u ? 32u : 31u - uint(findMSB(x)); }
FN uint reverse_bits32(uint x) { return bitfieldReverse(x); }
FN uvec2 reverse_bits32(uvec2 v) { return bitfieldReverse(v); }
FN uint float_bits(float x) { return floatBitsToUint(x); }
FN float bits_float(uint x) { return uintBitsToFloat(x); }
FN float half_float(uint x) { return unpackHalf2x16(x).x; }

#endif
#endif
