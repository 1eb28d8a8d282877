#pragma once
// One ray against eight boxes at once, and four triangles: the parts of the walks with AVX2, and the walk of one ray.
//
// Planes are signed by the ray's octant beforehand, so that one fused multiply-add tells where one is met, and what
// rounds is in the added constant (kernels/mesh_wide.h). The usual small numbers of children that are hit have code of
// their own; children wait on the stack with the distance at which they are entered, and what they need of memory is
// asked for at once: that counts most on large meshes (measured: + 10 to 20 %).

#include <bit>
#include <cmath>
#include <cstdint>

#include "devices/cpu/avx2.h"
#include "devices/cpu/mesh_walk.h"
#include "kernels/mesh_wide.h"

#ifdef SPINEL_AVX2
#define SPINEL_INLINE inline __attribute__((always_inline))
SPINEL_AVX2_BEGIN

namespace spinel::wide {

using kernels::Ray;

constexpr std::uint32_t reference_bits = 28;
constexpr std::uint32_t unit_mask = (1u << reference_bits) - 1;

struct SlabAxis {
    __m256 inverse;
    __m256 near_offset, far_offset;  // −origin/direction, less and more the padding
    std::size_t near_row, far_row;   // of planes in a node, in floats
};

SPINEL_INLINE SlabAxis make_slab_axis(int axis, float origin, float inverse, float padding) {
    const float offset = -origin * inverse, wider = padding * std::abs(inverse);
    const auto negative = std::size_t(std::signbit(inverse));
    return {_mm256_set1_ps(inverse), _mm256_set1_ps(offset - wider), _mm256_set1_ps(offset + wider),
            (2 * std::size_t(axis) + negative) * 8, (2 * std::size_t(axis) + 1 - negative) * 8};
}

struct Slabs {
    SlabAxis x, y, z;
    __m256 t_min;
};

SPINEL_INLINE Slabs make_slabs(const WideMesh& mesh, const Ray& ray) {
    const float padding = kernels::slab_padding(mesh.lower, mesh.upper, ray.origin);
    const glm::vec3 inverse = kernels::wide_inverse(ray.direction), o = ray.origin;
    return {make_slab_axis(0, o.x, inverse.x, padding), make_slab_axis(1, o.y, inverse.y, padding),
            make_slab_axis(2, o.z, inverse.z, padding), _mm256_set1_ps(ray.t_min)};
}

SPINEL_INLINE __m256 enter_t(const float* node, const SlabAxis& a) {
    return _mm256_fmadd_ps(_mm256_load_ps(node + a.near_row), a.inverse, a.near_offset);
}
SPINEL_INLINE __m256 leave_t(const float* node, const SlabAxis& a) {
    return _mm256_fmadd_ps(_mm256_load_ps(node + a.far_row), a.inverse, a.far_offset);
}

// The children whose boxes the ray meets, and where it enters each.
SPINEL_INLINE unsigned hit_boxes(const float* node, const Slabs& s, __m256 t_max, __m256& enter) {
    enter = _mm256_max_ps(_mm256_max_ps(enter_t(node, s.x), s.t_min),
                          _mm256_max_ps(enter_t(node, s.y), enter_t(node, s.z)));
    const __m256 leave =
        _mm256_min_ps(_mm256_min_ps(leave_t(node, s.x), t_max), _mm256_min_ps(leave_t(node, s.y), leave_t(node, s.z)));
    return unsigned(_mm256_movemask_ps(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ)));
}

SPINEL_INLINE void prefetch(const kernels::WideUnit* units, std::uint32_t reference) {
    const char* p = reinterpret_cast<const char*>(units + (reference & unit_mask));
    for (int line = 0; line < 4; ++line) _mm_prefetch(p + 64 * line, _MM_HINT_T0);
}

SPINEL_INLINE const std::uint32_t* references_of(const float* node) {
    return reinterpret_cast<const std::uint32_t*>(node + 48);  // bits of integers in lanes of floats
}

// kernels::TriangleRay for rows of four.
struct Shear {
    __m128 origin_x, origin_y, origin_z;
    __m128 shear_x, shear_y, shear_z;
    std::size_t x, y, z;  // rows of the first vertex in a block, in floats
};

SPINEL_INLINE Shear make_shear(const Ray& ray) {
    const kernels::TriangleRay r = kernels::triangle_ray(ray);
    const glm::vec3 o = kernels::turned(ray.origin, r.axis);
    return {_mm_set1_ps(o.x),       _mm_set1_ps(o.y),       _mm_set1_ps(o.z),
            _mm_set1_ps(r.shear.x), _mm_set1_ps(r.shear.y), _mm_set1_ps(r.shear.z),
            (r.axis + 1) % 3 * 4,   (r.axis + 2) % 3 * 4,   r.axis * 4};
}

SPINEL_INLINE __m128 difference_of_products(__m128 a, __m128 b, __m128 c, __m128 d) {
    const __m128 cd = _mm_mul_ps(c, d);
    return _mm_add_ps(_mm_fmsub_ps(a, b, cd), _mm_fnmadd_ps(c, d, cd));
}

// kernels::triangle_watertight() for a block, in the same operations: those of its triangles that are hit in (t_min,
// t_max].
struct BlockHits {
    unsigned lanes;
    __m128 t, u, v;
};

SPINEL_INLINE BlockHits hit_triangles(const float* block, const Shear& s, __m128 t_min, __m128 t_max) {
    const float *const px = block + s.x, *const py = block + s.y, *const pz = block + s.z;
    const __m128 az = _mm_sub_ps(_mm_load_ps(pz), s.origin_z);
    const __m128 bz = _mm_sub_ps(_mm_load_ps(pz + 12), s.origin_z);
    const __m128 cz = _mm_sub_ps(_mm_load_ps(pz + 24), s.origin_z);
    const __m128 ax = _mm_fmadd_ps(s.shear_x, az, _mm_sub_ps(_mm_load_ps(px), s.origin_x));
    const __m128 bx = _mm_fmadd_ps(s.shear_x, bz, _mm_sub_ps(_mm_load_ps(px + 12), s.origin_x));
    const __m128 cx = _mm_fmadd_ps(s.shear_x, cz, _mm_sub_ps(_mm_load_ps(px + 24), s.origin_x));
    const __m128 ay = _mm_fmadd_ps(s.shear_y, az, _mm_sub_ps(_mm_load_ps(py), s.origin_y));
    const __m128 by = _mm_fmadd_ps(s.shear_y, bz, _mm_sub_ps(_mm_load_ps(py + 12), s.origin_y));
    const __m128 cy = _mm_fmadd_ps(s.shear_y, cz, _mm_sub_ps(_mm_load_ps(py + 24), s.origin_y));
    const __m128 u = difference_of_products(cx, by, cy, bx);
    const __m128 v = difference_of_products(ax, cy, ay, cx);
    const __m128 w = difference_of_products(bx, ay, by, ax);
    const __m128 zero = _mm_setzero_ps();
    const __m128 least = _mm_min_ps(_mm_min_ps(u, v), w), greatest = _mm_max_ps(_mm_max_ps(u, v), w);
    const __m128 outside = _mm_and_ps(_mm_cmplt_ps(least, zero), _mm_cmpgt_ps(greatest, zero));
    BlockHits hits;
    hits.lanes = 0;
    if (_mm_movemask_ps(outside) == 15) [[likely]]
        return hits;
    const __m128 determinant = _mm_add_ps(_mm_add_ps(u, v), w);
    const __m128 inverse = _mm_div_ps(_mm_set1_ps(1), determinant);
    const __m128 sum =
        _mm_fmadd_ps(u, _mm_mul_ps(s.shear_z, az),
                     _mm_fmadd_ps(v, _mm_mul_ps(s.shear_z, bz), _mm_mul_ps(w, _mm_mul_ps(s.shear_z, cz))));
    hits.t = _mm_mul_ps(sum, inverse);
    hits.u = _mm_mul_ps(v, inverse);
    hits.v = _mm_mul_ps(w, inverse);
    // Seen edge-on, t is infinite or not a number, and no number is nearer than t_max, which is finite, in either case.
    const __m128 within = _mm_and_ps(_mm_cmpgt_ps(hits.t, t_min), _mm_cmple_ps(hits.t, t_max));
    hits.lanes = unsigned(_mm_movemask_ps(_mm_andnot_ps(outside, within)));
    return hits;
}

// The same for eight triangles, of one ray or of eight, that are sheared already; a lane without a bit in `asked` holds
// anything. `heights` tells z of the corners a, b and c, and is asked only if any triangle is in the way.
SPINEL_INLINE __m256 difference_of_products(__m256 a, __m256 b, __m256 c, __m256 d) {
    const __m256 cd = _mm256_mul_ps(c, d);
    return _mm256_add_ps(_mm256_fmsub_ps(a, b, cd), _mm256_fnmadd_ps(c, d, cd));
}

struct LaneHits {
    unsigned lanes;
    __m256 t, u, v;
};

struct Heights {
    __m256 a, b, c;
};

template <class GetHeights>
SPINEL_INLINE LaneHits hit_lanes(__m256 ax, __m256 ay, __m256 bx, __m256 by, __m256 cx, __m256 cy, unsigned asked,
                                 const GetHeights& heights, __m256 t_min, __m256 t_max) {
    const __m256 u = difference_of_products(cx, by, cy, bx);
    const __m256 v = difference_of_products(ax, cy, ay, cx);
    const __m256 w = difference_of_products(bx, ay, by, ax);
    const __m256 zero = _mm256_setzero_ps();
    const __m256 least = _mm256_min_ps(_mm256_min_ps(u, v), w), greatest = _mm256_max_ps(_mm256_max_ps(u, v), w);
    const __m256 outside =
        _mm256_and_ps(_mm256_cmp_ps(least, zero, _CMP_LT_OQ), _mm256_cmp_ps(greatest, zero, _CMP_GT_OQ));
    LaneHits hits;
    hits.lanes = 0;
    if (!(~unsigned(_mm256_movemask_ps(outside)) & asked)) [[likely]]
        return hits;
    const Heights z = heights();
    const __m256 determinant = _mm256_add_ps(_mm256_add_ps(u, v), w);
    const __m256 inverse = _mm256_div_ps(_mm256_set1_ps(1), determinant);
    const __m256 sum = _mm256_fmadd_ps(u, z.a, _mm256_fmadd_ps(v, z.b, _mm256_mul_ps(w, z.c)));
    hits.t = _mm256_mul_ps(sum, inverse);
    hits.u = _mm256_mul_ps(v, inverse);
    hits.v = _mm256_mul_ps(w, inverse);
    const __m256 within =
        _mm256_and_ps(_mm256_cmp_ps(hits.t, t_min, _CMP_GT_OQ), _mm256_cmp_ps(hits.t, t_max, _CMP_LE_OQ));
    hits.lanes = unsigned(_mm256_movemask_ps(_mm256_andnot_ps(outside, within))) & asked;
    return hits;
}

// The nearest hit so far. `triangle` is 0 as long as there is none: at t_max itself nothing is nearer then.
struct Best {
    float t, u, v;
    std::uint32_t triangle;
    bool found;
    const float* block = nullptr;  // in which it stands …
    int lane = 0;                  // … and where
};

SPINEL_INLINE bool closest_in_block(const float* block, const Shear& s, __m128 t_min, Best& best) {
    const BlockHits hits = hit_triangles(block, s, t_min, _mm_set1_ps(best.t));
    if (!hits.lanes) return false;
    alignas(16) float t[4], u[4], v[4];
    _mm_store_ps(t, hits.t);
    _mm_store_ps(u, hits.u);
    _mm_store_ps(v, hits.v);
    bool nearer = false;
    for (unsigned rest = hits.lanes; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        const auto triangle = std::bit_cast<std::uint32_t>(block[36 + i]);
        if (!(t[i] < best.t) && !(t[i] == best.t && triangle < best.triangle)) continue;
        best = {t[i], u[i], v[i], triangle, true, block, i};
        nearer = true;
    }
    return nearer;
}

SPINEL_INLINE bool any_in_block(const float* block, const Shear& s, __m128 t_min, __m128 t_max) {
    const BlockHits hits = hit_triangles(block, s, t_min, t_max);
    return hits.lanes && (hits.lanes & unsigned(_mm_movemask_ps(_mm_cmplt_ps(hits.t, t_max))));
}

// A child still to visit: the distance at which it is entered above its reference, so that the order of these numbers
// is that of the distances, but for negative ones, whose order does not matter.
SPINEL_INLINE std::int64_t entry(float enter, std::uint32_t reference) {
    return std::int64_t(std::uint64_t(std::bit_cast<std::uint32_t>(enter)) << 32 | reference);
}
SPINEL_INLINE float entry_distance(std::int64_t e) {
    return std::bit_cast<float>(std::uint32_t(std::uint64_t(e) >> 32));
}

// The farther first. (Conditional moves: which is the nearer is anyone's guess.)
SPINEL_INLINE void order(std::int64_t& a, std::int64_t& b) {
    const std::int64_t x = a, y = b;
    a = x < y ? y : x;
    b = x < y ? x : y;
}

// How nodes and leaves are stored: here as WideUnit tells.
struct Gathered {
    using Shear = wide::Shear;

    static SPINEL_INLINE Shear make_shear(const Ray& ray) { return wide::make_shear(ray); }
    static SPINEL_INLINE const float* at(const kernels::WideUnit* units, std::uint32_t place) {
        return units[place].lanes;
    }
    static SPINEL_INLINE const std::uint32_t* references_of(const float* node) { return wide::references_of(node); }
    static SPINEL_INLINE unsigned hit_boxes(const float* node, const Slabs& s, __m256 t_max, __m256& enter) {
        return wide::hit_boxes(node, s, t_max, enter);
    }
    static SPINEL_INLINE void prefetch(const kernels::WideUnit* units, std::uint32_t reference) {
        wide::prefetch(units, reference);
    }
    // True if there is a nearer hit, or any.
    template <bool any>
    static SPINEL_INLINE bool test_leaf(const float* block, std::uint32_t blocks, const Shear& shear, __m256 t_min,
                                        __m256 t_max, Best& best) {
        bool nearer = false;
        do {
            if constexpr (any) {
                if (any_in_block(block, shear, _mm256_castps256_ps128(t_min), _mm256_castps256_ps128(t_max)))
                    return true;
            } else {
                nearer |= closest_in_block(block, shear, _mm256_castps256_ps128(t_min), best);
            }
            block += 8 * kernels::WIDE_BLOCK_UNITS;
        } while (--blocks);
        return nearer;
    }
};

// What is nearest below a node or leaf, or, if any hit will do, whether there is one.
template <class Layout, bool any>
SPINEL_INLINE bool walk(const kernels::WideUnit* units, const Slabs& slabs, const typename Layout::Shear& shear,
                        std::uint32_t reference, Best& best) {
    __m256 t_max = _mm256_set1_ps(best.t);
    std::int64_t stack[kernels::WIDE_STACK_SIZE];
    std::int64_t* top = stack;
    for (;;) {
        while (reference <= unit_mask) {
            const float* const node = Layout::at(units, reference);
            const std::uint32_t* const references = Layout::references_of(node);
            __m256 enter;
            unsigned hit = Layout::hit_boxes(node, slabs, t_max, enter);
            if (!hit) goto pop;
            const int only = std::countr_zero(hit);
            if constexpr (any) {
                // The most promising children stand first (accel/wide_bvh.cpp).
                reference = references[only];
                Layout::prefetch(units, reference);
                for (hit &= hit - 1; hit; hit &= hit - 1) {
                    *top = references[std::countr_zero(hit)];
                    Layout::prefetch(units, std::uint32_t(*top++));
                }
                continue;
            }
            if (!(hit & (hit - 1))) {
                reference = references[only];
                Layout::prefetch(units, reference);
                continue;
            }
            alignas(32) float enters[8];
            _mm256_store_ps(enters, enter);
            const auto next = [&]() __attribute__((always_inline)) {
                const int i = std::countr_zero(hit);
                hit &= hit - 1;
                Layout::prefetch(units, references[i]);
                return entry(enters[i], references[i]);
            };
            std::int64_t e0 = next(), e1 = next();
            order(e0, e1);
            if (!hit) {
                *top++ = e0;
                reference = std::uint32_t(e1);
                continue;
            }
            std::int64_t e2 = next();
            if (!hit) {
                order(e1, e2);
                order(e0, e1);
                *top++ = e0;
                *top++ = e1;
                reference = std::uint32_t(e2);
                continue;
            }
            std::int64_t e3 = next();
            order(e2, e3);
            order(e0, e2);
            order(e1, e3);
            order(e1, e2);
            std::int64_t* const first = top;
            *top++ = e0;
            *top++ = e1;
            *top++ = e2;
            // NOLINTNEXTLINE(bugprone-infinite-loop): next() takes from `hit`
            while (hit) {
                *top++ = e3;  // the nearest so far
                const std::int64_t e = next();
                std::int64_t* at = top;
                for (; at > first && at[-1] < e; --at) *at = at[-1];
                *at = e;
                e3 = *top;
            }
            reference = std::uint32_t(e3);
        }
        {
            const float* const block = Layout::at(units, reference & unit_mask);
            const bool nearer =
                Layout::template test_leaf<any>(block, reference >> reference_bits, shear, slabs.t_min, t_max, best);
            if (any && nearer) return true;
            if (nearer) t_max = _mm256_set1_ps(best.t);
        }
    pop:
        do {
            if (top == stack) return best.found;
            reference = std::uint32_t(*--top);
        } while (!any && !(entry_distance(*top) <= best.t));
    }
}

}  // namespace spinel::wide

SPINEL_AVX2_END
#endif
