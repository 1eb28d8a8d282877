#pragma once
// Four floats in a vector register, as builders need them: boxes are two of these. The fourth lane is idle.

#include <array>
#include <limits>
#include <utility>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "accel/bvh_builder.h"

namespace spinel {

#ifdef __SSE2__

struct Float4 {
    __m128 v;

    Float4() = default;  // of any value
    explicit Float4(float x) : v(_mm_set1_ps(x)) {}
    explicit Float4(glm::vec3 x) : v(_mm_setr_ps(x.x, x.y, x.z, 0)) {}
    explicit Float4(__m128 x) : v(x) {}

    static Float4 load(const float* p) { return Float4(_mm_load_ps(p)); }  // aligned to 16 bytes
    static Float4 load_anywhere(const float* p) { return Float4(_mm_loadu_ps(p)); }
    void store(float* p) const { _mm_store_ps(p, v); }
    void store_anywhere(float* p) const { _mm_storeu_ps(p, v); }
};

inline Float4 operator+(Float4 a, Float4 b) { return Float4(_mm_add_ps(a.v, b.v)); }
inline Float4 operator-(Float4 a, Float4 b) { return Float4(_mm_sub_ps(a.v, b.v)); }
inline Float4 operator*(Float4 a, Float4 b) { return Float4(_mm_mul_ps(a.v, b.v)); }
inline Float4 min(Float4 a, Float4 b) { return Float4(_mm_min_ps(a.v, b.v)); }
inline Float4 max(Float4 a, Float4 b) { return Float4(_mm_max_ps(a.v, b.v)); }
inline Float4 operator/(Float4 a, Float4 b) { return Float4(_mm_div_ps(a.v, b.v)); }
// Lanes of `yes` where a < b, else those of `no`.
inline Float4 where_less(Float4 a, Float4 b, Float4 yes, Float4 no) {
    const __m128 less = _mm_cmplt_ps(a.v, b.v);
    return Float4(_mm_or_ps(_mm_and_ps(less, yes.v), _mm_andnot_ps(less, no.v)));
}
// Bit i: whether a < b in lane i.
inline int less_mask(Float4 a, Float4 b) { return _mm_movemask_ps(_mm_cmplt_ps(a.v, b.v)); }
// Lanes 1, 2, 3, 0.
inline Float4 rotated(Float4 a) { return Float4(_mm_shuffle_ps(a.v, a.v, _MM_SHUFFLE(0, 3, 2, 1))); }
// Rows become columns.
inline void transpose(Float4& a, Float4& b, Float4& c, Float4& d) { _MM_TRANSPOSE4_PS(a.v, b.v, c.v, d.v); }
// Towards zero; what an int cannot hold becomes its least value.
inline void store_truncated(Float4 a, int* p) { _mm_store_si128(reinterpret_cast<__m128i*>(p), _mm_cvttps_epi32(a.v)); }
// x·y + y·z + z·x
inline float half_area(Float4 e) {
    const __m128 turned = _mm_shuffle_ps(e.v, e.v, _MM_SHUFFLE(3, 0, 2, 1));
    const __m128 p = _mm_mul_ps(e.v, turned);
    return _mm_cvtss_f32(_mm_add_ss(_mm_add_ss(p, _mm_shuffle_ps(p, p, 1)), _mm_movehl_ps(p, p)));
}

#else

struct alignas(16) Float4 {
    std::array<float, 4> v;

    Float4() = default;  // of any value
    explicit Float4(float x) : v{x, x, x, x} {}
    explicit Float4(glm::vec3 x) : v{x.x, x.y, x.z, 0} {}
    explicit Float4(std::array<float, 4> x) : v(x) {}

    static Float4 load(const float* p) { return Float4(std::array<float, 4>{p[0], p[1], p[2], p[3]}); }
    static Float4 load_anywhere(const float* p) { return load(p); }
    void store(float* p) const {
        for (int i = 0; i < 4; ++i) p[i] = v[std::size_t(i)];
    }
    void store_anywhere(float* p) const { store(p); }
};

template <class Operation>
Float4 lane_by_lane(Float4 a, Float4 b, const Operation& operation) {
    for (std::size_t i = 0; i < 4; ++i) a.v[i] = operation(a.v[i], b.v[i]);
    return a;
}
inline Float4 operator+(Float4 a, Float4 b) {
    return lane_by_lane(a, b, [](float x, float y) { return x + y; });
}
inline Float4 operator-(Float4 a, Float4 b) {
    return lane_by_lane(a, b, [](float x, float y) { return x - y; });
}
inline Float4 operator*(Float4 a, Float4 b) {
    return lane_by_lane(a, b, [](float x, float y) { return x * y; });
}
inline Float4 min(Float4 a, Float4 b) {
    return lane_by_lane(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Float4 max(Float4 a, Float4 b) {
    return lane_by_lane(a, b, [](float x, float y) { return x > y ? x : y; });
}
inline Float4 operator/(Float4 a, Float4 b) {
    return lane_by_lane(a, b, [](float x, float y) { return x / y; });
}
inline Float4 where_less(Float4 a, Float4 b, Float4 yes, Float4 no) {
    for (std::size_t i = 0; i < 4; ++i)
        if (a.v[i] < b.v[i]) no.v[i] = yes.v[i];
    return no;
}
inline int less_mask(Float4 a, Float4 b) {
    int mask = 0;
    for (std::size_t i = 0; i < 4; ++i) mask |= int(a.v[i] < b.v[i]) << i;
    return mask;
}
inline Float4 rotated(Float4 a) { return Float4({a.v[1], a.v[2], a.v[3], a.v[0]}); }
inline void transpose(Float4& a, Float4& b, Float4& c, Float4& d) {
    Float4* const rows[4] = {&a, &b, &c, &d};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t k = 0; k < i; ++k) std::swap(rows[i]->v[k], rows[k]->v[i]);
}
inline void store_truncated(Float4 a, int* p) {
    for (std::size_t i = 0; i < 4; ++i)
        p[i] = a.v[i] > -2147483648.0f && a.v[i] < 2147483648.0f ? int(a.v[i]) : std::numeric_limits<int>::min();
}
inline float half_area(Float4 e) { return e.v[0] * e.v[1] + e.v[1] * e.v[2] + e.v[2] * e.v[0]; }

#endif

inline std::array<float, 4> lanes_of(Float4 a) {
    alignas(16) std::array<float, 4> lanes;
    a.store(lanes.data());
    return lanes;
}

// A box; empty: lower +∞, upper −∞.
struct Bounds {
    Float4 lower = Float4(std::numeric_limits<float>::infinity());
    Float4 upper = Float4(-std::numeric_limits<float>::infinity());

    void extend(const Bounds& other) {
        lower = min(lower, other.lower);
        upper = max(upper, other.upper);
    }
    void extend(Float4 point) {
        lower = min(lower, point);
        upper = max(upper, point);
    }
    float half_area() const { return spinel::half_area(upper - lower); }  // NaN if empty
};

// With anything in the idle lanes.
inline Bounds bounds_of(const Box& box) {
    static_assert(sizeof(Box) == 6 * sizeof(float));
    return {Float4::load_anywhere(&box.lower.x), rotated(Float4::load_anywhere(&box.lower.z))};
}

}  // namespace spinel
