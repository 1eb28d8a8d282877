#pragma once
// Eight coherent rays of a packet (mesh_packet_avx2.cpp): a column for each number of a ray, the frustum that holds
// them all, and both against boxes.

#include "devices/cpu/mesh_walk_avx2.h"
#include "devices/cpu/ray_columns.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_BEGIN

namespace spinel::wide {

struct PacketAxis {
    __m256 inverse, near_offset, far_offset;  // of each ray, as SlabAxis
    std::size_t near_row, far_row;
};

// Where planes are met at the earliest and at the latest by any ray, for each axis as SlabAxis (the fourth is unused).
struct Frustum {
    alignas(16) float near_inverse[4], near_offset[4], far_inverse[4], far_offset[4];
    float t_min;
};

struct Packet {
    PacketAxis axes[3];
    Frustum frustum;
    __m256 t_min;
    __m256 origin_x, origin_y, origin_z, shear_x, shear_y, shear_z;  // kernels::TriangleRay of each ray
    std::size_t x, y, z;                                             // rows of the first vertex in a block, in floats
};

// In lane k what is left of column k's lanes.
template <class Take>
SPINEL_INLINE __m256 reduced(const __m256 column[8], const Take& take) {
    const auto half = [&](__m256 a, __m256 b, __m256 c, __m256 d) __attribute__((always_inline)) {
        const __m256 ab = take(_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
        const __m256 cd = take(_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
        return take(_mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(1, 0, 1, 0)),
                    _mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(3, 2, 3, 2)));
    };
    const __m256 low = half(column[0], column[1], column[2], column[3]);
    const __m256 high = half(column[4], column[5], column[6], column[7]);
    return take(_mm256_permute2f128_ps(low, high, 0x20), _mm256_permute2f128_ps(low, high, 0x31));
}

// In all lanes.
SPINEL_INLINE __m256 greatest(__m256 x) {
    x = _mm256_max_ps(x, _mm256_permute2f128_ps(x, x, 1));
    x = _mm256_max_ps(x, _mm256_permute_ps(x, _MM_SHUFFLE(1, 0, 3, 2)));
    return _mm256_max_ps(x, _mm256_permute_ps(x, _MM_SHUFFLE(2, 3, 0, 1)));
}

SPINEL_INLINE __m256 negative(__m256 x) { return _mm256_xor_ps(x, _mm256_set1_ps(-0.0f)); }
SPINEL_INLINE __m128 negative(__m128 x) { return _mm_xor_ps(x, _mm_set1_ps(-0.0f)); }
using spinel::magnitude;
SPINEL_INLINE __m128 magnitude(__m128 x) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), x); }

// kernels::slab_padding(), not less than that of any origin between `least` and `greatest`.
SPINEL_INLINE float packet_padding(const WideMesh& mesh, __m128 least, __m128 greatest) {
    const __m128 lower = _mm_setr_ps(mesh.lower.x, mesh.lower.y, mesh.lower.z, 0);
    const __m128 upper = _mm_setr_ps(mesh.upper.x, mesh.upper.y, mesh.upper.z, 0);
    const auto away = [&](__m128 o) __attribute__((always_inline)) {
        return _mm_max_ps(magnitude(_mm_sub_ps(lower, o)), magnitude(_mm_sub_ps(upper, o)));
    };
    const __m128 far = _mm_max_ps(away(least), away(greatest));
    const __m128 origin = _mm_max_ps(magnitude(least), magnitude(greatest));
    const __m128 xy = _mm_unpacklo_ps(far, origin), z = _mm_unpackhi_ps(far, origin);
    const __m128 both = _mm_max_ps(_mm_max_ps(xy, z), _mm_movehl_ps(xy, xy));
    return 1.9073486e-6f * _mm_cvtss_f32(both) + 2.3841858e-7f * _mm_cvtss_f32(_mm_movehdup_ps(both));
}

// False: the rays are of different octants, or otherwise no packet.
SPINEL_INLINE bool make_packet(const WideMesh& mesh, const RayColumns& ray, Packet& p) {
    const __m256 size[3] = {magnitude(ray.direction[0]), magnitude(ray.direction[1]), magnitude(ray.direction[2])};
    // As kernels::triangle_ray().
    const unsigned x_first = lanes_of(
        _mm256_and_ps(_mm256_cmp_ps(size[0], size[1], _CMP_GE_OQ), _mm256_cmp_ps(size[0], size[2], _CMP_GE_OQ)));
    const unsigned y_first = lanes_of(_mm256_cmp_ps(size[1], size[2], _CMP_GE_OQ)) & ~x_first;
    if ((x_first != 0 && x_first != 255) || (y_first != 0 && y_first != 255)) return false;
    const int axis = x_first ? 0 : y_first ? 1 : 2;
    const __m256 longest = size[axis];
    // So that nothing overflows below. Comparisons that fail for what is no number.
    const __m256 huge = _mm256_set1_ps(1e9f);
    const auto sum = [](__m256 x, __m256 y, __m256 z) __attribute__((always_inline)) {
        return _mm256_add_ps(_mm256_add_ps(x, y), z);
    };
    const __m256 reach = sum(magnitude(ray.origin[0]), magnitude(ray.origin[1]), magnitude(ray.origin[2]));
    const __m256 usable = _mm256_and_ps(_mm256_and_ps(_mm256_cmp_ps(reach, huge, _CMP_LT_OQ),
                                                      _mm256_cmp_ps(sum(size[0], size[1], size[2]), huge, _CMP_LT_OQ)),
                                        _mm256_and_ps(_mm256_cmp_ps(longest, _mm256_set1_ps(1e-20f), _CMP_GT_OQ),
                                                      _mm256_cmp_ps(ray.t_min, _mm256_setzero_ps(), _CMP_GE_OQ)));
    if (lanes_of(usable) != 255) return false;

    const __m256 tiny = _mm256_mul_ps(longest, _mm256_set1_ps(1e-8f)), sign = _mm256_set1_ps(-0.0f);
    for (int a = 0; a < 3; ++a) {
        const unsigned signs = lanes_of(ray.direction[a]);
        if (signs != 0 && signs != 255) return false;
        const __m256 d = _mm256_or_ps(_mm256_max_ps(size[a], tiny), _mm256_and_ps(ray.direction[a], sign));
        p.axes[a].inverse = _mm256_div_ps(_mm256_set1_ps(1), d);
        p.axes[a].near_row = (2 * std::size_t(a) + (signs & 1)) * 8;
        p.axes[a].far_row = (2 * std::size_t(a) + 1 - (signs & 1)) * 8;
    }

    const __m256 columns[8] = {ray.origin[0],     ray.origin[1],     ray.origin[2],     ray.t_min,
                               p.axes[0].inverse, p.axes[1].inverse, p.axes[2].inverse, ray.t_min};
    const __m256 all_least = reduced(columns, [](__m256 a, __m256 b) { return _mm256_min_ps(a, b); });
    const __m256 all_greatest = reduced(columns, [](__m256 a, __m256 b) { return _mm256_max_ps(a, b); });
    const __m128 origin_least = _mm256_castps256_ps128(all_least);
    const __m128 origin_greatest = _mm256_castps256_ps128(all_greatest);
    const __m128 inverse_least = _mm256_extractf128_ps(all_least, 1);
    const __m128 inverse_greatest = _mm256_extractf128_ps(all_greatest, 1);
    const float padding = packet_padding(mesh, origin_least, origin_greatest);
    if (!(padding < 1e3f)) return false;

    for (PacketAxis& s : p.axes) {
        const __m256 offset = _mm256_mul_ps(negative(ray.origin[&s - p.axes]), s.inverse);
        const __m256 wider = _mm256_mul_ps(_mm256_set1_ps(padding), magnitude(s.inverse));
        s.near_offset = _mm256_sub_ps(offset, wider);
        s.far_offset = _mm256_add_ps(offset, wider);
    }

    // No ray is nearer to a plane than from one of these corners, nor meets it earlier than by one of these inverses;
    // nor later. (Of planes behind, which do not count, this is not true.)
    const __m128 lower = _mm_sub_ps(origin_least, _mm_set1_ps(padding));
    const __m128 upper = _mm_add_ps(origin_greatest, _mm_set1_ps(padding));
    const __m128 backward = inverse_least;  // its signs
    const __m128 near_inverse = _mm_blendv_ps(inverse_least, inverse_greatest, backward);
    const __m128 far_inverse = _mm_blendv_ps(inverse_greatest, inverse_least, backward);
    _mm_store_ps(p.frustum.near_inverse, near_inverse);
    _mm_store_ps(p.frustum.far_inverse, far_inverse);
    _mm_store_ps(p.frustum.near_offset, _mm_mul_ps(negative(_mm_blendv_ps(upper, lower, backward)), near_inverse));
    _mm_store_ps(p.frustum.far_offset, _mm_mul_ps(negative(_mm_blendv_ps(lower, upper, backward)), far_inverse));
    p.frustum.t_min = _mm_cvtss_f32(_mm_permute_ps(origin_least, 3));

    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    const __m256 s = p.axes[axis].inverse;  // of the longest component, which is the direction's own
    p.t_min = ray.t_min;
    p.origin_x = ray.origin[next];
    p.origin_y = ray.origin[last];
    p.origin_z = ray.origin[axis];
    p.shear_x = _mm256_mul_ps(negative(ray.direction[next]), s);
    p.shear_y = _mm256_mul_ps(negative(ray.direction[last]), s);
    p.shear_z = s;
    p.x = std::size_t(next) * 4;
    p.y = std::size_t(last) * 4;
    p.z = std::size_t(axis) * 4;
    return true;
}

// The children whose boxes the frustum meets, and where it enters each.
SPINEL_INLINE unsigned frustum_boxes(const float* node, const Packet& p, __m256 last_t_max, __m256& enter) {
    const Frustum& f = p.frustum;
    const auto near = [&](int a) __attribute__((always_inline)) {
        return _mm256_fmadd_ps(_mm256_load_ps(node + p.axes[a].near_row), _mm256_broadcast_ss(f.near_inverse + a),
                               _mm256_broadcast_ss(f.near_offset + a));
    };
    const auto far = [&](int a) __attribute__((always_inline)) {
        return _mm256_fmadd_ps(_mm256_load_ps(node + p.axes[a].far_row), _mm256_broadcast_ss(f.far_inverse + a),
                               _mm256_broadcast_ss(f.far_offset + a));
    };
    enter = _mm256_max_ps(_mm256_max_ps(near(0), _mm256_broadcast_ss(&f.t_min)), _mm256_max_ps(near(1), near(2)));
    const __m256 leave = _mm256_min_ps(_mm256_min_ps(far(0), last_t_max), _mm256_min_ps(far(1), far(2)));
    return lanes_of(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ));
}

// The rays that meet the box of child i.
SPINEL_INLINE unsigned rays_in_box(const float* node, int i, const Packet& p, __m256 t_max) {
    const auto near = [&](int a) __attribute__((always_inline)) {
        return _mm256_fmadd_ps(_mm256_broadcast_ss(node + p.axes[a].near_row + i), p.axes[a].inverse,
                               p.axes[a].near_offset);
    };
    const auto far = [&](int a) __attribute__((always_inline)) {
        return _mm256_fmadd_ps(_mm256_broadcast_ss(node + p.axes[a].far_row + i), p.axes[a].inverse,
                               p.axes[a].far_offset);
    };
    const __m256 enter = _mm256_max_ps(_mm256_max_ps(near(0), p.t_min), _mm256_max_ps(near(1), near(2)));
    const __m256 leave = _mm256_min_ps(_mm256_min_ps(far(0), t_max), _mm256_min_ps(far(1), far(2)));
    return lanes_of(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ));
}

}  // namespace spinel::wide

SPINEL_AVX2_END
#endif
