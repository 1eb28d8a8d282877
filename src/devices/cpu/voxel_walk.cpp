// The walk of kernels/voxels.h through air, with the three axes in one SSE register. It agrees with the kernel bit for
// bit: where the next cell is in doubt by rounding, it asks the kernel's own function. Rays that start inside of a
// medium, or so far off that rounding is about a cell, are the kernel's.
#include "devices/cpu/voxel_walk.h"

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "kernels/device.h"

namespace spinel {

namespace {

struct NotCounted {
    void node() {}
    void cube() {}
};

struct Counted {
    VoxelWalkCount count;
    void node() { ++count.nodes; }
    void cube() { ++count.cubes; }
};

#ifdef __SSE4_1__

template <class Counter>
void walk(const kernels::SceneView& scene, kernels::uint grid_index, kernels::uint slot_first, const kernels::Ray& ray,
          kernels::Hit& hit, Counter& counter) {
    using namespace kernels;
    const VoxelGrid& grid = scene.voxel_grids.at[grid_index];
    const VoxelRay r = voxel_ray(grid.size, ray);
    if (!(r.enter < r.leave) || r.enter >= hit.t) return;
    const float reach = max_component(abs(ray.origin)) + float(std::max({grid.size.x, grid.size.y, grid.size.z}));
    if (!(reach < 1e5f)) return voxels_closest(scene, grid_index, slot_first, ray, hit);
    // A cell is in doubt if the position is this near to one of its planes: 16 roundings of the largest term.
    const float doubt = 1e-6f * reach;

    const ivec3 first = voxel_first_cell(grid.size, ray, r);
    struct Node {
        std::uint64_t mask;
        uint link;
    };
    const auto loaded = [](const VoxelNode& n) { return Node{n.mask_low | std::uint64_t(n.mask_high) << 32, n.link}; };
    Node stack[VOXEL_MAX_LEVELS];
    uint level = grid.level_count - 1;
    stack[level] = loaded(grid.root);
    counter.node();
    const VoxelNode* const nodes = scene.voxel_nodes.at + grid.node_first;
    const uint* const references = grid.reference_first == NONE ? nullptr : scene.words.at + grid.reference_first;

    // Where the direction is zero, planes are met at INFINITE: INFINITE = (0 − −INFINITE) · 1.
    const auto lanes = [](vec3 v, float w) { return _mm_setr_ps(v.x, v.y, v.z, w); };
    const vec3 d(r.still.x ? 0.0f : ray.direction.x, r.still.y ? 0.0f : ray.direction.y,
                 r.still.z ? 0.0f : ray.direction.z);
    const __m128 origin = lanes(ray.origin, 0), direction = lanes(d, 0);
    const __m128 still = _mm_cmpeq_ps(direction, _mm_setzero_ps());
    const __m128 plane_origin = _mm_blendv_ps(origin, _mm_set1_ps(-INFINITE), still);
    const __m128 inverse = _mm_blendv_ps(lanes(r.inverse, 1), _mm_set1_ps(1.0f), still);
    const __m128i positive =
        _mm_sub_epi32(_mm_setzero_si128(), _mm_setr_epi32(r.positive.x, r.positive.y, r.positive.z, 0));
    const __m128i negative = _mm_xor_si128(positive, _mm_set1_epi32(-1));
    const __m128i last = _mm_setr_epi32(grid.size.x - 1, grid.size.y - 1, grid.size.z - 1, 0x7fffffff);
    const __m128 doubt_low = _mm_set1_ps(doubt), doubt_high = _mm_set1_ps(1 - doubt);

    __m128i cell = _mm_setr_epi32(first.x, first.y, first.z, 0);
    uint x = uint(first.x), y = uint(first.y), z = uint(first.z);
    float t = r.enter;
    uint axis = 0;
    bool started = false;
    for (;;) {
        uint log2_edge;
        counter.cube();
        for (;;) {
            const Node node = stack[level];
            const uint shift = 2 * level;
            const uint digit = (x >> shift & 3) | (y >> shift & 3) << 2 | (z >> shift & 3) << 4;
            if (!(node.mask >> digit & 1)) {
                log2_edge = shift + ((node.mask >> (digit & 0x2a) & 0x00330033) == 0);
                break;
            }
            const uint rank = uint(std::popcount(node.mask & ((std::uint64_t(1) << digit) - 1)));
            if ((node.link & VOXEL_LINK_KIND) == VOXEL_LINK_CHILDREN) {
                const uint at = node.link + rank;
                stack[--level] = loaded(nodes[references ? references[at] : at]);
                counter.node();
                continue;
            }
            const VoxelNode plain(uint(node.mask), uint(node.mask >> 32), node.link);
            const uint palette = voxel_palette(scene, grid, plain, rank);
            if (voxel_class(scene, slot_first, palette) == VOXEL_AIR) {
                log2_edge = (node.link & VOXEL_LINK_KIND) == VOXEL_LINK_SOLID ? shift : 0;
                break;
            }
            if (!started) return voxels_closest(scene, grid_index, slot_first, ray, hit);
            voxel_hit(ray, t, ivec3(x, y, z), palette, axis, component(ray.direction, axis) < 0.0f, hit);
            return;
        }
        started = true;

        // To the exit of the cube.
        const __m128i rest = _mm_set1_epi32((1 << log2_edge) - 1);
        const __m128i lower = _mm_andnot_si128(rest, cell), upper = _mm_or_si128(cell, rest);
        const __m128i far_plane = _mm_sub_epi32(_mm_blendv_epi8(lower, upper, positive), positive);
        const __m128 planes = _mm_mul_ps(_mm_sub_ps(_mm_cvtepi32_ps(far_plane), plane_origin), inverse);
        __m128 nearest = _mm_min_ps(planes, _mm_shuffle_ps(planes, planes, _MM_SHUFFLE(1, 0, 3, 2)));
        nearest = _mm_min_ps(nearest, _mm_shuffle_ps(nearest, nearest, _MM_SHUFFLE(2, 3, 0, 1)));
        __m128 at_nearest = _mm_cmpeq_ps(planes, nearest);
        const uint crossed = uint(_mm_movemask_ps(at_nearest));
        if (!crossed) return;  // not a number
        axis = uint(std::countr_zero(crossed));
        if (crossed & (crossed - 1)) [[unlikely]]  // x before y before z
            at_nearest = _mm_castsi128_ps(_mm_cmpeq_epi32(_mm_setr_epi32(0, 1, 2, 3), _mm_set1_epi32(int(axis))));
        t = _mm_cvtss_f32(nearest);
        if (t >= hit.t) return;

        const __m128 position = _mm_add_ps(origin, _mm_mul_ps(nearest, direction));
        const __m128i inside = _mm_max_epi32(_mm_min_epi32(_mm_cvttps_epi32(position), upper), lower);
        const __m128 fraction = _mm_sub_ps(position, _mm_cvtepi32_ps(inside));
        const __m128 sure = _mm_or_ps(_mm_or_ps(still, at_nearest), _mm_and_ps(_mm_cmpge_ps(fraction, doubt_low),
                                                                               _mm_cmple_ps(fraction, doubt_high)));
        __m128i next = _mm_blendv_epi8(inside, _mm_add_epi32(far_plane, negative), _mm_castps_si128(at_nearest));
        if (_mm_movemask_ps(sure) != 15) [[unlikely]] {
            alignas(16) int low[4], high[4], c[4];
            _mm_store_si128(reinterpret_cast<__m128i*>(low), lower);
            _mm_store_si128(reinterpret_cast<__m128i*>(high), upper);
            _mm_store_si128(reinterpret_cast<__m128i*>(c), next);
            for (int a = 0; a < 3; ++a)
                if (a != int(axis))
                    c[a] = voxel_cell(ray.origin[a], ray.direction[a], r.inverse[a], t, a < int(axis), low[a], high[a]);
            next = _mm_load_si128(reinterpret_cast<const __m128i*>(c));
        }
        // The sign of either tells that a coordinate left the set.
        if (_mm_movemask_ps(_mm_castsi128_ps(_mm_or_si128(next, _mm_sub_epi32(last, next)))) & 7) return;
        const auto pair = std::uint64_t(_mm_cvtsi128_si64(next));
        const uint old_x = x, old_y = y, old_z = z;
        x = uint(pair);
        y = uint(pair >> 32);
        z = uint(_mm_extract_epi32(next, 2));
        level = (31 - uint(std::countl_zero((x ^ old_x) | (y ^ old_y) | (z ^ old_z)))) >> 1;
        cell = next;
    }
}

#else

template <class Counter>
void walk(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first, const kernels::Ray& ray,
          kernels::Hit& hit, Counter&) {
    kernels::voxels_closest(scene, grid, slot_first, ray, hit);
}

#endif

}  // namespace

void cpu_voxels_closest(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                        const kernels::Ray& ray, kernels::Hit& hit) {
    NotCounted nothing;
    walk(scene, grid, slot_first, ray, hit, nothing);
}

VoxelWalkCount cpu_voxels_count(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                                const kernels::Ray& ray) {
    Counted counted;
    kernels::Hit hit = kernels::no_hit(ray.t_max);
    walk(scene, grid, slot_first, ray, hit, counted);
    return counted.count;
}

}  // namespace spinel

// The device's walk, as kernels/device.h declares it.
void spinel::kernels::device_voxels_closest(const SceneView& scene, uint grid, uint slot_first, Ray ray, Hit& hit) {
    cpu_voxels_closest(scene, grid, slot_first, ray, hit);
}
