// Eight coherent rays against a wide hierarchy: they go down the tree together, so that a node is loaded and its
// children are sorted once for all.
//
// A node's eight boxes are asked at once about the frustum that holds all rays (bounds of where they enter and leave by
// interval arithmetic, as Reshetov, Soupikov, Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005), and of the
// boxes that it meets each about the eight rays at once. Blocks of four triangles are tested by two rays at a time.
// Below nodes that few rays meet those go on alone. Boxes decide only what is looked at, triangles are tested by the
// operations of the walk of one ray: so the answer is its answer, bit for bit.

#include <algorithm>

#include "devices/cpu/mesh_packet_block_avx2.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_BEGIN

namespace spinel {
namespace {

using kernels::Ray;
using namespace wide;

constexpr int few = 1;  // rays that go on alone

// Ray i goes on alone.
template <bool any>
SPINEL_INLINE bool walk_alone(const WideMesh& mesh, const Slabs& slabs, const Shear& shear, std::uint32_t reference,
                              int i, Nearest& best) {
    Best one = {best.t[i], best.u[i], best.v[i], best.triangle[i], false};
    if (!walk<Gathered, any>(mesh.units, slabs, shear, reference, one)) return false;
    best.t[i] = one.t;
    best.u[i] = one.u;
    best.v[i] = one.v;
    best.triangle[i] = one.triangle;
    best.place[i] = 4 * std::uint32_t(reinterpret_cast<const kernels::WideUnit*>(one.block) - mesh.units) +
                    std::uint32_t(one.lane);
    return true;
}

SPINEL_INLINE __m256 all_lanes_as(const __m256& column, int i) {
    return _mm256_broadcast_ss(reinterpret_cast<const float*>(&column) + i);
}

// Ray i of the packet alone, with what the packet has worked out for it.
template <bool any>
SPINEL_INLINE bool walk_alone(const WideMesh& mesh, const Packet& p, std::uint32_t reference, int i, Nearest& best) {
    const auto axis = [&](const PacketAxis& a) __attribute__((always_inline)) {
        return SlabAxis{all_lanes_as(a.inverse, i), all_lanes_as(a.near_offset, i), all_lanes_as(a.far_offset, i),
                        a.near_row, a.far_row};
    };
    const auto four = [&](const __m256& column) __attribute__((always_inline)) {
        return _mm256_castps256_ps128(all_lanes_as(column, i));
    };
    const ShearColumns& s = p.shear;
    return walk_alone<any>(
        mesh, {axis(p.axes[0]), axis(p.axes[1]), axis(p.axes[2]), all_lanes_as(s.t_min, i)},
        {four(s.origin_x), four(s.origin_y), four(s.origin_z), four(s.shear_x), four(s.shear_y), four(s.shear_z), p.x,
         p.y, p.z},
        reference, i, best);
}

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
        if (std::popcount(lanes) <= few) {
            for (unsigned rest = lanes; rest; rest &= rest - 1) {
                const int i = std::countr_zero(rest);
                met |= unsigned(walk_alone<any>(mesh, p, reference, i, best)) << i;
            }
        } else if (reference > unit_mask) {
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

template <bool any>
SPINEL_INLINE void walk8(const WideMesh& mesh, const Ray* rays, unsigned lanes, Nearest& best) {
    best.found = 0;
    if (!lanes) return;
    Ray filled[packet_size];
    if (lanes != 255) {  // rays that are not asked for repeat one that is
        for (int i = 0; i < packet_size; ++i) filled[i] = rays[lanes >> i & 1 ? i : std::countr_zero(lanes)];
        rays = filled;
    }
    for (int i = 0; i < 8; ++i) best.t[i] = rays[i].t_max;
    std::fill_n(best.triangle, 8, 0u);
    Packet packet;
    if (std::popcount(lanes) > few && make_packet(mesh, rays, packet))
        return walk_together<any>(mesh, packet, lanes, best);
    for (unsigned rest = lanes; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        best.found |= unsigned(walk_alone<any>(mesh, make_slabs(mesh, rays[i]), make_shear(rays[i]), 0, i, best)) << i;
    }
}

}  // namespace

void wide_closest8_avx2(const WideMesh& mesh, const Ray* rays, unsigned lanes, WideHit* hits) {
    Nearest best;
    walk8<false>(mesh, rays, lanes, best);
    for (unsigned rest = lanes; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        if (best.found >> i & 1)
            hits[i] = {best.t[i], best.u[i], best.v[i], best.triangle[i], mesh.units[best.place[i] >> 2].lanes, int(best.place[i] & 3)};
        else hits[i] = {rays[i].t_max, 0, 0, kernels::NONE};
    }
}

unsigned wide_any8_avx2(const WideMesh& mesh, const Ray* rays, unsigned lanes) {
    Nearest best;
    walk8<true>(mesh, rays, lanes, best);
    return best.found;
}

}  // namespace spinel

SPINEL_AVX2_END
#endif
