#pragma once
// Eight coherent rays against a set of voxels: they go down the tree together, so that a node is loaded, its planes are
// met and its children sorted once for all.
//
// A walk from cell to cell is an order of events: the ray meets plane p of an axis at t, earlier t first, at equal t x
// before y before z (kernels/voxels.h). So a ray visits a cell exactly if it meets each plane by which it comes in
// before each plane by which it goes out, and that can be asked of any cell, or node, by itself. Mirrored so that all
// directions are positive, the children of a node in the order of their bits are in front-to-back order, and the first
// cell that is not air is the hit: the very one, bit for bit, that the kernel finds.
//
// Rays of different octants, or that are no neighbours, are a stream (voxel_stream.cpp); those that start in something,
// or where rounding is about a cell, go one by one.

#include "devices/cpu/ray_columns.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_AS_ELSEWHERE_BEGIN

namespace spinel {

// A set of voxels where it stands.
struct PacketSet {
    const kernels::SceneView& scene;
    const kernels::VoxelGrid& grid;
    kernels::uint grid_index, slot_first, instance;
    std::uint32_t flip;  // axes along which the rays go down: 3, 12, 48 set for x, y, z
};

struct VoxelPacket {
    RayColumns ray;
    const kernels::Ray* rays;
    BoxPass box;
    __m256 limit;     // hits count up to here
    unsigned still;   // axes along which some direction is zero
    unsigned alive;   // rays that have met nothing yet, and still may
    unsigned single;  // rays that the kernel has to ask
    unsigned found;   // rays that have met something: this
    __m256 t;
    __m256i axis, palette, cell[3];  // others: no_axis, nothing, at the limit
};

inline constexpr int no_axis = 3;

inline void begin_hits(VoxelPacket& p) {
    p.found = 0;
    p.t = p.limit;
    p.axis = _mm256_set1_epi32(no_axis);
    p.palette = p.cell[0] = p.cell[1] = p.cell[2] = _mm256_setzero_si256();
}

// Where the rays of a packet come into a cube, and where they leave it.
struct CubePass {
    __m256 in[3], out[3];  // by axis
    __m256 last_in, first_out;
};

// The rays that visit the cube: all but the order of planes that are met at the same t is told.
inline unsigned visiting(const VoxelPacket& p, CubePass& c) {
    c.last_in = _mm256_max_ps(_mm256_max_ps(c.in[0], c.in[1]), c.in[2]);
    c.first_out = _mm256_min_ps(_mm256_min_ps(c.out[0], c.out[1]), c.out[2]);
    return lanes_of(_mm256_and_ps(_mm256_and_ps(_mm256_cmp_ps(c.last_in, c.first_out, _CMP_LE_OQ),
                                                _mm256_cmp_ps(c.first_out, p.box.start, _CMP_GT_OQ)),
                                  _mm256_cmp_ps(c.last_in, p.limit, _CMP_LT_OQ)));
}

// The bits of a node's mask with axes turned round, as PacketSet::flip says.
inline kernels::mask64 mirrored(kernels::mask64 m, std::uint32_t flip) {
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

// Whether the rays in `lanes`, the first of the eight among them or not, are of one octant and so near to the first
// that they are better off as a packet.
bool are_neighbours(const RayColumns& ray, unsigned lanes);

// Eight rays before their walk; hits count up to `limit`.
void begin_packet(const PacketSet& set, const RayColumns& ray, const kernels::Ray* rays, unsigned lanes, __m256 limit,
                  VoxelPacket& packet);

// The axes along which the living rays of a packet go down, as PacketSet::flip.
std::uint32_t flip_of(const VoxelPacket& packet);

// The rays in `lanes` through a node with children of 4^level cells an edge, between `enter` and `exit`.
void walk_node(const PacketSet& set, VoxelPacket& packet, const kernels::VoxelNode& node, glm::ivec3 lower, int level,
               unsigned lanes, __m256 enter, __m256 exit);

// The rays in `lanes` have come to a cube of one palette index: those that visit it meet it, if it is not air.
void meet_cube(const PacketSet& set, VoxelPacket& packet, const CubePass& pass, glm::ivec3 lower, int edge,
               kernels::uint palette, unsigned lanes);

// What has been met, for the rays that have met something.
void write_found(const PacketSet& set, const VoxelPacket& packet, kernels::Hit* hits);

// The answer of all eight: what they have met, or nothing before the packet's limit. Past the caches, if `streaming`.
void write_all(const PacketSet& set, const VoxelPacket& packet, bool streaming, kernels::Hit* hits);

// The same for rays that meet nothing.
void write_none(std::span<const kernels::Ray> rays, bool streaming, kernels::Hit* hits);

// For rays of one octant: as cpu_voxels_closest8. `ray` are the columns of `rays`.
unsigned packet_closest(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                        kernels::uint instance, const RayColumns& ray, const kernels::Ray* rays, unsigned lanes,
                        kernels::Hit* hits);

// The nearest hits of up to 64 rays, a multiple of eight of them, if they are neighbours of one octant; else false.
bool bundle_closest(const kernels::SceneView& scene, kernels::uint grid, kernels::uint slot_first,
                    kernels::uint instance, std::span<const kernels::Ray> rays, bool streaming, kernels::Hit* hits);

}  // namespace spinel

SPINEL_AVX2_END
#endif
