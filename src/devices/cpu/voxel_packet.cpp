// Eight coherent rays against a set of voxels: they go down the tree together, so that a node is loaded, its planes are
// met and its children sorted once for all.
//
// A walk from cell to cell is an order of events: the ray meets plane p of an axis at t, earlier t first, at equal t x
// before y before z (kernels/voxels.h). So a ray visits a cell exactly if it meets each plane by which it comes in
// before each plane by which it goes out, and that can be asked of any cell, or node, by itself. Mirrored so that all
// directions are positive, the children of a node in the order of their bits are in front-to-back order, and the first
// cell that is not air is the hit: the very one, bit for bit, that the kernel finds.
//
// Rays of different octants, far away, or starting in something go one by one.

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "devices/cpu/voxel_walk.h"

namespace spinel {

namespace {

unsigned closest_one_by_one(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                            const kernels::Ray* rays, unsigned lanes, kernels::Hit* hits) {
    unsigned found = 0;
    for (; lanes; lanes &= lanes - 1) {
        const int i = std::countr_zero(lanes);
        const float before = hits[i].t;
        cpu_voxels_closest(scene, grid, slot_first, rays[i], hits[i]);
        found |= unsigned(hits[i].t < before) << i;
    }
    return found;
}

#ifdef __AVX2__

struct PacketAxis {
    __m256 origin;   // of the rays
    __m256 inverse;  // of their directions
    __m256 still;    // all ones where the direction is zero
    bool any_still;
    bool negative;
};

// t at which the rays meet a plane; where a ray runs along it, it was met for ever or never.
__m256 plane_t(const PacketAxis& axis, int plane) {
    const __m256 p = _mm256_set1_ps(float(plane));
    const __m256 offset = _mm256_sub_ps(p, axis.origin);
    const __m256 t = _mm256_mul_ps(offset, axis.inverse);
    if (!axis.any_still) [[likely]]
        return t;
    const __m256 zero = _mm256_setzero_ps();
    const __m256 passed =
        axis.negative ? _mm256_cmp_ps(offset, zero, _CMP_GT_OQ) : _mm256_cmp_ps(offset, zero, _CMP_LE_OQ);
    const __m256 ever = _mm256_blendv_ps(_mm256_set1_ps(kernels::INFINITE), _mm256_set1_ps(-kernels::INFINITE), passed);
    return _mm256_blendv_ps(t, ever, axis.still);
}

// The bits of a node's mask with axes turned round: `flip` has 3, 12, 48 set for x, y, z.
std::uint64_t mirrored(std::uint64_t m, std::uint32_t flip) {
    if (flip & 3) {
        m = (m >> 1 & 0x5555555555555555u) | (m & 0x5555555555555555u) << 1;
        m = (m >> 2 & 0x3333333333333333u) | (m & 0x3333333333333333u) << 2;
    }
    if (flip & 12) {
        m = (m >> 4 & 0x0f0f0f0f0f0f0f0fu) | (m & 0x0f0f0f0f0f0f0f0fu) << 4;
        m = (m >> 8 & 0x00ff00ff00ff00ffu) | (m & 0x00ff00ff00ff00ffu) << 8;
    }
    if (flip & 48) {
        m = (m >> 16 & 0x0000ffff0000ffffu) | (m & 0x0000ffff0000ffffu) << 16;
        m = m >> 32 | m << 32;
    }
    return m;
}

// A node that the packet is in.
struct PacketNode {
    __m256 t[3][5];  // where the rays meet the planes between its children, in the order in which they meet them
    std::uint64_t mask;
    std::uint64_t todo;  // mirrored
    kernels::uint link;
    glm::ivec3 lower;
    unsigned lanes;
};

// A node at a place for the rays in `active`: its planes, and those of its children that a ray may visit between
// `enter` and `exit`. Its children are `edge` cells wide.
void open_node(const kernels::VoxelNode& node, glm::ivec3 lower, int edge, const PacketAxis axes[3], std::uint32_t flip,
               unsigned active, __m256 enter, __m256 exit, PacketNode& n) {
    n.mask = node.mask_low | std::uint64_t(node.mask_high) << 32;
    n.link = node.link;
    n.lower = lower;
    n.lanes = active;
    std::uint64_t range = ~std::uint64_t(0);
    // Children beyond plane p (bits), and before it.
    constexpr std::uint64_t beyond[3][3] = {{0xeeeeeeeeeeeeeeeeu, 0xccccccccccccccccu, 0x8888888888888888u},
                                            {0xfff0fff0fff0fff0u, 0xff00ff00ff00ff00u, 0xf000f000f000f000u},
                                            {0xffffffffffff0000u, 0xffffffff00000000u, 0xffff000000000000u}};
    for (int a = 0; a < 3; ++a) {
        const bool negative = axes[a].negative;
        const int first = lower[a] + (negative ? 4 * edge : 0), step = negative ? -edge : edge;
        for (int p = 0; p < 5; ++p) n.t[a][p] = plane_t(axes[a], first + p * step);
        for (int p = 1; p < 4; ++p) {
            const auto passed = unsigned(_mm256_movemask_ps(_mm256_cmp_ps(n.t[a][p], enter, _CMP_LT_OQ)));
            const auto later = unsigned(_mm256_movemask_ps(_mm256_cmp_ps(n.t[a][p], exit, _CMP_GT_OQ)));
            // Without branches: they would be taken by chance.
            range &= beyond[a][p - 1] | (std::uint64_t(0) - std::uint64_t((passed & active) != active));
            range &= ~beyond[a][p - 1] | (std::uint64_t(0) - std::uint64_t((later & active) != active));
        }
    }
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

// Four columns of rays' members from `at` on.
void load_columns(const float* at, __m256 column[4]) {
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

// A cube that rays hit: where, on which axis' face, which cube, and of what.
struct PacketHit {
    __m256 t;
    __m256i axis;
    glm::ivec3 lower;
    int edge;
    kernels::uint palette;
};

// As kernels::voxel_hit, for the rays in `which`; those in `first` hit it where the walk begins.
void write_hits(const PacketHit& hit, const __m256 o[3], const __m256 d[3], __m256 reach, const kernels::Ray* rays,
                unsigned first, unsigned which, kernels::Hit* hits) {
    using namespace kernels;
    __m256 on_axis[3], p[3], negative[3];
    __m256i cell[3];
    unsigned doubtful = 0;
    for (int a = 0; a < 3; ++a) {
        on_axis[a] = _mm256_castsi256_ps(_mm256_cmpeq_epi32(hit.axis, _mm256_set1_epi32(a)));
        negative[a] = _mm256_cmp_ps(d[a], _mm256_setzero_ps(), _CMP_LT_OQ);
        p[a] = o[a] + hit.t * d[a];  // as ray_at(), contracted or not
        const __m256i lower = _mm256_set1_epi32(hit.lower[a]), top = _mm256_set1_epi32(hit.lower[a] + hit.edge - 1);
        cell[a] = lower;
        if (hit.edge == 1) continue;
        cell[a] = _mm256_max_epi32(_mm256_min_epi32(_mm256_cvttps_epi32(p[a]), top), lower);
        const __m256 fraction = _mm256_sub_ps(p[a], _mm256_cvtepi32_ps(cell[a]));
        const __m256 doubt = _mm256_mul_ps(reach, _mm256_set1_ps(1e-6f));
        const __m256 sure = _mm256_and_ps(_mm256_cmp_ps(fraction, doubt, _CMP_GE_OQ),
                                          _mm256_cmp_ps(fraction, _mm256_sub_ps(_mm256_set1_ps(1), doubt), _CMP_LE_OQ));
        doubtful |= ~unsigned(_mm256_movemask_ps(_mm256_or_ps(sure, on_axis[a])));
        cell[a] = _mm256_blendv_epi8(cell[a], _mm256_blendv_epi8(lower, top, _mm256_castps_si256(negative[a])),
                                     _mm256_castps_si256(on_axis[a]));
    }
    doubtful &= which;
    if (doubtful) [[unlikely]] {
        alignas(32) int cells[3][packet_size], axes[packet_size];
        alignas(32) float t[packet_size];
        for (int a = 0; a < 3; ++a) _mm256_store_si256(reinterpret_cast<__m256i*>(cells[a]), cell[a]);
        _mm256_store_si256(reinterpret_cast<__m256i*>(axes), hit.axis);
        _mm256_store_ps(t, hit.t);
        for (; doubtful; doubtful &= doubtful - 1) {
            const int i = std::countr_zero(doubtful);
            const Ray& ray = rays[i];
            for (int a = 0; a < 3; ++a)
                if (a != axes[i])
                    cells[a][i] =
                        voxel_cell(ray.origin[a], ray.direction[a], safe_inverse(ray.direction[a]), t[i],
                                   (first >> i & 1) || a < axes[i], hit.lower[a], hit.lower[a] + hit.edge - 1);
        }
        for (int a = 0; a < 3; ++a) cell[a] = _mm256_load_si256(reinterpret_cast<const __m256i*>(cells[a]));
    }

    const __m256 zero = _mm256_setzero_ps(), one = _mm256_set1_ps(1);
    __m256 normal[3], forward = zero;
    for (int a = 0; a < 3; ++a) {
        p[a] = _mm256_min_ps(_mm256_max_ps(_mm256_sub_ps(p[a], _mm256_cvtepi32_ps(cell[a])), zero), one);
        normal[a] = _mm256_and_ps(on_axis[a], _mm256_blendv_ps(_mm256_set1_ps(-1), one, negative[a]));
        forward = _mm256_or_ps(forward, _mm256_and_ps(on_axis[a], negative[a]));
    }
    const __m256 u = _mm256_blendv_ps(_mm256_blendv_ps(p[1], p[2], on_axis[1]), p[0], on_axis[2]);
    const __m256 v = _mm256_blendv_ps(_mm256_blendv_ps(p[2], p[0], on_axis[1]), p[1], on_axis[2]);
    const __m256i face = _mm256_sub_epi32(_mm256_add_epi32(hit.axis, hit.axis), _mm256_castps_si256(forward));
    const auto bits = [](__m256i x) { return _mm256_castsi256_ps(x); };

    static_assert(sizeof(Hit) == 12 * sizeof(float) && offsetof(Hit, uv) == 16 && offsetof(Hit, normal) == 36);
    __m128 rows[3][packet_size];
    transpose(hit.t, bits(_mm256_set1_epi32(-1)), bits(_mm256_set1_epi32(int(hit.palette))), bits(face), rows[0]);
    transpose(u, v, bits(cell[0]), bits(cell[1]), rows[1]);
    transpose(bits(cell[2]), normal[0], normal[1], normal[2], rows[2]);
    for (; which; which &= which - 1) {
        const int i = std::countr_zero(which);
        for (int k = 0; k < 3; ++k) _mm_storeu_ps(&hits[i].t + 4 * k, rows[k][i]);
    }
}

#endif

}  // namespace

#ifdef __AVX2__

unsigned cpu_voxels_closest8(const kernels::SceneView& scene, kernels::uint grid_index, kernels::uint slot_first,
                             const kernels::Ray* rays, unsigned lanes, kernels::Hit* hits) {
    using namespace kernels;
    const VoxelGrid& grid = scene.voxel_grids.at[grid_index];

    const auto one_by_one = [&](unsigned which) {
        return closest_one_by_one(scene, grid_index, slot_first, rays, which, hits);
    };

    __m256 o[4], d[4];  // origins and t_min, directions and t_max
    load_columns(&rays[0].origin.x, o);
    load_columns(&rays[0].direction.x, d);
    alignas(32) float limits[packet_size];
    for (int i = 0; i < packet_size; ++i) limits[i] = lanes >> i & 1 ? hits[i].t : -INFINITE;
    const __m256 limit = _mm256_load_ps(limits);

    const __m256 magnitude = _mm256_castsi256_ps(_mm256_set1_epi32(0x7fffffff));
    const __m256 far = _mm256_max_ps(_mm256_max_ps(_mm256_and_ps(o[0], magnitude), _mm256_and_ps(o[1], magnitude)),
                                     _mm256_and_ps(o[2], magnitude));
    const __m256 reach = _mm256_add_ps(far, _mm256_set1_ps(float(std::max({grid.size.x, grid.size.y, grid.size.z}))));
    // A comparison that fails for what is no number.
    if ((unsigned(_mm256_movemask_ps(_mm256_cmp_ps(reach, _mm256_set1_ps(1e5f), _CMP_LT_OQ))) & lanes) != lanes)
        return one_by_one(lanes);

    PacketAxis axes[3];
    std::uint32_t flip = 0;
    __m256 start = o[3], leave = limit;
    __m256 box_enter[3];
    for (int a = 0; a < 3; ++a) {
        const __m256 still = _mm256_cmp_ps(_mm256_and_ps(d[a], magnitude), _mm256_set1_ps(TINY_DIRECTION), _CMP_LT_OQ);
        const unsigned still_lanes = unsigned(_mm256_movemask_ps(still)) & lanes;
        const unsigned negative = unsigned(_mm256_movemask_ps(d[a])) & lanes & ~still_lanes;
        if (negative && negative != (lanes & ~still_lanes)) return one_by_one(lanes);
        axes[a] = PacketAxis{o[a], _mm256_div_ps(_mm256_set1_ps(1), d[a]), still, still_lanes != 0, negative != 0};
        if (negative) flip |= 3u << (2 * a);
        const int size = grid.size[a];
        box_enter[a] = plane_t(axes[a], negative ? size : 0);
        leave = _mm256_min_ps(leave, plane_t(axes[a], negative ? 0 : size));
    }
    const __m256 box = _mm256_max_ps(_mm256_max_ps(box_enter[0], box_enter[1]), box_enter[2]);
    const unsigned from_outside = unsigned(_mm256_movemask_ps(_mm256_cmp_ps(box, start, _CMP_GT_OQ)));
    start = _mm256_max_ps(start, box);
    // Of the rays that have found nothing yet.
    unsigned alive = unsigned(_mm256_movemask_ps(_mm256_cmp_ps(start, leave, _CMP_LT_OQ))) & lanes;
    if (!alive) return 0;

    PacketNode stack[VOXEL_MAX_LEVELS];
    uint level = grid.level_count - 1;
    const VoxelNode* const nodes = scene.voxel_nodes.at + grid.node_first;
    const uint* const references = grid.reference_first == NONE ? nullptr : scene.words.at + grid.reference_first;

    open_node(grid.root, ivec3(0), 1 << (2 * level), axes, flip, alive, start, leave, stack[level]);

    unsigned found = 0, single = 0;
    for (;;) {
        PacketNode& n = stack[level];
        const unsigned here = n.lanes & alive;
        if (!here || !n.todo) {
            if (!alive || ++level == grid.level_count) break;
            continue;
        }
        const uint bit = uint(std::countr_zero(n.todo));
        n.todo &= n.todo - 1;
        const uint ix = bit & 3, iy = bit >> 2 & 3, iz = bit >> 4;
        const __m256 x_in = n.t[0][ix], y_in = n.t[1][iy], z_in = n.t[2][iz];
        const __m256 x_out = n.t[0][ix + 1], y_out = n.t[1][iy + 1], z_out = n.t[2][iz + 1];
        const __m256 in = _mm256_max_ps(_mm256_max_ps(x_in, y_in), z_in);
        const __m256 out = _mm256_min_ps(_mm256_min_ps(x_out, y_out), z_out);
        const __m256 visits =
            _mm256_and_ps(_mm256_and_ps(_mm256_cmp_ps(in, out, _CMP_LE_OQ), _mm256_cmp_ps(out, start, _CMP_GT_OQ)),
                          _mm256_cmp_ps(in, limit, _CMP_LT_OQ));
        unsigned visiting = unsigned(_mm256_movemask_ps(visits)) & here;
        if (!visiting) continue;

        const uint digit = bit ^ flip;
        const uint rank = uint(std::popcount(n.mask & ((std::uint64_t(1) << digit) - 1)));
        const ivec3 lower = n.lower + (ivec3(digit & 3, digit >> 2 & 3, digit >> 4) << int(2 * level));
        if ((n.link & VOXEL_LINK_KIND) == VOXEL_LINK_CHILDREN) {
            const uint at = n.link + rank;
            --level;
            open_node(nodes[references ? references[at] : at], lower, 1 << (2 * level), axes, flip, visiting,
                      _mm256_max_ps(in, start), _mm256_min_ps(out, leave), stack[level]);
            continue;
        }
        const VoxelNode plain(uint(n.mask), uint(n.mask >> 32), n.link);
        const uint palette = voxel_palette(scene, grid, plain, rank);
        if (voxel_class(scene, slot_first, palette) == VOXEL_AIR) continue;

        const unsigned ties = unsigned(_mm256_movemask_ps(_mm256_cmp_ps(in, out, _CMP_EQ_OQ))) & visiting;
        if (ties) [[unlikely]]
            visiting &= ~ties | in_order(x_in, y_in, z_in, x_out, y_out, z_out);
        // Where the walk begins: on a face of the box, or, for the kernel to tell, inside of something.
        const unsigned first = unsigned(_mm256_movemask_ps(_mm256_cmp_ps(in, start, _CMP_LE_OQ))) & visiting;
        single |= first & ~from_outside;
        const unsigned hit = visiting & ~(first & ~from_outside);
        if (hit) {
            // The plane met last; of the box that met first.
            __m256i axis = last_axis(x_in, y_in, z_in);
            if (first) [[unlikely]]
                axis = _mm256_castps_si256(_mm256_blendv_ps(_mm256_castsi256_ps(axis),
                                                            _mm256_castsi256_ps(first_axis(box_enter)),
                                                            _mm256_cmp_ps(in, start, _CMP_LE_OQ)));
            const PacketHit what = {in, axis, lower, 1 << (2 * level), palette};
            write_hits(what, o, d, reach, rays, first, hit, hits);
            found |= hit;
        }
        alive &= ~visiting;
    }
    return found | one_by_one(single);
}

#else

unsigned cpu_voxels_closest8(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                             const kernels::Ray* rays, unsigned lanes, kernels::Hit* hits) {
    return closest_one_by_one(scene, grid, slot_first, rays, lanes, hits);
}

#endif

}  // namespace spinel
