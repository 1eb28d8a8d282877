// Up to 64 neighbours, eight packets, against a set of voxels. What lies in front of all of them is found once: the
// interval of t in which any of them meets a plane tells the children of a node that any may visit, 64 of them in some
// fifty instructions. Only cells and nodes that are no larger than the bundle is wide are asked of each packet.
//
// The bounds are exact, since rounded differences and products keep the order of numbers: no child is left out that a
// ray visits, and what is asked of the packets is what voxel_packet.cpp asks, so the hits are the kernel's, bit for
// bit. Wald, Ize, Kensler, Knoll, Parker, "Ray Tracing Animated Scenes using Coherent Grid Traversal", SIGGRAPH 2006,
// carry packets through grids by their frustum in this way.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "devices/cpu/voxel_packet.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_AS_ELSEWHERE_BEGIN

namespace spinel {

namespace {

using namespace kernels;

constexpr int bundle_packets = 8;
constexpr std::size_t cache_line = 64;

struct Range {
    __m256 low, high;
};

struct Bundle {
    RayColumns rays[bundle_packets];
    int count;
    std::uint32_t flip;
    Range origin[3], inverse[3];  // of all rays, the same in all lanes
    __m256 start, leave;          // no ray's walk begins before or ends after
    float width, growth;          // the rays' places differ by no more than width + t·growth along any axis
};

// The least and the greatest number in any lane, in all lanes.
__m256 least(__m256 x) {
    x = _mm256_min_ps(x, _mm256_permute2f128_ps(x, x, 1));
    x = _mm256_min_ps(x, _mm256_shuffle_ps(x, x, _MM_SHUFFLE(1, 0, 3, 2)));
    return _mm256_min_ps(x, _mm256_shuffle_ps(x, x, _MM_SHUFFLE(2, 3, 0, 1)));
}
__m256 greatest(__m256 x) {
    x = _mm256_max_ps(x, _mm256_permute2f128_ps(x, x, 1));
    x = _mm256_max_ps(x, _mm256_shuffle_ps(x, x, _MM_SHUFFLE(1, 0, 3, 2)));
    return _mm256_max_ps(x, _mm256_shuffle_ps(x, x, _MM_SHUFFLE(2, 3, 0, 1)));
}
__m256 pick(__m256 x, __m256i lanes) { return _mm256_permutevar8x32_ps(x, lanes); }
float number(__m256 x) { return _mm256_cvtss_f32(x); }

// Whether all rays are neighbours, as are_neighbours() means it, that stand still along no axis, and near enough for
// whole cells to be told from rounding.
bool gather(const VoxelGrid& grid, std::span<const Ray> rays, Bundle& b) {
    b.count = int(rays.size() / packet_size);
    Range origin[3], direction[3];
    __m256 first_origin[3], first_direction[3], turn = _mm256_setzero_ps();
    for (int i = 0; i < b.count; ++i) {
        RayColumns& ray = b.rays[i];
        const Ray* const eight = &rays[std::size_t(i * packet_size)];
        ray = ray_columns(eight);
        // The next bundle most likely follows.
        const auto next = reinterpret_cast<std::uintptr_t>(eight) + bundle_packets * packet_size * sizeof(Ray);
        for (std::size_t at = 0; at < packet_size * sizeof(Ray); at += cache_line)
            _mm_prefetch(reinterpret_cast<const char*>(next + at), _MM_HINT_T0);
        if (i == 0) {
            for (int a = 0; a < 3; ++a) {
                first_origin[a] = front(ray.origin[a]);
                first_direction[a] = front(ray.direction[a]);
                turn = _mm256_max_ps(turn, magnitude(first_direction[a]));
                origin[a] = {ray.origin[a], ray.origin[a]};
                direction[a] = {ray.direction[a], ray.direction[a]};
            }
            turn = _mm256_mul_ps(turn, _mm256_set1_ps(neighbour_turn));
        }
        __m256 near = all_lanes();
        for (int a = 0; a < 3; ++a) {
            const __m256 turned = magnitude(_mm256_sub_ps(ray.direction[a], first_direction[a]));
            const __m256 moved = magnitude(_mm256_sub_ps(ray.origin[a], first_origin[a]));
            near =
                _mm256_and_ps(near, _mm256_and_ps(_mm256_cmp_ps(turned, turn, _CMP_LE_OQ),
                                                  _mm256_cmp_ps(moved, _mm256_set1_ps(neighbour_cells), _CMP_LE_OQ)));
            origin[a].low = _mm256_min_ps(origin[a].low, ray.origin[a]);
            origin[a].high = _mm256_max_ps(origin[a].high, ray.origin[a]);
            direction[a].low = _mm256_min_ps(direction[a].low, ray.direction[a]);
            direction[a].high = _mm256_max_ps(direction[a].high, ray.direction[a]);
        }
        if (lanes_of(near) != 0xff) return false;  // also where something is no number
    }
    const __m256 one = _mm256_set1_ps(1);
    b.flip = 0;
    b.width = b.growth = 0;
    float far = 0;
    for (int a = 0; a < 3; ++a) {
        const __m256 low = least(direction[a].low), high = greatest(direction[a].high);
        if (number(low) <= -TINY_DIRECTION && number(high) <= -TINY_DIRECTION) b.flip |= 3u << (2 * a);
        else if (!(number(low) >= TINY_DIRECTION)) return false;
        if (!(std::max(-number(low), number(high)) < longest_direction)) return false;
        b.inverse[a] = {_mm256_div_ps(one, high), _mm256_div_ps(one, low)};
        b.origin[a] = {least(origin[a].low), greatest(origin[a].high)};
        b.growth = std::max(b.growth, number(high) - number(low));
        b.width = std::max(b.width, number(b.origin[a].high) - number(b.origin[a].low));
        far = std::max({far, -number(b.origin[a].low), number(b.origin[a].high)});
    }
    return far + float(std::max({grid.size.x, grid.size.y, grid.size.z})) < farthest_exact;
}

// Where the rays meet planes of an axis.
Range plane_range(const Bundle& b, int axis, __m256 plane) {
    const Range &o = b.origin[axis], &inverse = b.inverse[axis];
    const __m256 low = _mm256_sub_ps(plane, o.high), high = _mm256_sub_ps(plane, o.low);
    const __m256 t[4] = {_mm256_mul_ps(low, inverse.low), _mm256_mul_ps(low, inverse.high),
                         _mm256_mul_ps(high, inverse.low), _mm256_mul_ps(high, inverse.high)};
    return {_mm256_min_ps(_mm256_min_ps(t[0], t[1]), _mm256_min_ps(t[2], t[3])),
            _mm256_max_ps(_mm256_max_ps(t[0], t[1]), _mm256_max_ps(t[2], t[3]))};
}

// A node that the bundle is in.
struct BundleNode {
    mask64 mask;
    mask64 todo;  // mirrored
    uint link;
    ivec3 lower;
    bool together;  // the children are wider than the bundle
};

// A node at a place, and those of its children, `edge` cells wide, that any ray may visit.
void open_node(const Bundle& b, const VoxelNode& node, ivec3 lower, int edge, BundleNode& n) {
    n.mask = make_mask64(node.mask_low, node.mask_high);
    n.link = node.link;
    n.lower = lower;
    Range t[3];
    for (int a = 0; a < 3; ++a) {
        const bool negative = b.flip >> 2 * a & 1;
        const __m256 steps = _mm256_mul_ps(_mm256_setr_ps(0, 1, 2, 3, 4, 4, 4, 4), _mm256_set1_ps(float(edge)));
        const __m256 first = _mm256_set1_ps(float(lower[a] + (negative ? 4 * edge : 0)));
        t[a] = plane_range(b, a, negative ? _mm256_sub_ps(first, steps) : _mm256_add_ps(first, steps));
    }
    const __m256 enter =
        _mm256_max_ps(_mm256_max_ps(b.start, front(t[0].low)), _mm256_max_ps(front(t[1].low), front(t[2].low)));
    n.together = b.width + number(enter) * b.growth <= 0.5f * float(edge);

    // A lane for each of eight children: by four along x, two along y.
    const __m256i x = _mm256_setr_epi32(0, 1, 2, 3, 0, 1, 2, 3), y = _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1);
    const __m256i one = _mm256_set1_epi32(1), two = _mm256_set1_epi32(2);
    const __m256 x_in = _mm256_max_ps(pick(t[0].low, x), b.start);
    const __m256 x_out = _mm256_min_ps(pick(t[0].high, _mm256_add_epi32(x, one)), b.leave);
    __m256 in[2], out[2];
    for (int half = 0; half < 2; ++half) {
        const __m256i rows = half ? _mm256_add_epi32(y, two) : y;
        in[half] = _mm256_max_ps(x_in, pick(t[1].low, rows));
        out[half] = _mm256_min_ps(x_out, pick(t[1].high, _mm256_add_epi32(rows, one)));
    }
    mask64 met = 0;
    for (int z = 3; z >= 0; --z) {
        const __m256 z_in = pick(t[2].low, _mm256_set1_epi32(z)), z_out = pick(t[2].high, _mm256_set1_epi32(z + 1));
        for (int half = 1; half >= 0; --half)
            met = met << 8 |
                  lanes_of(_mm256_cmp_ps(_mm256_max_ps(in[half], z_in), _mm256_min_ps(out[half], z_out), _CMP_LE_OQ));
    }
    n.todo = mirrored(n.mask, b.flip) & met;
}

void walk(const PacketSet& set, Bundle& b, VoxelPacket packets[bundle_packets], unsigned alive) {
    BundleNode stack[VOXEL_MAX_LEVELS];
    const int top = int(set.grid.level_count) - 1;
    int level = top;
    open_node(b, set.grid.root, ivec3(0), 1 << (2 * level), stack[level]);
    while (alive) {
        BundleNode& n = stack[level];
        if (!n.todo) {
            if (++level > top) break;
            continue;
        }
        const uint bit = uint(std::countr_zero(n.todo));
        n.todo &= n.todo - 1;
        const uint digit = bit ^ b.flip;
        const uint rank = popcount64(mask64_below(n.mask, digit));
        const int edge = 1 << (2 * level);
        const ivec3 corner = n.lower + (ivec3(digit & 3, digit >> 2 & 3, digit >> 4) << 2 * level);
        const VoxelNode plain(uint(n.mask), uint(n.mask >> 32), n.link);
        const bool divided = (n.link & VOXEL_LINK_KIND) == VOXEL_LINK_CHILDREN;
        VoxelNode child;
        uint palette = 0;
        if (divided) {
            child = voxel_child(set.scene, set.grid, plain, rank);
            if (n.together) {
                --level;
                open_node(b, child, corner, 1 << (2 * level), stack[level]);
                continue;
            }
        } else {
            palette = voxel_palette(set.scene, set.grid, plain, rank);
        }
        __m256 near[3], far[3];
        for (int a = 0; a < 3; ++a) {
            const bool negative = b.flip >> 2 * a & 1;
            near[a] = _mm256_set1_ps(float(corner[a] + (negative ? edge : 0)));
            far[a] = _mm256_set1_ps(float(corner[a] + (negative ? 0 : edge)));
        }
        for (unsigned rest = alive; rest; rest &= rest - 1) {
            const int i = std::countr_zero(rest);
            VoxelPacket& p = packets[i];
            CubePass pass;
            for (int a = 0; a < 3; ++a) {
                pass.in[a] = _mm256_mul_ps(_mm256_sub_ps(near[a], p.ray.origin[a]), p.box.inverse[a]);
                pass.out[a] = _mm256_mul_ps(_mm256_sub_ps(far[a], p.ray.origin[a]), p.box.inverse[a]);
            }
            const unsigned visit = visiting(p, pass) & p.alive;
            if (!visit) continue;
            if (divided)
                walk_node(set, p, child, corner, level - 1, visit, _mm256_max_ps(pass.last_in, p.box.start),
                          _mm256_min_ps(pass.first_out, p.box.leave));
            else meet_cube(set, p, pass, corner, edge, palette, visit);
            if (!p.alive) alive &= ~(1u << i);
        }
    }
}

}  // namespace

bool bundle_closest(const SceneView& scene, uint grid, uint slot_first, uint instance, std::span<const Ray> rays,
                    bool streaming, Hit* hits) {
    PacketSet set = {scene, scene.voxel_grids.at[grid], grid, slot_first, instance, 0};
    Bundle b;
    if (!gather(set.grid, rays, b)) return false;
    set.flip = b.flip;
    VoxelPacket packets[bundle_packets];
    unsigned alive = 0;
    __m256 start = _mm256_set1_ps(INFINITE), leave = _mm256_set1_ps(-INFINITE);
    for (int i = 0; i < b.count; ++i) {
        VoxelPacket& p = packets[i];
        begin_packet(set, b.rays[i], &rays[std::size_t(i * packet_size)], 0xff, b.rays[i].t_max, p);
        if (!p.alive) continue;
        alive |= 1u << i;
        const __m256 enters = _mm256_cmp_ps(p.box.start, p.box.leave, _CMP_LT_OQ);
        start = _mm256_min_ps(start, _mm256_blendv_ps(start, p.box.start, enters));
        leave = _mm256_max_ps(leave, _mm256_blendv_ps(leave, p.box.leave, enters));
    }
    if (alive) {
        b.start = least(start);
        b.leave = greatest(leave);
        walk(set, b, packets, alive);
    }
    for (int i = 0; i < b.count; ++i) {
        Hit* const first = hits + i * packet_size;
        write_all(set, packets[i], streaming, first);
        if (packets[i].single)
            closest_one_by_one(scene, grid, slot_first, instance, packets[i].rays, packets[i].single, first);
    }
    return true;
}

}  // namespace spinel

SPINEL_AVX2_END
#endif
