// Eight coherent rays against a wide hierarchy: they go down the tree together, so that a node is loaded and its
// children are sorted once for all.
//
// A node's eight boxes are asked at once about the frustum that holds all rays (bounds of where they enter and leave by
// interval arithmetic, as Reshetov, Soupikov, Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005), and of the
// boxes that it meets each about the eight rays at once. Blocks of four triangles are tested by two rays at a time.
// Below nodes that few rays meet those go on alone. Boxes decide only what is looked at, triangles are tested by the
// operations of the walk of one ray: so the answer is its answer, bit for bit.

#include <algorithm>

#include "devices/cpu/mesh_walk_avx2.h"
#include "devices/cpu/ray_columns.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_BEGIN

namespace spinel {
namespace {

using kernels::Ray;
using namespace wide;

constexpr int few = 1;  // rays that go on alone

SPINEL_INLINE __m256 greatest_of_pairs(__m256 x) {
    x = _mm256_max_ps(x, _mm256_permute2f128_ps(x, x, 1));
    x = _mm256_max_ps(x, _mm256_permute_ps(x, _MM_SHUFFLE(1, 0, 3, 2)));
    return _mm256_max_ps(x, _mm256_permute_ps(x, _MM_SHUFFLE(2, 3, 0, 1)));
}
SPINEL_INLINE __m256 negative(__m256 x) { return _mm256_xor_ps(x, _mm256_set1_ps(-0.0f)); }
// In all lanes.
SPINEL_INLINE __m256 greatest(__m256 x) { return greatest_of_pairs(x); }
SPINEL_INLINE __m256 least(__m256 x) { return negative(greatest_of_pairs(negative(x))); }

struct PacketAxis {
    __m256 inverse, near_offset, far_offset;  // of each ray, as SlabAxis
    // Of the frustum: no ray is nearer to a plane than from this origin, nor meets it earlier than by this inverse; nor
    // later.
    __m256 near_origin, near_inverse, far_origin, far_inverse;
    std::size_t near_row, far_row;
};

struct Packet {
    PacketAxis axes[3];
    __m256 t_min, first_t_min;
    struct Pair {
        __m256 origin_x, origin_y, origin_z, shear_x, shear_y, shear_z, t_min;
    } pairs[4];
    std::size_t x, y, z;  // rows of the first vertex in a block, in floats
};

// Each lane of either half from the same ray.
SPINEL_INLINE __m256 pair_of(const float* column, int pair) {
    return _mm256_set_m128(_mm_set1_ps(column[2 * pair + 1]), _mm_set1_ps(column[2 * pair]));
}

// False: the rays are of different octants, or otherwise no packet.
SPINEL_INLINE bool make_packet(const WideMesh& mesh, const Ray* rays, Packet& p) {
    const RayColumns ray = ray_columns(rays);
    const __m256 zero = _mm256_setzero_ps();
    __m256 size[3], padding_far = zero, padding_origin = zero;
    for (int a = 0; a < 3; ++a) {
        const __m256 o = ray.origin[a];
        size[a] = magnitude(ray.direction[a]);
        padding_far = _mm256_max_ps(padding_far, magnitude(_mm256_sub_ps(_mm256_set1_ps(mesh.lower[a]), o)));
        padding_far = _mm256_max_ps(padding_far, magnitude(_mm256_sub_ps(_mm256_set1_ps(mesh.upper[a]), o)));
        padding_origin = _mm256_max_ps(padding_origin, magnitude(o));
    }
    // As kernels::triangle_ray().
    const unsigned x_first = lanes_of(
        _mm256_and_ps(_mm256_cmp_ps(size[0], size[1], _CMP_GE_OQ), _mm256_cmp_ps(size[0], size[2], _CMP_GE_OQ)));
    const unsigned y_first = lanes_of(_mm256_cmp_ps(size[1], size[2], _CMP_GE_OQ)) & ~x_first;
    if ((x_first != 0 && x_first != 255) || (y_first != 0 && y_first != 255)) return false;
    const int axis = x_first ? 0 : y_first ? 1 : 2;
    const __m256 longest = size[axis];
    // Comparisons that fail for what is no number.
    const __m256 huge = _mm256_set1_ps(1e30f);
    const __m256 usable = _mm256_and_ps(
        _mm256_and_ps(_mm256_cmp_ps(_mm256_add_ps(padding_far, padding_origin), huge, _CMP_LT_OQ),
                      _mm256_cmp_ps(_mm256_add_ps(size[0], _mm256_add_ps(size[1], size[2])), huge, _CMP_LT_OQ)),
        _mm256_and_ps(_mm256_cmp_ps(longest, _mm256_set1_ps(1e-30f), _CMP_GT_OQ),
                      _mm256_cmp_ps(ray.t_min, zero, _CMP_GE_OQ)));
    if (lanes_of(usable) != 255) return false;

    // kernels::slab_padding(), the greatest of it.
    const __m256 padding = greatest(_mm256_fmadd_ps(_mm256_set1_ps(1.9073486e-6f), padding_far,
                                                    _mm256_mul_ps(_mm256_set1_ps(2.3841858e-7f), padding_origin)));
    const __m256 tiny = _mm256_mul_ps(longest, _mm256_set1_ps(1e-8f)), sign = _mm256_set1_ps(-0.0f);
    for (int a = 0; a < 3; ++a) {
        PacketAxis& s = p.axes[a];
        const unsigned signs = lanes_of(ray.direction[a]);
        if (signs != 0 && signs != 255) return false;
        const __m256 d = _mm256_or_ps(_mm256_max_ps(size[a], tiny), _mm256_and_ps(ray.direction[a], sign));
        s.inverse = _mm256_div_ps(_mm256_set1_ps(1), d);
        const __m256 offset = _mm256_mul_ps(negative(ray.origin[a]), s.inverse);
        const __m256 wider = _mm256_mul_ps(padding, magnitude(s.inverse));
        s.near_offset = _mm256_sub_ps(offset, wider);
        s.far_offset = _mm256_add_ps(offset, wider);
        const __m256 lower = _mm256_sub_ps(least(ray.origin[a]), padding);
        const __m256 upper = _mm256_add_ps(greatest(ray.origin[a]), padding);
        const __m256 steep = least(s.inverse), flat = greatest(s.inverse);
        s.near_origin = signs ? lower : upper;
        s.far_origin = signs ? upper : lower;
        s.near_inverse = signs ? flat : steep;
        s.far_inverse = signs ? steep : flat;
        s.near_row = (2 * std::size_t(a) + (signs ? 1 : 0)) * 8;
        s.far_row = (2 * std::size_t(a) + (signs ? 0 : 1)) * 8;
    }
    p.t_min = ray.t_min;
    p.first_t_min = least(ray.t_min);

    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    const __m256 s = _mm256_div_ps(_mm256_set1_ps(1), ray.direction[axis]);
    alignas(32) float columns[7][8];
    _mm256_store_ps(columns[0], ray.origin[next]);
    _mm256_store_ps(columns[1], ray.origin[last]);
    _mm256_store_ps(columns[2], ray.origin[axis]);
    _mm256_store_ps(columns[3], _mm256_mul_ps(negative(ray.direction[next]), s));
    _mm256_store_ps(columns[4], _mm256_mul_ps(negative(ray.direction[last]), s));
    _mm256_store_ps(columns[5], s);
    _mm256_store_ps(columns[6], ray.t_min);
    for (int i = 0; i < 4; ++i)
        p.pairs[i] = {pair_of(columns[0], i), pair_of(columns[1], i), pair_of(columns[2], i), pair_of(columns[3], i),
                      pair_of(columns[4], i), pair_of(columns[5], i), pair_of(columns[6], i)};
    p.x = std::size_t(next) * 4;
    p.y = std::size_t(last) * 4;
    p.z = std::size_t(axis) * 4;
    return true;
}

SPINEL_INLINE __m256 frustum_enter(const float* node, const PacketAxis& a) {
    return _mm256_mul_ps(_mm256_sub_ps(_mm256_load_ps(node + a.near_row), a.near_origin), a.near_inverse);
}
SPINEL_INLINE __m256 frustum_leave(const float* node, const PacketAxis& a) {
    return _mm256_mul_ps(_mm256_sub_ps(_mm256_load_ps(node + a.far_row), a.far_origin), a.far_inverse);
}

// The children whose boxes the frustum meets, and where it enters each.
SPINEL_INLINE unsigned frustum_boxes(const float* node, const Packet& p, __m256 last_t_max, __m256& enter) {
    enter = _mm256_max_ps(_mm256_max_ps(frustum_enter(node, p.axes[0]), p.first_t_min),
                          _mm256_max_ps(frustum_enter(node, p.axes[1]), frustum_enter(node, p.axes[2])));
    const __m256 leave = _mm256_min_ps(_mm256_min_ps(frustum_leave(node, p.axes[0]), last_t_max),
                                       _mm256_min_ps(frustum_leave(node, p.axes[1]), frustum_leave(node, p.axes[2])));
    return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ)));
}

// The rays that meet the box of child i.
SPINEL_INLINE unsigned rays_in_box(const float* node, int i, const Packet& p, __m256 t_max) {
    const auto plane = [&](const PacketAxis& a, std::size_t row, __m256 offset) __attribute__((always_inline)) {
        return _mm256_fmadd_ps(_mm256_broadcast_ss(node + row + i), a.inverse, offset);
    };
    const PacketAxis &x = p.axes[0], &y = p.axes[1], &z = p.axes[2];
    const __m256 enter =
        _mm256_max_ps(_mm256_max_ps(plane(x, x.near_row, x.near_offset), p.t_min),
                      _mm256_max_ps(plane(y, y.near_row, y.near_offset), plane(z, z.near_row, z.near_offset)));
    const __m256 leave =
        _mm256_min_ps(_mm256_min_ps(plane(x, x.far_row, x.far_offset), t_max),
                      _mm256_min_ps(plane(y, y.far_row, y.far_offset), plane(z, z.far_row, z.far_offset)));
    return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ)));
}

// wide::hit_triangles() for two rays: the first one's four triangles, then the second's.
SPINEL_INLINE LaneHits hit_triangles(const float* block, const Packet& p, const Packet::Pair& s, __m256 t_max) {
    const auto row = [](const float* at) __attribute__((always_inline)) {
        return _mm256_broadcast_ps(reinterpret_cast<const __m128*>(at));
    };
    const float *const px = block + p.x, *const py = block + p.y, *const pz = block + p.z;
    const __m256 az = _mm256_sub_ps(row(pz), s.origin_z);
    const __m256 bz = _mm256_sub_ps(row(pz + 12), s.origin_z);
    const __m256 cz = _mm256_sub_ps(row(pz + 24), s.origin_z);
    const __m256 ax = _mm256_fmadd_ps(s.shear_x, az, _mm256_sub_ps(row(px), s.origin_x));
    const __m256 bx = _mm256_fmadd_ps(s.shear_x, bz, _mm256_sub_ps(row(px + 12), s.origin_x));
    const __m256 cx = _mm256_fmadd_ps(s.shear_x, cz, _mm256_sub_ps(row(px + 24), s.origin_x));
    const __m256 ay = _mm256_fmadd_ps(s.shear_y, az, _mm256_sub_ps(row(py), s.origin_y));
    const __m256 by = _mm256_fmadd_ps(s.shear_y, bz, _mm256_sub_ps(row(py + 12), s.origin_y));
    const __m256 cy = _mm256_fmadd_ps(s.shear_y, cz, _mm256_sub_ps(row(py + 24), s.origin_y));
    const auto heights = [&]() __attribute__((always_inline)) {
        return Heights{_mm256_mul_ps(s.shear_z, az), _mm256_mul_ps(s.shear_z, bz), _mm256_mul_ps(s.shear_z, cz)};
    };
    return hit_lanes(ax, ay, bx, by, cx, cy, 255, heights, s.t_min, t_max);
}

// The nearest hits so far.
struct Nearest {
    alignas(32) float t[8];
    float u[8], v[8];
    std::uint32_t triangle[8];  // 0 as long as there is none
    const float* block[8];      // in which it stands …
    int lane[8];                // … and where
    unsigned found;
};

// Rays in `lanes`; returns those that met something, or something nearer.
template <bool any>
SPINEL_INLINE unsigned test_block(const float* block, const Packet& p, unsigned lanes, Nearest& best) {
    unsigned met = 0;
    for (int pair = 0; pair < 4; ++pair) {
        const unsigned both = lanes >> (2 * pair) & 3;
        if (!both) continue;
        const __m256 t_max = pair_of(best.t, pair);
        const LaneHits hits = hit_triangles(block, p, p.pairs[pair], t_max);
        unsigned rest = hits.lanes & (both & 1 ? 0x0f : 0) & 0xff;
        rest |= hits.lanes & (both & 2 ? 0xf0 : 0);
        if (!rest) continue;
        if constexpr (any) {
            rest &= lanes_of(_mm256_cmp_ps(hits.t, t_max, _CMP_LT_OQ));
            met |= (unsigned((rest & 0x0f) != 0) | unsigned((rest & 0xf0) != 0) << 1) << (2 * pair);
            continue;
        }
        alignas(32) float t[8], u[8], v[8];
        _mm256_store_ps(t, hits.t);
        _mm256_store_ps(u, hits.u);
        _mm256_store_ps(v, hits.v);
        for (; rest; rest &= rest - 1) {
            const int i = std::countr_zero(rest), ray = 2 * pair + (i >> 2);
            const auto triangle = std::bit_cast<std::uint32_t>(block[36 + (i & 3)]);
            if (!(t[i] < best.t[ray]) && !(t[i] == best.t[ray] && triangle < best.triangle[ray])) continue;
            best.t[ray] = t[i];
            best.u[ray] = u[i];
            best.v[ray] = v[i];
            best.triangle[ray] = triangle;
            best.block[ray] = block;
            best.lane[ray] = i & 3;
            met |= 1u << ray;
        }
    }
    return met;
}

struct Entry {
    std::uint32_t reference;
    float enter;
    unsigned lanes;
};

// Ray i alone.
template <bool any>
SPINEL_INLINE bool walk_alone(const WideMesh& mesh, const Ray& ray, std::uint32_t reference, int i, Nearest& best) {
    Best one = {best.t[i], best.u[i], best.v[i], best.triangle[i], false};
    const bool found = walk<Gathered, any>(mesh.units, make_slabs(mesh, ray), make_shear(ray), reference, one);
    if (!found) return false;
    best.t[i] = one.t;
    best.u[i] = one.u;
    best.v[i] = one.v;
    best.triangle[i] = one.triangle;
    best.block[i] = one.block;
    best.lane[i] = one.lane;
    return true;
}

// Of any hit, rays that have met something ask no more.
template <bool any>
SPINEL_INLINE void walk_together(const WideMesh& mesh, const Packet& p, const Ray* rays, unsigned asking,
                                 Nearest& best) {
    const kernels::WideUnit* const units = mesh.units;
    __m256 t_max = _mm256_load_ps(best.t), last_t_max = greatest(t_max);
    Entry stack[kernels::WIDE_STACK_SIZE];
    Entry* top = stack;
    Entry now = {0, 0, asking};
    for (;;) {
        unsigned met = 0;
        if (std::popcount(now.lanes) <= few) {
            for (unsigned rest = now.lanes; rest; rest &= rest - 1) {
                const int i = std::countr_zero(rest);
                met |= unsigned(walk_alone<any>(mesh, rays[i], now.reference, i, best)) << i;
            }
        } else if (now.reference > unit_mask) {
            const float* block = units[now.reference & unit_mask].lanes;
            for (std::uint32_t rest = now.reference >> reference_bits; rest; --rest) {
                met |= test_block<any>(block, p, any ? now.lanes & ~met : now.lanes, best);
                block += 8 * kernels::WIDE_BLOCK_UNITS;
            }
        } else {
            const float* const node = units[now.reference].lanes;
            const std::uint32_t* const references = references_of(node);
            __m256 enter;
            unsigned hit = frustum_boxes(node, p, last_t_max, enter);
            alignas(32) float enters[8];
            _mm256_store_ps(enters, enter);
            Entry* const first = top;
            for (; hit; hit &= hit - 1) {
                const int i = std::countr_zero(hit);
                const unsigned inside = rays_in_box(node, i, p, t_max) & now.lanes;
                if (!inside) continue;
                prefetch(units, references[i]);
                Entry* at = top++;
                for (; at > first && (any || at[-1].enter < enters[i]); --at) *at = at[-1];
                *at = {references[i], enters[i], inside};
            }
            if (top != first) {
                now = *--top;
                continue;
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
            now = *--top;
            if constexpr (any) now.lanes &= asking;
            else now.lanes &= lanes_of(_mm256_cmp_ps(_mm256_set1_ps(now.enter), t_max, _CMP_LE_OQ));
        } while (!now.lanes);
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
        return walk_together<any>(mesh, packet, rays, lanes, best);
    for (unsigned rest = lanes; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        best.found |= unsigned(walk_alone<any>(mesh, rays[i], 0, i, best)) << i;
    }
}

}  // namespace

void wide_closest8_avx2(const WideMesh& mesh, const Ray* rays, unsigned lanes, WideHit* hits) {
    Nearest best;
    walk8<false>(mesh, rays, lanes, best);
    for (unsigned rest = lanes; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        if (best.found >> i & 1)
            hits[i] = {best.t[i], best.u[i], best.v[i], best.triangle[i], best.block[i], best.lane[i]};
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
