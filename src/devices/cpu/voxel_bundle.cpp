// Up to 64 neighbours, eight packets, against a set of voxels. What lies in front of all of them is found once: the
// interval of t in which any of them meets a plane tells the children of a node that any may visit, 64 of them in some
// fifty instructions. Of cells, and of nodes that are narrower than the bundle, the same intervals of each packet,
// eight in a register, tell which packets are to be asked.
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

// Rays that go the same way along each axis. Each lane is a beam.
struct Beam {
    __m256 foremost[3], hindmost[3];  // of the origins, along the rays
    Range inverse[3];                 // of the directions
};

struct Bundle {
    VoxelPacket packets[bundle_packets];
    int count;
    std::uint32_t flip;
    Beam all, each;       // all rays in all lanes, a packet in each lane
    __m256 reach;         // no coordinate is larger on the way through the box
    __m256 start, leave;  // no ray's walk begins before or ends after
    float width, growth;  // the rays' places differ by no more than width + t·growth along any axis
};

struct Least {
    static __m256 of(__m256 x, __m256 y) { return _mm256_min_ps(x, y); }
};
struct Greatest {
    static __m256 of(__m256 x, __m256 y) { return _mm256_max_ps(x, y); }
};

// The least or the greatest number in any lane, in all lanes.
template <class Choose>
__m256 in_any(__m256 x) {
    x = Choose::of(x, _mm256_permute2f128_ps(x, x, 1));
    x = Choose::of(x, _mm256_shuffle_ps(x, x, _MM_SHUFFLE(1, 0, 3, 2)));
    return Choose::of(x, _mm256_shuffle_ps(x, x, _MM_SHUFFLE(2, 3, 0, 1)));
}

// The least or the greatest number of x[i] in lane i.
template <class Choose>
__m256 in_each(const __m256 x[packet_size]) {
    __m256 four[2];
    for (int k = 0; k < 2; ++k, x += 4) {
        const __m256 ab = Choose::of(_mm256_unpacklo_ps(x[0], x[1]), _mm256_unpackhi_ps(x[0], x[1]));
        const __m256 cd = Choose::of(_mm256_unpacklo_ps(x[2], x[3]), _mm256_unpackhi_ps(x[2], x[3]));
        four[k] = Choose::of(_mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(1, 0, 1, 0)),
                             _mm256_shuffle_ps(ab, cd, _MM_SHUFFLE(3, 2, 3, 2)));
    }
    return Choose::of(_mm256_permute2f128_ps(four[0], four[1], 0x20), _mm256_permute2f128_ps(four[0], four[1], 0x31));
}

__m256 pick(__m256 x, __m256i lanes) { return _mm256_permutevar8x32_ps(x, lanes); }
float number(__m256 x) { return _mm256_cvtss_f32(x); }

void widen(Range& range, __m256 x) {
    range.low = _mm256_min_ps(range.low, x);
    range.high = _mm256_max_ps(range.high, x);
}

// Whether numbers within a range are all that near to one of them.
__m256 is_near(const Range& range, __m256 one, __m256 distance) {
    return _mm256_and_ps(_mm256_cmp_ps(_mm256_sub_ps(range.high, one), distance, _CMP_LE_OQ),
                         _mm256_cmp_ps(_mm256_sub_ps(one, range.low), distance, _CMP_LE_OQ));
}

// Whether all rays are neighbours, as are_neighbours() means it, that stand still along no axis, and near enough for
// whole cells to be told from rounding.
bool gather(const VoxelGrid& grid, std::span<const Ray> rays, Bundle& b) {
    b.count = int(rays.size() / packet_size);
    Range origin[3], direction[3];
    __m256 first_origin[3], first_direction[3], turn = _mm256_setzero_ps();
    __m256 no_number = _mm256_setzero_ps();  // ranges do not tell
    const auto are_near = [&] {
        __m256 near = all_lanes();
        for (int a = 0; a < 3; ++a)
            near = _mm256_and_ps(near,
                                 _mm256_and_ps(is_near(direction[a], first_direction[a], turn),
                                               is_near(origin[a], first_origin[a], _mm256_set1_ps(neighbour_cells))));
        return lanes_of(near) == 0xff;
    };
    for (int i = 0; i < b.count; ++i) {
        VoxelPacket& p = b.packets[i];
        p.rays = &rays[std::size_t(i) * packet_size];
        p.ray = ray_columns(p.rays);
        // The next bundle most likely follows; if not, no pointer may point there.
        const auto next = reinterpret_cast<std::uintptr_t>(p.rays) + bundle_packets * packet_size * sizeof(Ray);
        for (std::size_t at = 0; at < packet_size * sizeof(Ray); at += cache_line)
            _mm_prefetch(reinterpret_cast<const char*>(next + at), _MM_HINT_T0);  // NOLINT(performance-no-int-to-ptr)
        for (int a = 0; a < 3; ++a) {
            const __m256 o = p.ray.origin[a], d = p.ray.direction[a];
            no_number = _mm256_or_ps(no_number, _mm256_cmp_ps(o, d, _CMP_UNORD_Q));
            if (i == 0) {
                first_origin[a] = front(o);
                first_direction[a] = front(d);
                turn = _mm256_max_ps(turn, magnitude(first_direction[a]));
                origin[a] = {o, o};
                direction[a] = {d, d};
            } else {
                widen(origin[a], o);
                widen(direction[a], d);
            }
        }
        if (i == 0) {
            turn = _mm256_mul_ps(turn, _mm256_set1_ps(neighbour_turn));
            if (!are_near()) return false;
        }
    }
    if (!are_near() || lanes_of(no_number)) return false;
    const __m256 one = _mm256_set1_ps(1);
    b.flip = 0;
    b.width = b.growth = 0;
    float far = 0;
    for (int a = 0; a < 3; ++a) {
        const __m256 low = in_any<Least>(direction[a].low), high = in_any<Greatest>(direction[a].high);
        if (number(low) <= -TINY_DIRECTION && number(high) <= -TINY_DIRECTION) b.flip |= 3u << (2 * a);
        else if (!(number(low) >= TINY_DIRECTION)) return false;
        if (!(std::max(-number(low), number(high)) < longest_direction)) return false;
        b.all.inverse[a] = {_mm256_div_ps(one, high), _mm256_div_ps(one, low)};
        const __m256 lowest = in_any<Least>(origin[a].low), highest = in_any<Greatest>(origin[a].high);
        b.all.foremost[a] = number(low) > 0 ? highest : lowest;
        b.all.hindmost[a] = number(low) > 0 ? lowest : highest;
        b.growth = std::max(b.growth, number(high) - number(low));
        b.width = std::max(b.width, number(highest) - number(lowest));
        far = std::max({far, -number(lowest), number(highest)});
    }
    const float reach = far + float(std::max({grid.size.x, grid.size.y, grid.size.z}));
    b.reach = _mm256_set1_ps(reach);
    return reach < farthest_exact;
}

// As begin_packet() for rays of a bundle.
void begin_bundled(const PacketSet& set, const Bundle& b, VoxelPacket& p) {
    p.limit = p.ray.t_max;
    BoxPass& box = p.box;
    box.start = p.ray.t_min;
    box.leave = p.limit;
    box.reach = b.reach;
    for (int a = 0; a < 3; ++a) {
        const bool negative = set.flip >> 2 * a & 1;
        const __m256 last = _mm256_set1_ps(float(set.grid.size[a])), zero = _mm256_setzero_ps();
        box.inverse[a] = _mm256_div_ps(_mm256_set1_ps(1), p.ray.direction[a]);
        box.enter[a] = _mm256_mul_ps(_mm256_sub_ps(negative ? last : zero, p.ray.origin[a]), box.inverse[a]);
        box.leave = _mm256_min_ps(
            box.leave, _mm256_mul_ps(_mm256_sub_ps(negative ? zero : last, p.ray.origin[a]), box.inverse[a]));
    }
    const __m256 enter = _mm256_max_ps(_mm256_max_ps(box.enter[0], box.enter[1]), box.enter[2]);
    box.from_outside = _mm256_cmp_ps(enter, box.start, _CMP_GT_OQ);
    box.start = _mm256_max_ps(box.start, enter);
    p.alive = lanes_of(_mm256_cmp_ps(box.start, box.leave, _CMP_LT_OQ));
    p.still = p.single = 0;
    begin_hits(p);
}

// The packets as beams.
void part(Bundle& b) {
    for (int a = 0; a < 3; ++a) {
        __m256 origin[bundle_packets], inverse[bundle_packets];
        for (int i = 0; i < bundle_packets; ++i) {
            const VoxelPacket& p = b.packets[i < b.count ? i : 0];
            origin[i] = p.ray.origin[a];
            inverse[i] = p.box.inverse[a];
        }
        const __m256 lowest = in_each<Least>(origin), highest = in_each<Greatest>(origin);
        const bool negative = b.flip >> 2 * a & 1;
        b.each.foremost[a] = negative ? lowest : highest;
        b.each.hindmost[a] = negative ? highest : lowest;
        b.each.inverse[a] = {in_each<Least>(inverse), in_each<Greatest>(inverse)};
    }
}

// When the first and the last of the rays meet planes of an axis.
__m256 earliest(const Beam& beam, int axis, __m256 plane) {
    const __m256 way = _mm256_sub_ps(plane, beam.foremost[axis]);
    return _mm256_min_ps(_mm256_mul_ps(way, beam.inverse[axis].low), _mm256_mul_ps(way, beam.inverse[axis].high));
}
__m256 latest(const Beam& beam, int axis, __m256 plane) {
    const __m256 way = _mm256_sub_ps(plane, beam.hindmost[axis]);
    return _mm256_max_ps(_mm256_mul_ps(way, beam.inverse[axis].low), _mm256_mul_ps(way, beam.inverse[axis].high));
}

// Whether a ray may come into the box.
bool may_enter(const PacketSet& set, const Bundle& b, __m256 t_min, __m256 t_max) {
    Range enter = {t_min, t_min}, leave = {t_max, t_max};
    for (int a = 0; a < 3; ++a) {
        const float last = float(set.grid.size[a]);
        const bool negative = b.flip >> 2 * a & 1;
        enter.low = _mm256_max_ps(enter.low, earliest(b.all, a, _mm256_set1_ps(negative ? last : 0)));
        leave.high = _mm256_min_ps(leave.high, latest(b.all, a, _mm256_set1_ps(negative ? 0 : last)));
    }
    return lanes_of(_mm256_cmp_ps(enter.low, leave.high, _CMP_LT_OQ));
}

// A node that the bundle is in.
struct BundleNode {
    mask64 mask;
    mask64 todo;  // mirrored
    uint link;
    ivec3 lower;
    bool together;  // the children are no narrower than the bundle
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
        const __m256 planes = negative ? _mm256_sub_ps(first, steps) : _mm256_add_ps(first, steps);
        t[a] = {earliest(b.all, a, planes), latest(b.all, a, planes)};
    }
    const __m256 enter =
        _mm256_max_ps(_mm256_max_ps(b.start, front(t[0].low)), _mm256_max_ps(front(t[1].low), front(t[2].low)));
    n.together = b.width + number(enter) * b.growth <= float(edge);

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

void walk(const PacketSet& set, Bundle& b, unsigned alive) {
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
        __m256 near[3], far[3], enter = b.start, leave = b.leave;
        for (int a = 0; a < 3; ++a) {
            const bool negative = b.flip >> 2 * a & 1;
            near[a] = _mm256_set1_ps(float(corner[a] + (negative ? edge : 0)));
            far[a] = _mm256_set1_ps(float(corner[a] + (negative ? 0 : edge)));
            enter = _mm256_max_ps(enter, earliest(b.each, a, near[a]));
            leave = _mm256_min_ps(leave, latest(b.each, a, far[a]));
        }
        for (unsigned rest = alive & lanes_of(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ)); rest; rest &= rest - 1) {
            const int i = std::countr_zero(rest);
            VoxelPacket& p = b.packets[i];
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
    __m256 t_min = b.packets[0].ray.t_min, t_max = b.packets[0].ray.t_max;
    for (int i = 1; i < b.count; ++i) {
        t_min = _mm256_min_ps(t_min, b.packets[i].ray.t_min);
        t_max = _mm256_max_ps(t_max, b.packets[i].ray.t_max);
    }
    if (!may_enter(set, b, t_min, t_max)) {
        write_none(rays, streaming, hits);
        return true;
    }
    unsigned alive = 0;
    __m256 start = _mm256_set1_ps(INFINITE), leave = _mm256_set1_ps(-INFINITE);
    for (int i = 0; i < b.count; ++i) {
        VoxelPacket& p = b.packets[i];
        begin_bundled(set, b, p);
        if (!p.alive) continue;
        alive |= 1u << i;
        const __m256 enters = _mm256_cmp_ps(p.box.start, p.box.leave, _CMP_LT_OQ);
        start = _mm256_min_ps(start, _mm256_blendv_ps(start, p.box.start, enters));
        leave = _mm256_max_ps(leave, _mm256_blendv_ps(leave, p.box.leave, enters));
    }
    if (alive) {
        part(b);
        b.start = in_any<Least>(start);
        b.leave = in_any<Greatest>(leave);
        walk(set, b, alive);
    }
    for (int i = 0; i < b.count; ++i) {
        const VoxelPacket& p = b.packets[i];
        Hit* const first = hits + i * packet_size;
        write_all(set, p, streaming, first);
        if (p.single) closest_one_by_one(scene, grid, slot_first, instance, p.rays, p.single, first);
    }
    return true;
}

}  // namespace spinel

SPINEL_AVX2_END
#endif
