#pragma once
// The compact layout (kernels/mesh_compact.h) for the walk of one ray with AVX2. Planes are the floats that the kernel
// gets. The vertices of a block are sheared once and then dealt out to the triangles' corners, which is why as many as
// a register has lanes may be in one.

#include "devices/cpu/mesh_walk_avx2.h"
#include "kernels/mesh_compact.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_BEGIN

namespace spinel::wide {

struct Compact {
    // kernels::TriangleRay for a block.
    struct Shear {
        __m256 origin_x, origin_y, origin_z;
        __m256 shear_x, shear_y, shear_z;
        std::size_t x, y, z;  // rows of a block
    };

    static SPINEL_INLINE Shear make_shear(const Ray& ray) {
        const kernels::TriangleRay r = kernels::triangle_ray(ray);
        const glm::vec3 o = kernels::turned(ray.origin, r.axis);
        return {_mm256_set1_ps(o.x),       _mm256_set1_ps(o.y),       _mm256_set1_ps(o.z),
                _mm256_set1_ps(r.shear.x), _mm256_set1_ps(r.shear.y), _mm256_set1_ps(r.shear.z),
                (r.axis + 1) % 3,          (r.axis + 2) % 3,          r.axis};
    }

    static SPINEL_INLINE const float* at(const kernels::WideUnit* units, std::uint32_t place) {
        return units->lanes + std::size_t(place) * kernels::COMPACT_STEP;
    }
    static SPINEL_INLINE const std::uint32_t* references_of(const float* node) {
        return reinterpret_cast<const std::uint32_t*>(node + 16);  // bits of integers in lanes of floats
    }
    static SPINEL_INLINE void prefetch(const kernels::WideUnit* units, std::uint32_t reference) {
        const char* p = reinterpret_cast<const char*>(at(units, reference & unit_mask));
        _mm_prefetch(p, _MM_HINT_T0);
        _mm_prefetch(p + 64, _MM_HINT_T0);
    }

    static SPINEL_INLINE unsigned hit_boxes(const float* node, const Slabs& s, __m256 t_max, __m256& enter) {
        const std::uint32_t packed = std::bit_cast<std::uint32_t>(node[3]);
        const __m256i all = _mm256_set1_epi32(int(packed)), exponent = _mm256_set1_epi32(0x7f800000);
        const __m256 step_x = _mm256_castsi256_ps(_mm256_and_si256(_mm256_slli_epi32(all, 23), exponent));
        const __m256 step_y = _mm256_castsi256_ps(_mm256_and_si256(_mm256_slli_epi32(all, 15), exponent));
        const __m256 step_z = _mm256_castsi256_ps(_mm256_and_si256(_mm256_slli_epi32(all, 7), exponent));
        const __m256 x = _mm256_broadcast_ss(node), y = _mm256_broadcast_ss(node + 1),
                     z = _mm256_broadcast_ss(node + 2);
        const char* const bytes = reinterpret_cast<const char*>(node + 4);
        const auto t_of = [&](std::size_t row, __m256 step, __m256 corner, __m256 inverse, __m256 offset)
            __attribute__((always_inline)) {
            const __m128i steps = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(bytes + row));
            const __m256 plane = _mm256_fmadd_ps(_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(steps)), step, corner);
            return _mm256_fmadd_ps(plane, inverse, offset);
        };
        enter = _mm256_max_ps(_mm256_max_ps(t_of(s.x.near_row, step_x, x, s.x.inverse, s.x.near_offset), s.t_min),
                              _mm256_max_ps(t_of(s.y.near_row, step_y, y, s.y.inverse, s.y.near_offset),
                                            t_of(s.z.near_row, step_z, z, s.z.inverse, s.z.near_offset)));
        const __m256 leave =
            _mm256_min_ps(_mm256_min_ps(t_of(s.x.far_row, step_x, x, s.x.inverse, s.x.far_offset), t_max),
                          _mm256_min_ps(t_of(s.y.far_row, step_y, y, s.y.inverse, s.y.far_offset),
                                        t_of(s.z.far_row, step_z, z, s.z.inverse, s.z.far_offset)));
        return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ))) & packed >> 24;
    }

    struct Block {
        LaneHits hits;
        std::uint32_t triangles, vertices;
    };

    static SPINEL_INLINE Block test_block(const float* block, const Shear& s, __m256 t_min, __m256 t_max) {
        const std::uint32_t header = std::bit_cast<std::uint32_t>(block[0]);
        const std::uint32_t triangles = header & 255, vertices = header >> 8;
        const __m256i a = _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(block + 1)));
        const __m256i b = _mm256_srli_epi32(a, 3), c = _mm256_srli_epi32(a, 6);  // of which three bits count
        const float* const rows = block + kernels::compact_rows(triangles);
        const __m256 z = _mm256_sub_ps(_mm256_loadu_ps(rows + s.z * vertices), s.origin_z);
        const __m256 x =
            _mm256_fmadd_ps(s.shear_x, z, _mm256_sub_ps(_mm256_loadu_ps(rows + s.x * vertices), s.origin_x));
        const __m256 y =
            _mm256_fmadd_ps(s.shear_y, z, _mm256_sub_ps(_mm256_loadu_ps(rows + s.y * vertices), s.origin_y));
        const auto heights = [&]() __attribute__((always_inline)) {
            const __m256 height = _mm256_mul_ps(s.shear_z, z);
            return Heights{_mm256_permutevar8x32_ps(height, a), _mm256_permutevar8x32_ps(height, b),
                           _mm256_permutevar8x32_ps(height, c)};
        };
        return {
            hit_lanes(_mm256_permutevar8x32_ps(x, a), _mm256_permutevar8x32_ps(y, a), _mm256_permutevar8x32_ps(x, b),
                      _mm256_permutevar8x32_ps(y, b), _mm256_permutevar8x32_ps(x, c), _mm256_permutevar8x32_ps(y, c),
                      (1u << triangles) - 1, heights, t_min, t_max),
            triangles, vertices};
    }

    template <bool any>
    static SPINEL_INLINE bool test_leaf(const float* block, std::uint32_t blocks, const Shear& shear, __m256 t_min,
                                        __m256 t_max, Best& best) {
        bool nearer = false;
        do {
            const Block b = test_block(block, shear, t_min, any ? t_max : _mm256_set1_ps(best.t));
            const float* const indices = block + kernels::compact_indices(b.triangles, b.vertices);
            if (b.hits.lanes) {
                if constexpr (any) {
                    if (b.hits.lanes & unsigned(_mm256_movemask_ps(_mm256_cmp_ps(b.hits.t, t_max, _CMP_LT_OQ))))
                        return true;
                } else {
                    nearer |= take_nearest(b.hits, block, indices, best);
                }
            }
            block = indices + b.triangles;
        } while (--blocks);
        return nearer;
    }

    static SPINEL_INLINE bool take_nearest(const LaneHits& hits, const float* block, const float* indices, Best& best) {
        alignas(32) float t[8], u[8], v[8];
        _mm256_store_ps(t, hits.t);
        _mm256_store_ps(u, hits.u);
        _mm256_store_ps(v, hits.v);
        bool nearer = false;
        for (unsigned rest = hits.lanes; rest; rest &= rest - 1) {
            const int i = std::countr_zero(rest);
            const auto triangle = std::bit_cast<std::uint32_t>(indices[i]);
            if (!(t[i] < best.t) && !(t[i] == best.t && triangle < best.triangle)) continue;
            best = {t[i], u[i], v[i], triangle, true, block, i};
            nearer = true;
        }
        return nearer;
    }
};

}  // namespace spinel::wide

SPINEL_AVX2_END
#endif
