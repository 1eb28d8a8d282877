#pragma once
// Eight rays in AVX2 registers, a register for each number of a ray, and how they pass a box of cells.

#include <bit>
#include <cstdint>

#include "devices/cpu/avx2.h"
#include "devices/cpu/voxel_walk.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_AS_ELSEWHERE_BEGIN

namespace spinel {

struct RayColumns {
    __m256 origin[3], t_min;
    __m256 direction[3], t_max;
};

// Rays are neighbours if their directions are within this part of the longest component of the first one's, and their
// origins within so many cells.
inline constexpr float neighbour_turn = 0.125f, neighbour_cells = 16;

// Up to here whole cells can be told from rounding.
inline constexpr float farthest_exact = 1e5f, longest_direction = 1e18f;

inline __m256i int_columns(__m256 x) { return _mm256_castps_si256(x); }
inline __m256 float_columns(__m256i x) { return _mm256_castsi256_ps(x); }
inline unsigned lanes_of(__m256 mask) { return unsigned(_mm256_movemask_ps(mask)); }
inline unsigned lanes_of(__m256i mask) { return lanes_of(float_columns(mask)); }
inline __m256 all_lanes() { return float_columns(_mm256_set1_epi32(-1)); }
inline __m256 front(__m256 x) { return _mm256_broadcastss_ps(_mm256_castps256_ps128(x)); }
inline __m256 magnitude(__m256 x) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), x); }

// Four columns of the rays' members from `at` on.
inline void load_columns(const float* at, __m256 column[4]) {
    constexpr int stride = sizeof(kernels::Ray) / sizeof(float);
    static_assert(sizeof(kernels::Ray) == 8 * sizeof(float));
    const auto pair = [&](int i) {
        return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(at + i * stride)),
                                    _mm_loadu_ps(at + (i + 4) * stride), 1);
    };
    const __m256 a = pair(0), b = pair(1), c = pair(2), d = pair(3);
    const __m256 ab_low = _mm256_unpacklo_ps(a, b), ab_high = _mm256_unpackhi_ps(a, b);
    const __m256 cd_low = _mm256_unpacklo_ps(c, d), cd_high = _mm256_unpackhi_ps(c, d);
    column[0] = _mm256_shuffle_ps(ab_low, cd_low, _MM_SHUFFLE(1, 0, 1, 0));
    column[1] = _mm256_shuffle_ps(ab_low, cd_low, _MM_SHUFFLE(3, 2, 3, 2));
    column[2] = _mm256_shuffle_ps(ab_high, cd_high, _MM_SHUFFLE(1, 0, 1, 0));
    column[3] = _mm256_shuffle_ps(ab_high, cd_high, _MM_SHUFFLE(3, 2, 3, 2));
}

inline RayColumns ray_columns(const kernels::Ray rays[packet_size]) {
    __m256 o[4], d[4];
    load_columns(&rays[0].origin.x, o);
    load_columns(&rays[0].direction.x, d);
    return {{o[0], o[1], o[2]}, o[3], {d[0], d[1], d[2]}, d[3]};
}

// Where rays are inside of the box of a set, as kernels::voxel_ray says of each.
struct BoxPass {
    __m256 still[3];     // all ones where the direction is zero
    __m256 positive[3];  // all ones where it is above
    __m256 inverse[3];   // of the direction; where that is zero, any number
    __m256 enter[3];     // where a plane of the box is met on the way in: of all three the last is the entry
    __m256 start;        // the walk begins here …
    __m256 leave;        // … and ends here; not above `start` where the ray misses the box
    __m256 from_outside;
    __m256 reach;    // no coordinate is larger on the way through the box
    unsigned exact;  // rays near enough for whole cells to be told from rounding, and that are numbers
};

inline BoxPass pass_box(glm::ivec3 size, const RayColumns& ray, __m256 limit) {
    const __m256 infinite = _mm256_set1_ps(kernels::INFINITE);
    const __m256* const o = ray.origin;
    BoxPass p;
    const __m256 far = _mm256_max_ps(_mm256_max_ps(magnitude(o[0]), magnitude(o[1])), magnitude(o[2]));
    p.reach = _mm256_add_ps(far, _mm256_set1_ps(float(glm::max(glm::max(size.x, size.y), size.z))));
    // Comparisons that fail for what is no number.
    __m256 exact = _mm256_cmp_ps(p.reach, _mm256_set1_ps(farthest_exact), _CMP_LT_OQ);
    p.start = ray.t_min;
    p.leave = limit;
    for (int a = 0; a < 3; ++a) {
        const __m256 d = ray.direction[a];
        exact = _mm256_and_ps(exact, _mm256_cmp_ps(magnitude(d), _mm256_set1_ps(longest_direction), _CMP_LT_OQ));
        p.still[a] = _mm256_cmp_ps(magnitude(d), _mm256_set1_ps(kernels::TINY_DIRECTION), _CMP_LT_OQ);
        p.positive[a] = _mm256_andnot_ps(p.still[a], _mm256_cmp_ps(d, _mm256_setzero_ps(), _CMP_GT_OQ));
        p.inverse[a] = _mm256_div_ps(_mm256_set1_ps(1), d);
        const __m256 last = _mm256_set1_ps(float(size[a]));
        const __m256 in = _mm256_mul_ps(_mm256_sub_ps(_mm256_andnot_ps(p.positive[a], last), o[a]), p.inverse[a]);
        const __m256 out = _mm256_mul_ps(_mm256_sub_ps(_mm256_and_ps(p.positive[a], last), o[a]), p.inverse[a]);
        // Along the planes of an axis: between them for ever, or never.
        const __m256 inside =
            _mm256_and_ps(_mm256_cmp_ps(o[a], _mm256_setzero_ps(), _CMP_GE_OQ), _mm256_cmp_ps(o[a], last, _CMP_LT_OQ));
        const __m256 ever = _mm256_xor_ps(infinite, _mm256_and_ps(inside, _mm256_set1_ps(-0.0f)));
        p.enter[a] = _mm256_blendv_ps(in, ever, p.still[a]);
        p.leave = _mm256_min_ps(p.leave, _mm256_blendv_ps(out, infinite, p.still[a]));
    }
    const __m256 box = _mm256_max_ps(_mm256_max_ps(p.enter[0], p.enter[1]), p.enter[2]);
    p.from_outside = _mm256_cmp_ps(box, p.start, _CMP_GT_OQ);
    p.start = _mm256_max_ps(p.start, box);
    const __m256 nowhere = _mm256_and_ps(_mm256_and_ps(p.still[0], p.still[1]), p.still[2]);
    p.leave = _mm256_blendv_ps(p.leave, p.start, nowhere);
    p.exact = lanes_of(exact);
    return p;
}

// Of a byte for each lane, those of the lanes asked for, the first lanes first: what brings them to the front.
inline __m256i pack_order(unsigned lanes) {
    const std::uint64_t bytes = _pdep_u64(lanes, 0x0101010101010101u) * 255;
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(std::int64_t(_pext_u64(0x0706050403020100u, bytes))));
}

// The other way round: what brings the first ones to the lanes asked for.
inline __m256i spread_order(unsigned lanes) {
    const std::uint64_t bytes = _pdep_u64(lanes, 0x0101010101010101u) * 255;
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(std::int64_t(_pdep_u64(0x0706050403020100u, bytes))));
}

// All ones in the lanes asked for.
inline __m256i lane_mask(unsigned lanes) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(int(lanes)), bit), bit);
}

// As cpu_voxels_closest_stream, for machines with AVX2.
void stream_closest(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                    kernels::uint instance, std::span<const kernels::Ray> rays, kernels::Hit* hits);

}  // namespace spinel

SPINEL_AVX2_END
#endif
