#pragma once
// Rays of a packet (mesh_packet_avx2.cpp) against the triangles of a leaf: all eight against one after the other, in
// the operations of the walk of one ray. Nothing is to be chosen among four triangles then, and what a hit changes are
// whole columns. (Measured: even where few rays are left, two of them against four triangles at a time are no better.)

#include "devices/cpu/mesh_packet_rays_avx2.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_BEGIN

namespace spinel::wide {

// The nearest hits so far.
struct Nearest {
    alignas(32) float t[8], u[8], v[8];
    alignas(32) std::uint32_t triangle[8];  // 0 as long as there is none: at t_max itself nothing is nearer then
    alignas(32) std::uint32_t place[8];     // four times the unit at which the block begins, and the lane in it
    unsigned found;
};

// wide::hit_triangles() of triangle i of a block, for rays in `asked`.
SPINEL_INLINE LaneHits hit_triangle(const float* block, int i, const Packet& p, unsigned asked, __m256 t_max) {
    const auto from = [&](const float* row, __m256 origin) __attribute__((always_inline)) {
        return _mm256_sub_ps(_mm256_broadcast_ss(row + i), origin);
    };
    const float *const px = block + p.x, *const py = block + p.y, *const pz = block + p.z;
    const __m256 az = from(pz, p.origin_z), bz = from(pz + 12, p.origin_z), cz = from(pz + 24, p.origin_z);
    const __m256 ax = _mm256_fmadd_ps(p.shear_x, az, from(px, p.origin_x));
    const __m256 bx = _mm256_fmadd_ps(p.shear_x, bz, from(px + 12, p.origin_x));
    const __m256 cx = _mm256_fmadd_ps(p.shear_x, cz, from(px + 24, p.origin_x));
    const __m256 ay = _mm256_fmadd_ps(p.shear_y, az, from(py, p.origin_y));
    const __m256 by = _mm256_fmadd_ps(p.shear_y, bz, from(py + 12, p.origin_y));
    const __m256 cy = _mm256_fmadd_ps(p.shear_y, cz, from(py + 24, p.origin_y));
    const auto heights = [&]() __attribute__((always_inline)) {
        return Heights{_mm256_mul_ps(p.shear_z, az), _mm256_mul_ps(p.shear_z, bz), _mm256_mul_ps(p.shear_z, cz)};
    };
    return hit_lanes(ax, ay, bx, by, cx, cy, asked, heights, p.t_min, t_max);
}

SPINEL_INLINE void replace(float* at, __m256 value, __m256 where) {
    _mm256_store_ps(at, _mm256_blendv_ps(_mm256_load_ps(at), value, where));
}
SPINEL_INLINE void replace(std::uint32_t* at, std::uint32_t value, __m256 where) {
    replace(reinterpret_cast<float*>(at), float_columns(_mm256_set1_epi32(int(value))), where);
}

SPINEL_INLINE std::uint32_t block_index(const float* block, int i) {
    return std::bit_cast<std::uint32_t>(block[36 + i]);
}

// Rays of `lanes` against a block; returns those that met something, or something nearer.
template <bool any>
SPINEL_INLINE unsigned test_block(const float* block, std::uint32_t unit, const Packet& p, unsigned lanes,
                                  Nearest& best) {
    unsigned met = 0;
    for (int i = 0; i < 4; ++i) {
        const std::uint32_t triangle = block_index(block, i);
        // The rest repeats the last.
        if (i > 0 && block_index(block, i - 1) == triangle && block_index(block, 3) == triangle) break;
        const __m256 t_max = _mm256_load_ps(best.t);
        const LaneHits hits = hit_triangle(block, i, p, lanes, t_max);
        if (!hits.lanes) continue;
        if constexpr (any) {
            met |= hits.lanes & lanes_of(_mm256_cmp_ps(hits.t, t_max, _CMP_LT_OQ));
            lanes &= ~met;
            if (!lanes) break;
        } else {
            // (Indices are below 2³¹.)
            const __m256i known = _mm256_load_si256(reinterpret_cast<const __m256i*>(best.triangle));
            const __m256 before = float_columns(_mm256_cmpgt_epi32(known, _mm256_set1_epi32(int(triangle))));
            const __m256 equal = _mm256_cmp_ps(hits.t, t_max, _CMP_EQ_OQ);
            const __m256 nearer =
                _mm256_and_ps(float_columns(lane_mask(hits.lanes)),
                              _mm256_or_ps(_mm256_cmp_ps(hits.t, t_max, _CMP_LT_OQ), _mm256_and_ps(equal, before)));
            replace(best.t, hits.t, nearer);
            replace(best.u, hits.u, nearer);
            replace(best.v, hits.v, nearer);
            replace(best.triangle, triangle, nearer);
            replace(best.place, 4 * unit + std::uint32_t(i), nearer);
            met |= lanes_of(nearer);
        }
    }
    return met;
}

// The same for all blocks of a leaf.
template <bool any>
SPINEL_INLINE unsigned test_leaf(const kernels::WideUnit* units, std::uint32_t reference, const Packet& p,
                                 unsigned lanes, Nearest& best) {
    unsigned met = 0;
    std::uint32_t unit = reference & unit_mask;
    for (std::uint32_t blocks = reference >> reference_bits; blocks; --blocks, unit += kernels::WIDE_BLOCK_UNITS) {
        const float* const block = units[unit].lanes;
        met |= test_block<any>(block, unit, p, lanes, best);
        if constexpr (any) lanes &= ~met;
    }
    return met;
}

}  // namespace spinel::wide

SPINEL_AVX2_END
#endif
