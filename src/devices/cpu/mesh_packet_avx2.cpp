// Eight coherent rays against a wide hierarchy: they go down the tree together, so that a node is loaded and its
// children are sorted once for all.
//
// A node's eight boxes are asked at once about the frustum that holds all rays (bounds of where they enter and leave by
// interval arithmetic, as Reshetov, Soupikov, Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005), and of the
// boxes that it meets each about the eight rays at once. Boxes decide only what is looked at, triangles are tested by
// the operations of the walk of one ray: so the answer is its answer, bit for bit.
//
// Most nodes have one child or two that the rays meet, and which those are is guessed well by the processor. So they
// are taken by branches: what waits for the outcome of a box test, as conditional moves do, waits for it at every
// level.

#include <bit>
#include <cstddef>

#include "devices/cpu/mesh_packet_leaf_avx2.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_BEGIN

namespace spinel {

WideHit wide_closest_avx2(const WideMesh& mesh, const kernels::Ray& ray);  // mesh_walk_avx2.cpp
bool wide_any_avx2(const WideMesh& mesh, const kernels::Ray& ray);

namespace {

using kernels::Ray;
using namespace wide;

// A child still to visit, by the rays that meet its box.
struct Entry {
    std::uint32_t reference;
    float enter;
    unsigned lanes;
};

// Of any hit, rays that have met something ask no more.
template <bool any>
SPINEL_INLINE void walk_together(const WideMesh& mesh, const Packet& p, unsigned asking, Nearest& best) {
    const kernels::WideUnit* const units = mesh.units;
    __m256 t_max = _mm256_load_ps(best.t), last_t_max = greatest(t_max);
    Entry stack[kernels::WIDE_STACK_SIZE];
    Entry* top = stack;
    std::uint32_t reference = 0;
    unsigned lanes = asking;
    for (;;) {
        unsigned met = 0;
        if (reference > unit_mask) {
            met = test_leaf<any>(units, reference, p, lanes, best);
        } else {
            const float* const node = units[reference].lanes;
            const std::uint32_t* const references = references_of(node);
            __m256 enter;
            unsigned hit = frustum_boxes(node, p, last_t_max, enter);
            if (hit) {
                alignas(32) float enters[8];
                _mm256_store_ps(enters, enter);
                Entry* const first = top;
                do {
                    // Of any hit the most promising children stand first (accel/wide_bvh.cpp), so that they come last.
                    const int i = any ? 31 - std::countl_zero(hit) : std::countr_zero(hit);
                    hit &= ~(1u << i);
                    const unsigned inside = rays_in_box(node, i, p, t_max) & lanes;
                    if (!inside) continue;
                    prefetch(units, references[i]);
                    Entry* at = top++;
                    for (; !any && at > first && at[-1].enter < enters[i]; --at) *at = at[-1];
                    *at = {references[i], enters[i], inside};
                } while (hit);
                if (top != first) {
                    --top;
                    reference = top->reference;
                    lanes = top->lanes;
                    continue;
                }
            }
        }
        if (met) {
            best.found |= met;
            if constexpr (any) {
                asking &= ~met;
                if (!asking) return;
            } else {
                t_max = _mm256_load_ps(best.t);
                last_t_max = greatest(t_max);
            }
        }
        do {
            if (top == stack) return;
            --top;
            reference = top->reference;
            lanes = top->lanes;
            if constexpr (any) lanes &= asking;
            else lanes &= lanes_of(_mm256_cmp_ps(_mm256_set1_ps(top->enter), t_max, _CMP_LE_OQ));
        } while (!lanes);
    }
}

// Rays that are not asked for repeat one that is.
SPINEL_INLINE RayColumns asked_columns(const Ray* rays, unsigned lanes) {
    if (lanes == 255) return ray_columns(rays);
    Ray filled[packet_size];
    for (int i = 0; i < packet_size; ++i) filled[i] = rays[lanes >> i & 1 ? i : std::countr_zero(lanes)];
    return ray_columns(filled);
}

SPINEL_INLINE void write_hits(const kernels::WideUnit* units, const Nearest& best, WideHit* hits) {
    static_assert(offsetof(WideHit, block) == 16);  // t, u, v and the triangle stand in a row
    const __m256 found = float_columns(lane_mask(best.found));
    const __m256 none = float_columns(_mm256_set1_epi32(int(kernels::NONE)));
    const __m256 t = _mm256_load_ps(best.t), u = _mm256_load_ps(best.u), v = _mm256_load_ps(best.v);
    const __m256 triangle =
        _mm256_blendv_ps(none, _mm256_load_ps(reinterpret_cast<const float*>(best.triangle)), found);
    const __m256 tu_low = _mm256_unpacklo_ps(t, u), tu_high = _mm256_unpackhi_ps(t, u);
    const __m256 vi_low = _mm256_unpacklo_ps(v, triangle), vi_high = _mm256_unpackhi_ps(v, triangle);
    const __m256 rows[4] = {_mm256_shuffle_ps(tu_low, vi_low, _MM_SHUFFLE(1, 0, 1, 0)),
                            _mm256_shuffle_ps(tu_low, vi_low, _MM_SHUFFLE(3, 2, 3, 2)),
                            _mm256_shuffle_ps(tu_high, vi_high, _MM_SHUFFLE(1, 0, 1, 0)),
                            _mm256_shuffle_ps(tu_high, vi_high, _MM_SHUFFLE(3, 2, 3, 2))};
    for (int i = 0; i < 4; ++i) {
        _mm_storeu_ps(&hits[i].t, _mm256_castps256_ps128(rows[i]));
        _mm_storeu_ps(&hits[i + 4].t, _mm256_extractf128_ps(rows[i], 1));
    }
    for (int i = 0; i < packet_size; ++i) {
        hits[i].block = best.found >> i & 1 ? units[best.place[i] >> 2].lanes : nullptr;
        hits[i].lane = int(best.place[i] & 3);
    }
}

}  // namespace

void wide_closest8_avx2(const WideMesh& mesh, const Ray* rays, unsigned lanes, WideHit* hits) {
    if (!lanes) return;
    const RayColumns ray = asked_columns(rays, lanes);
    Packet packet;
    if (std::has_single_bit(lanes) || !make_packet(mesh, ray, packet)) {
        for (unsigned rest = lanes; rest; rest &= rest - 1) {
            const int i = std::countr_zero(rest);
            hits[i] = wide_closest_avx2(mesh, rays[i]);
        }
        return;
    }
    Nearest best = {};
    _mm256_store_ps(best.t, ray.t_max);
    walk_together<false>(mesh, packet, lanes, best);
    if (lanes == 255) return write_hits(mesh.units, best, hits);
    WideHit all[packet_size];
    write_hits(mesh.units, best, all);
    for (unsigned rest = lanes; rest; rest &= rest - 1) hits[std::countr_zero(rest)] = all[std::countr_zero(rest)];
}

unsigned wide_any8_avx2(const WideMesh& mesh, const Ray* rays, unsigned lanes) {
    if (!lanes) return 0;
    const RayColumns ray = asked_columns(rays, lanes);
    Packet packet;
    if (std::has_single_bit(lanes) || !make_packet(mesh, ray, packet)) {
        unsigned found = 0;
        for (unsigned rest = lanes; rest; rest &= rest - 1) {
            const int i = std::countr_zero(rest);
            found |= unsigned(wide_any_avx2(mesh, rays[i])) << i;
        }
        return found;
    }
    Nearest best;
    best.found = 0;
    _mm256_store_ps(best.t, ray.t_max);
    walk_together<true>(mesh, packet, lanes, best);
    return best.found;
}

}  // namespace spinel

SPINEL_AVX2_END
#endif
