#include "devices/cpu/voxel_packet.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#ifdef SPINEL_AVX2
SPINEL_AVX2_AS_ELSEWHERE_BEGIN

namespace spinel {

namespace {

using namespace kernels;

struct PacketAxis {
    __m256 origin;        // of the rays
    __m256 inverse;       // of their directions
    const __m256& still;  // all ones where the direction is zero; read if it is so somewhere
    bool any_still;
    bool negative;
};

// t at which the rays meet a plane; where a ray runs along it, it was met for ever or never.
__m256 plane_t(const PacketAxis& axis, __m256 plane) {
    const __m256 offset = _mm256_sub_ps(plane, axis.origin);
    const __m256 t = _mm256_mul_ps(offset, axis.inverse);
    if (!axis.any_still) [[likely]]
        return t;
    const __m256 zero = _mm256_setzero_ps();
    const __m256 passed =
        axis.negative ? _mm256_cmp_ps(offset, zero, _CMP_GT_OQ) : _mm256_cmp_ps(offset, zero, _CMP_LE_OQ);
    const __m256 ever = _mm256_blendv_ps(_mm256_set1_ps(INFINITE), _mm256_set1_ps(-INFINITE), passed);
    return _mm256_blendv_ps(t, ever, axis.still);
}

// A node that the packet is in.
struct PacketNode {
    __m256 t[3][5];  // where the rays meet the planes between its children, in the order in which they meet them
    mask64 mask;
    mask64 todo;  // mirrored
    uint link;
    ivec3 lower;
    unsigned lanes;
};

// Children, mirrored, on the far side of so many of the three planes of each axis; those on the near side of so many
// are these read backwards.
constexpr mask64 beyond[3][4] = {{~mask64(0), 0xeeeeeeeeeeeeeeeeu, 0xccccccccccccccccu, 0x8888888888888888u},
                                 {~mask64(0), 0xfff0fff0fff0fff0u, 0xff00ff00ff00ff00u, 0xf000f000f000f000u},
                                 {~mask64(0), 0xffffffffffff0000u, 0xffffffff00000000u, 0xffff000000000000u}};
constexpr mask64 before[3][4] = {{~mask64(0), 0x7777777777777777u, 0x3333333333333333u, 0x1111111111111111u},
                                 {~mask64(0), 0x0fff0fff0fff0fffu, 0x00ff00ff00ff00ffu, 0x000f000f000f000fu},
                                 {~mask64(0), 0x0000ffffffffffffu, 0x00000000ffffffffu, 0x000000000000ffffu}};

// Minus how many of three masks are set in each lane.
__m256i sum(__m256 x, __m256 y, __m256 z) {
    return _mm256_add_epi32(int_columns(x), _mm256_add_epi32(int_columns(y), int_columns(z)));
}

// A node at a place for the rays in `active`: its planes, and those of its children that a ray may visit between
// `enter` and `exit`. Its children are `edge` cells wide.
[[gnu::always_inline]] inline void open_node(const VoxelNode& node, ivec3 lower, int edge, const VoxelPacket& packet,
                                             std::uint32_t flip, unsigned active, __m256 enter, __m256 exit,
                                             PacketNode& n) {
    n.mask = make_mask64(node.mask_low, node.mask_high);
    n.link = node.link;
    n.lower = lower;
    n.lanes = active;
    // How many planes of each axis a ray has passed when it comes, and has still to pass when it goes: a byte for each
    // axis, below zero.
    __m256i passed[3], later[3];
    for (int a = 0; a < 3; ++a) {
        const bool negative = flip >> 2 * a & 1;
        const PacketAxis axis = {packet.ray.origin[a], packet.box.inverse[a], packet.box.still[a],
                                 bool(packet.still >> a & 1), negative};
        const __m256 step = _mm256_set1_ps(float(negative ? -edge : edge));
        __m256 plane = _mm256_set1_ps(float(lower[a] + (negative ? 4 * edge : 0)));
        for (int p = 0; p < 5; ++p, plane = _mm256_add_ps(plane, step)) n.t[a][p] = plane_t(axis, plane);
        const __m256* const t = n.t[a];
        passed[a] = sum(_mm256_cmp_ps(t[1], enter, _CMP_LT_OQ), _mm256_cmp_ps(t[2], enter, _CMP_LT_OQ),
                        _mm256_cmp_ps(t[3], enter, _CMP_LT_OQ));
        later[a] = sum(_mm256_cmp_ps(t[1], exit, _CMP_GT_OQ), _mm256_cmp_ps(t[2], exit, _CMP_GT_OQ),
                       _mm256_cmp_ps(t[3], exit, _CMP_GT_OQ));
    }
    const __m256i idle = _mm256_andnot_si256(lane_mask(active), _mm256_set1_epi32(0x030303));
    // The least of each byte over the rays that are there.
    const auto least = [&](const __m256i count[3]) {
        const __m256i xyz = _mm256_add_epi32(
            count[0], _mm256_add_epi32(_mm256_slli_epi32(count[1], 8), _mm256_slli_epi32(count[2], 16)));
        const __m256i bytes = _mm256_or_si256(_mm256_sub_epi32(_mm256_setzero_si256(), xyz), idle);
        return _mm_min_epu8(_mm256_castsi256_si128(bytes), _mm256_extracti128_si256(bytes, 1));
    };
    const __m128i in = least(passed), out = least(later);
    __m128i both = _mm_min_epu8(_mm_unpacklo_epi32(in, out), _mm_unpackhi_epi32(in, out));
    both = _mm_min_epu8(both, _mm_unpackhi_epi64(both, both));
    const auto counts = std::uint64_t(_mm_cvtsi128_si64(both));
    const mask64 range = beyond[0][counts & 3] & beyond[1][counts >> 8 & 3] & beyond[2][counts >> 16 & 3] &
                         before[0][counts >> 32 & 3] & before[1][counts >> 40 & 3] & before[2][counts >> 48 & 3];
    n.todo = mirrored(n.mask, flip) & range;
}

// Of planes met together, z counts as met last.
__m256i last_axis(__m256 x, __m256 y, __m256 z) {
    const __m256i one = _mm256_set1_epi32(1);
    const __m256i xy = _mm256_and_si256(_mm256_castps_si256(_mm256_cmp_ps(y, x, _CMP_GE_OQ)), one);
    const __m256 last = _mm256_and_ps(_mm256_cmp_ps(z, x, _CMP_GE_OQ), _mm256_cmp_ps(z, y, _CMP_GE_OQ));
    return _mm256_blendv_epi8(xy, _mm256_set1_epi32(2), _mm256_castps_si256(last));
}

// The face of the box by which the kernel says that a ray comes in: x before y before z.
__m256i first_axis(const __m256 enter[3]) {
    const __m256i yz =
        _mm256_add_epi32(_mm256_set1_epi32(2), _mm256_castps_si256(_mm256_cmp_ps(enter[1], enter[2], _CMP_GE_OQ)));
    const __m256 x =
        _mm256_and_ps(_mm256_cmp_ps(enter[0], enter[1], _CMP_GE_OQ), _mm256_cmp_ps(enter[0], enter[2], _CMP_GE_OQ));
    return _mm256_andnot_si256(_mm256_castps_si256(x), yz);
}

// The rays that meet each plane by which they come in before each by which they go out.
unsigned in_order(__m256 x_in, __m256 y_in, __m256 z_in, __m256 x_out, __m256 y_out, __m256 z_out) {
    const __m256 x = _mm256_and_ps(_mm256_cmp_ps(x_in, y_out, _CMP_LE_OQ), _mm256_cmp_ps(x_in, z_out, _CMP_LE_OQ));
    const __m256 y = _mm256_and_ps(_mm256_cmp_ps(y_in, x_out, _CMP_LT_OQ), _mm256_cmp_ps(y_in, z_out, _CMP_LE_OQ));
    const __m256 z = _mm256_and_ps(_mm256_cmp_ps(z_in, x_out, _CMP_LT_OQ), _mm256_cmp_ps(z_in, y_out, _CMP_LT_OQ));
    return unsigned(_mm256_movemask_ps(_mm256_and_ps(_mm256_and_ps(x, y), z)));
}

// Rows of four columns: row i is that of ray i.
void transpose(__m256 a, __m256 b, __m256 c, __m256 d, __m128 row[packet_size]) {
    const __m256 ab_low = _mm256_unpacklo_ps(a, b), ab_high = _mm256_unpackhi_ps(a, b);
    const __m256 cd_low = _mm256_unpacklo_ps(c, d), cd_high = _mm256_unpackhi_ps(c, d);
    const __m256 rows[4] = {_mm256_shuffle_ps(ab_low, cd_low, _MM_SHUFFLE(1, 0, 1, 0)),
                            _mm256_shuffle_ps(ab_low, cd_low, _MM_SHUFFLE(3, 2, 3, 2)),
                            _mm256_shuffle_ps(ab_high, cd_high, _MM_SHUFFLE(1, 0, 1, 0)),
                            _mm256_shuffle_ps(ab_high, cd_high, _MM_SHUFFLE(3, 2, 3, 2))};
    for (int i = 0; i < 4; ++i) {
        row[i] = _mm256_castps256_ps128(rows[i]);
        row[i + 4] = _mm256_extractf128_ps(rows[i], 1);
    }
}

// The cells of a solid cube where rays come in by one of its faces; those in `first` begin there.
void cells_of_cube(const VoxelPacket& packet, ivec3 cube, int edge, __m256 t, __m256i axis, unsigned first,
                   unsigned which, __m256i cell[3]) {
    const RayColumns& ray = packet.ray;
    unsigned doubtful = 0;
    for (int a = 0; a < 3; ++a) {
        const __m256i on_axis = _mm256_cmpeq_epi32(axis, _mm256_set1_epi32(a));
        const __m256i lower = _mm256_set1_epi32(cube[a]), top = _mm256_set1_epi32(cube[a] + edge - 1);
        const __m256 p = ray.origin[a] + t * ray.direction[a];
        cell[a] = _mm256_max_epi32(_mm256_min_epi32(_mm256_cvttps_epi32(p), top), lower);
        const __m256 fraction = _mm256_sub_ps(p, _mm256_cvtepi32_ps(cell[a]));
        const __m256 doubt = _mm256_mul_ps(packet.box.reach, _mm256_set1_ps(1e-6f));
        const __m256 sure = _mm256_and_ps(_mm256_cmp_ps(fraction, doubt, _CMP_GE_OQ),
                                          _mm256_cmp_ps(fraction, _mm256_sub_ps(_mm256_set1_ps(1), doubt), _CMP_LE_OQ));
        doubtful |= ~lanes_of(_mm256_or_ps(sure, float_columns(on_axis)));
        const __m256i negative = int_columns(_mm256_cmp_ps(ray.direction[a], _mm256_setzero_ps(), _CMP_LT_OQ));
        cell[a] = _mm256_blendv_epi8(cell[a], _mm256_blendv_epi8(lower, top, negative), on_axis);
    }
    doubtful &= which;
    if (!doubtful) [[likely]]
        return;
    alignas(32) int cells[3][packet_size], axes[packet_size];
    alignas(32) float start[packet_size];
    for (int a = 0; a < 3; ++a) _mm256_store_si256(reinterpret_cast<__m256i*>(cells[a]), cell[a]);
    _mm256_store_si256(reinterpret_cast<__m256i*>(axes), axis);
    _mm256_store_ps(start, t);
    for (; doubtful; doubtful &= doubtful - 1) {
        const int i = std::countr_zero(doubtful);
        const Ray& r = packet.rays[i];
        for (int a = 0; a < 3; ++a)
            if (a != axes[i])
                cells[a][i] = voxel_cell(r.origin[a], r.direction[a], safe_inverse(r.direction[a]), start[i],
                                         (first >> i & 1) || a < axes[i], cube[a], cube[a] + edge - 1);
    }
    for (int a = 0; a < 3; ++a) cell[a] = _mm256_load_si256(reinterpret_cast<const __m256i*>(cells[a]));
}

// As kernels::voxel_hit for all eight, as rows of four numbers of a Hit; where nothing was found, as no_hit.
struct HitRows {
    __m128 row[3][packet_size];
};

// A number for each axis, and one for no_axis.
__m256 by_axis(__m256i axis, float x, float y, float z, float none) {
    return _mm256_permutevar_ps(_mm256_setr_ps(x, y, z, none, x, y, z, none), axis);
}
__m256 by_axis(__m256i axis, uint x, uint y, uint z, uint none) {
    return by_axis(axis, std::bit_cast<float>(x), std::bit_cast<float>(y), std::bit_cast<float>(z),
                   std::bit_cast<float>(none));
}

HitRows hit_rows(const PacketSet& set, const VoxelPacket& packet) {
    const RayColumns& ray = packet.ray;
    const __m256 zero = _mm256_setzero_ps(), one = _mm256_set1_ps(1);
    const __m256i axis = packet.axis;
    // Rays come in by the faces that look the other way.
    const auto down = [&](int a) { return set.flip >> 2 * a & 1; };
    const auto normal = [&](int a) { return down(a) ? 1.0f : -1.0f; };
    __m256 p[3];
    for (int a = 0; a < 3; ++a) {
        p[a] = ray.origin[a] + packet.t * ray.direction[a];  // as ray_at(), contracted or not
        p[a] = _mm256_min_ps(_mm256_max_ps(_mm256_sub_ps(p[a], _mm256_cvtepi32_ps(packet.cell[a])), zero), one);
    }
    const __m256 on_y = by_axis(axis, 0u, ~0u, 0u, 0u), on_z = by_axis(axis, 0u, 0u, ~0u, 0u);
    const __m256 found = by_axis(axis, ~0u, ~0u, ~0u, 0u);
    const __m256 u = _mm256_blendv_ps(_mm256_blendv_ps(p[1], p[2], on_y), p[0], on_z);
    const __m256 v = _mm256_blendv_ps(_mm256_blendv_ps(p[2], p[0], on_y), p[1], on_z);

    static_assert(sizeof(Hit) == 12 * sizeof(float) && offsetof(Hit, uv) == 16 && offsetof(Hit, normal) == 36);
    HitRows rows;
    transpose(packet.t, by_axis(axis, set.instance, set.instance, set.instance, NONE), float_columns(packet.palette),
              by_axis(axis, down(0), 2 + down(1), 4 + down(2), 0u), rows.row[0]);
    transpose(_mm256_and_ps(u, found), _mm256_and_ps(v, found), float_columns(packet.cell[0]),
              float_columns(packet.cell[1]), rows.row[1]);
    transpose(float_columns(packet.cell[2]), by_axis(axis, normal(0), 0.0f, 0.0f, 0.0f),
              by_axis(axis, 0.0f, normal(1), 0.0f, 0.0f), by_axis(axis, 0.0f, 0.0f, normal(2), 0.0f), rows.row[2]);
    return rows;
}

void store_row(__m128 row, bool streaming, float* at) {
    if (streaming) _mm_stream_ps(at, row);
    else _mm_storeu_ps(at, row);
}

}  // namespace

bool are_neighbours(const RayColumns& ray, unsigned lanes) {
    const __m256* const d = ray.direction;
    const __m256 longest = front(_mm256_max_ps(_mm256_max_ps(magnitude(d[0]), magnitude(d[1])), magnitude(d[2])));
    const __m256 turn = _mm256_mul_ps(longest, _mm256_set1_ps(neighbour_turn));
    __m256 near = all_lanes();
    for (int a = 0; a < 3; ++a) {
        const __m256 turned = magnitude(_mm256_sub_ps(d[a], front(d[a])));
        const __m256 moved = magnitude(_mm256_sub_ps(ray.origin[a], front(ray.origin[a])));
        near = _mm256_and_ps(near, _mm256_and_ps(_mm256_cmp_ps(turned, turn, _CMP_LE_OQ),
                                                 _mm256_cmp_ps(moved, _mm256_set1_ps(neighbour_cells), _CMP_LE_OQ)));
        const unsigned up = lanes_of(_mm256_cmp_ps(d[a], _mm256_set1_ps(TINY_DIRECTION), _CMP_GE_OQ)) & lanes;
        const unsigned down = lanes_of(_mm256_cmp_ps(d[a], _mm256_set1_ps(-TINY_DIRECTION), _CMP_LE_OQ)) & lanes;
        if (up && down) return false;
    }
    return (lanes_of(near) & lanes) == lanes;
}

void begin_packet(const PacketSet& set, const RayColumns& ray, const Ray* rays, unsigned lanes, __m256 limit,
                  VoxelPacket& p) {
    p.ray = ray;
    p.rays = rays;
    p.limit = limit;
    p.box = pass_box(set.grid.size, ray, limit);
    p.single = lanes & ~p.box.exact;
    p.alive = lanes_of(_mm256_cmp_ps(p.box.start, p.box.leave, _CMP_LT_OQ)) & lanes & p.box.exact;
    p.still = 0;
    for (int a = 0; a < 3; ++a)
        if (lanes_of(p.box.still[a]) & p.alive) p.still |= 1u << a;
    begin_hits(p);
}

std::uint32_t flip_of(const VoxelPacket& p) {
    std::uint32_t flip = 0;
    for (int a = 0; a < 3; ++a)
        if (lanes_of(p.ray.direction[a]) & p.alive & ~lanes_of(p.box.still[a])) flip |= 3u << (2 * a);
    return flip;
}

void meet_cube(const PacketSet& set, VoxelPacket& p, const CubePass& pass, ivec3 lower, int edge, uint palette,
               unsigned lanes) {
    if (voxel_class(set.scene, set.slot_first, palette) == VOXEL_AIR) return;
    const __m256 in = pass.last_in;
    const unsigned ties = lanes_of(_mm256_cmp_ps(in, pass.first_out, _CMP_EQ_OQ)) & lanes;
    if (ties) [[unlikely]]
        lanes &= ~ties | in_order(pass.in[0], pass.in[1], pass.in[2], pass.out[0], pass.out[1], pass.out[2]);
    p.alive &= ~lanes;
    // Where the walk begins: on a face of the box, or, for the kernel to tell, inside of something.
    const __m256 begins = _mm256_cmp_ps(in, p.box.start, _CMP_LE_OQ);
    const unsigned first = lanes_of(begins) & lanes;
    const unsigned inside = first & ~lanes_of(p.box.from_outside);
    p.single |= inside;
    const unsigned hit = lanes & ~inside;
    if (!hit) return;
    // The plane met last; of the box that met first.
    __m256i axis = last_axis(pass.in[0], pass.in[1], pass.in[2]);
    if (first) [[unlikely]]
        axis = _mm256_blendv_epi8(axis, first_axis(p.box.enter), int_columns(begins));
    __m256i cell[3];
    if (edge == 1)
        for (int a = 0; a < 3; ++a) cell[a] = _mm256_set1_epi32(lower[a]);
    else cells_of_cube(p, lower, edge, in, axis, first, hit, cell);
    const __m256i now = lane_mask(hit);
    p.t = _mm256_blendv_ps(p.t, in, float_columns(now));
    p.axis = _mm256_blendv_epi8(p.axis, axis, now);
    p.palette = _mm256_blendv_epi8(p.palette, _mm256_set1_epi32(int(palette)), now);
    for (int a = 0; a < 3; ++a) p.cell[a] = _mm256_blendv_epi8(p.cell[a], cell[a], now);
    p.found |= hit;
}

void walk_node(const PacketSet& set, VoxelPacket& p, const VoxelNode& node, ivec3 lower, int level, unsigned lanes,
               __m256 enter, __m256 exit) {
    PacketNode stack[VOXEL_MAX_LEVELS];
    const int top = level;
    open_node(node, lower, 1 << (2 * level), p, set.flip, lanes, enter, exit, stack[level]);
    while (p.alive) {
        PacketNode& n = stack[level];
        const unsigned here = n.lanes & p.alive;
        if (!here || !n.todo) {
            if (++level > top) break;
            continue;
        }
        const uint bit = uint(std::countr_zero(n.todo));
        n.todo &= n.todo - 1;
        const uint ix = bit & 3, iy = bit >> 2 & 3, iz = bit >> 4;
        CubePass pass;
        pass.in[0] = n.t[0][ix], pass.in[1] = n.t[1][iy], pass.in[2] = n.t[2][iz];
        pass.out[0] = n.t[0][ix + 1], pass.out[1] = n.t[1][iy + 1], pass.out[2] = n.t[2][iz + 1];
        const unsigned visit = visiting(p, pass) & here;
        if (!visit) continue;

        const uint digit = bit ^ set.flip;
        const uint rank = popcount64(mask64_below(n.mask, digit));
        const ivec3 corner = n.lower + (ivec3(digit & 3, digit >> 2 & 3, digit >> 4) << 2 * level);
        const VoxelNode plain(uint(n.mask), uint(n.mask >> 32), n.link);
        if ((n.link & VOXEL_LINK_KIND) == VOXEL_LINK_CHILDREN) {
            --level;
            open_node(voxel_child(set.scene, set.grid, plain, rank), corner, 1 << (2 * level), p, set.flip, visit,
                      _mm256_max_ps(pass.last_in, p.box.start), _mm256_min_ps(pass.first_out, p.box.leave),
                      stack[level]);
        } else {
            meet_cube(set, p, pass, corner, 1 << (2 * level), voxel_palette(set.scene, set.grid, plain, rank), visit);
        }
    }
}

void write_found(const PacketSet& set, const VoxelPacket& packet, Hit* hits) {
    if (!packet.found) return;
    const HitRows rows = hit_rows(set, packet);
    for (unsigned rest = packet.found; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        for (int k = 0; k < 3; ++k) _mm_storeu_ps(&hits[i].t + 4 * k, rows.row[k][i]);
    }
}

void write_all(const PacketSet& set, const VoxelPacket& packet, bool streaming, Hit* hits) {
    const HitRows rows = hit_rows(set, packet);
    for (int i = 0; i < packet_size; ++i)
        for (int k = 0; k < 3; ++k) store_row(rows.row[k][i], streaming, &hits[i].t + 4 * k);
}

void write_none(std::span<const Ray> rays, bool streaming, Hit* hits) {
    const __m128 zero = _mm_setzero_ps();
    const __m128 none = _mm_castsi128_ps(_mm_setr_epi32(0, int(NONE), 0, 0));
    for (std::size_t i = 0; i < rays.size(); ++i) {
        float* const at = &hits[i].t;
        store_row(_mm_move_ss(none, _mm_load_ss(&rays[i].t_max)), streaming, at);
        store_row(zero, streaming, at + 4);
        store_row(zero, streaming, at + 8);
    }
}

unsigned packet_closest(const SceneView& scene, uint grid, uint slot_first, uint instance, const RayColumns& ray,
                        const Ray* rays, unsigned lanes, Hit* hits) {
    PacketSet set = {scene, scene.voxel_grids.at[grid], grid, slot_first, instance, 0};
    alignas(32) float limits[packet_size];
    for (int i = 0; i < packet_size; ++i) limits[i] = lanes >> i & 1 ? hits[i].t : -INFINITE;
    VoxelPacket packet;
    begin_packet(set, ray, rays, lanes, _mm256_load_ps(limits), packet);
    set.flip = flip_of(packet);
    if (packet.alive)
        walk_node(set, packet, set.grid.root, ivec3(0), int(set.grid.level_count) - 1, packet.alive, packet.box.start,
                  packet.box.leave);
    write_found(set, packet, hits);
    return packet.found | closest_one_by_one(scene, grid, slot_first, instance, rays, packet.single, hits);
}

}  // namespace spinel

SPINEL_AVX2_END
#endif
