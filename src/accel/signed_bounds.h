#pragma once
// A box in one vector register of eight lanes where there is one: the lower corner negated, so that the hull of two
// boxes is a single maximum.

#ifdef __AVX__
#include <immintrin.h>
#endif

#include <cstddef>

#include "accel/float4.h"

namespace spinel {

#ifdef __AVX__

struct SignedBounds {
    __m256 v;  // −lower, upper; lanes 3 and 7 are idle

    SignedBounds() : v(_mm256_set1_ps(-std::numeric_limits<float>::infinity())) {}  // empty
    SignedBounds(Float4 negated_lower, Float4 upper) : v(_mm256_set_m128(upper.v, negated_lower.v)) {}

    // Eight floats, aligned to 32 bytes.
    static SignedBounds load(const float* p) { return SignedBounds(_mm256_load_ps(p)); }
    void store(float* p) const { _mm256_store_ps(p, v); }

    void extend(SignedBounds other) { v = _mm256_max_ps(v, other.v); }
    // Every lane of both corners lowered by as much: infinity makes it empty.
    SignedBounds lowered(float by) const { return SignedBounds(_mm256_sub_ps(v, _mm256_set1_ps(by))); }
    // The centre alone. Halved before adding, as the sum may be beyond what floats hold.
    SignedBounds center() const {
        const __m256 half = _mm256_mul_ps(v, _mm256_set1_ps(0.5f));
        return SignedBounds(_mm256_sub_ps(half, _mm256_permute2f128_ps(half, half, 1)));
    }
    Float4 negated_lower() const { return Float4(_mm256_castps256_ps128(v)); }
    Float4 upper() const { return Float4(_mm256_extractf128_ps(v, 1)); }

  private:
    explicit SignedBounds(__m256 lanes) : v(lanes) {}
};

#else

struct SignedBounds {
    Float4 low = Float4(-std::numeric_limits<float>::infinity()), high = low;

    SignedBounds() = default;
    SignedBounds(Float4 negated_lower, Float4 upper) : low(negated_lower), high(upper) {}

    static SignedBounds load(const float* p) { return {Float4::load(p), Float4::load(p + 4)}; }
    void store(float* p) const {
        low.store(p);
        high.store(p + 4);
    }

    void extend(SignedBounds other) {
        low = max(low, other.low);
        high = max(high, other.high);
    }
    SignedBounds lowered(float by) const { return {low - Float4(by), high - Float4(by)}; }
    SignedBounds center() const {
        const Float4 a = low * Float4(0.5f), b = high * Float4(0.5f);
        return {a - b, b - a};
    }
    Float4 negated_lower() const { return low; }
    Float4 upper() const { return high; }
};

#endif

// With anything in the idle lanes.
inline SignedBounds signed_bounds(const Box& box) {
    const Bounds b = bounds_of(box);
    return {Float4(0.0f) - b.lower, b.upper};
}

inline SignedBounds signed_bounds(const kernels::Triangle& t) {
    static_assert(sizeof t == 9 * sizeof(float));
    const Float4 a = Float4::load_anywhere(&t.a.x), b = Float4::load_anywhere(&t.b.x);
    const Float4 c = rotated(Float4::load_anywhere(&t.b.z));
    return {Float4(0.0f) - min(a, min(b, c)), max(a, max(b, c))};
}

inline glm::vec3 lower_of(SignedBounds b) {
    const auto l = lanes_of(b.negated_lower());
    return {-l[0], -l[1], -l[2]};
}
inline glm::vec3 upper_of(SignedBounds b) {
    const auto l = lanes_of(b.upper());
    return {l[0], l[1], l[2]};
}
// Into the node's box; `first` and `count` are of no meaning afterwards.
inline void put_bounds(SignedBounds b, kernels::BvhNode& node) {
    static_assert(offsetof(kernels::BvhNode, upper) == 16 && sizeof node == 32);
    (Float4(0.0f) - b.negated_lower()).store_anywhere(&node.lower.x);
    b.upper().store_anywhere(&node.upper.x);
}
inline Float4 extent_of(SignedBounds b) { return b.upper() + b.negated_lower(); }
// Whether it is finite and ordered; false for NaN.
inline bool is_usable(SignedBounds b) {
    const Float4 infinity(std::numeric_limits<float>::infinity());
    const int finite = less_mask(b.negated_lower(), infinity) & less_mask(b.upper(), infinity);
    return (finite & ~less_mask(extent_of(b), Float4(0.0f)) & 7) == 7;
}
inline float half_area(SignedBounds b) { return half_area(extent_of(b)); }  // NaN or infinite if empty
inline Float4 half_areas(SignedBounds a, SignedBounds b, SignedBounds c, SignedBounds d) {
    Float4 x = extent_of(a), y = extent_of(b), z = extent_of(c), w = extent_of(d);
    transpose(x, y, z, w);
    return x * y + y * z + z * x;
}

}  // namespace spinel
