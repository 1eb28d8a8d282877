#ifndef SPINEL_KERNELS_VOXEL_MIP_H
#define SPINEL_KERNELS_VOXEL_MIP_H
// Voxels as they look from afar: for every node of a 64-tree how much of its cube is covered, seen along each axis, and
// the mean colour and emission of what covers it; so that a wall one voxel thick still covers all of a large cube, but
// nothing of it from the side (Crassin et al., "Interactive Indirect Illumination Using Voxel Cone Tracing", 2011,
// anisotropic voxels; here the two sides of an axis share a number).
//
// SceneView::mip_first names two words for each instance: where the mips of its palette begin in voxel_mips (palette
// index p at + p, and the root at + 0), and those of its nodes (in the order of voxel_nodes, from the set's own first).
// NONE: it is no voxel set. Instances of one set in the same materials share their mips.
#include "voxels.h"
KERNELS_BEGIN

struct InstanceMips {
    uint palette_first;  // NONE: none
    uint node_first;
};

FN InstanceMips instance_mips(const_in(SceneView) scene, uint instance) {
    uint at = scene.mip_first + 2u * instance;
    return InstanceMips(scene.words.at[at], scene.words.at[at + 1u]);
}

// What a mip holds, unpacked.
struct VoxelLook {
    vec3 coverage;  // along x, y and z
    float share;    // of the covering surface that emits
    vec3 albedo;
    vec3 emission;   // mean radiance of what emits
    float emitting;  // part of the volume
};

FN VoxelLook no_voxel_look() { return VoxelLook(vec3(0.0f), 0.0f, vec3(0.0f), vec3(0.0f), 0.0f); }

FN uint pack_unit_bytes(vec4 v) {
    vec4 b = clamp(v, vec4(0.0f), vec4(1.0f)) * 255.0f + 0.5f;
    return uint(b.x) | (uint(b.y) << 8u) | (uint(b.z) << 16u) | (uint(b.w) << 24u);
}

FN vec4 unpack_unit_bytes(uint p) {
    return vec4(float(p & 255u), float((p >> 8u) & 255u), float((p >> 16u) & 255u), float(p >> 24u)) * (1.0f / 255.0f);
}

FN VoxelMip pack_voxel_look(const_in(VoxelLook) look) {
    vec3 root = sqrt(max(look.albedo, vec3(0.0f)));
    return VoxelMip(pack_unit_bytes(vec4(look.coverage, look.share)), pack_unit_bytes(vec4(root, 0.0f)), look.emission,
                    look.emitting);
}

FN VoxelLook unpack_voxel_look(const_in(VoxelMip) mip) {
    vec4 coverage = unpack_unit_bytes(mip.coverage);
    vec4 root = unpack_unit_bytes(mip.albedo);
    return VoxelLook(vec3(coverage.x, coverage.y, coverage.z), coverage.w,
                     vec3(root.x * root.x, root.y * root.y, root.z * root.z), mip.emission, mip.emitting);
}

// The look of the cube of 4^level cells an edge around a cell inside of the set, and its edge, which is larger where
// the tree knows that nothing differs. The root's at its own level or above.
FN VoxelLook voxel_look_at(const_in(SceneView) scene, const_in(VoxelGrid) grid, const_in(InstanceMips) mips, ivec3 cell,
                           uint level, inout(float) edge) {
    VoxelNode node = grid.root;
    uint at = mips.palette_first;  // the node's mip
    uint top = grid.level_count;   // the node's cube is 4^top cells wide
    for (uint i = 0u; i < VOXEL_MAX_LEVELS && top > level; ++i) {
        --top;
        mask64 mask = make_mask64(node.mask_low, node.mask_high);
        uint digit = voxel_digit(cell, top);
        edge = float(1u << (2u * top));
        if (!mask64_bit(mask, digit)) return no_voxel_look();
        uint rank = popcount64(mask64_below(mask, digit));
        if ((node.link & VOXEL_LINK_KIND) != VOXEL_LINK_CHILDREN) {
            uint palette = voxel_palette(scene, grid, node, rank);
            return unpack_voxel_look(scene.voxel_mips.at[mips.palette_first + palette]);
        }
        uint child = node.link + rank;
        if (grid.reference_first != NONE) child = scene.words.at[grid.reference_first + child];
        node = scene.voxel_nodes.at[grid.node_first + child];
        at = mips.node_first + child;
    }
    edge = float(1u << (2u * top));
    return unpack_voxel_look(scene.voxel_mips.at[at]);
}

KERNELS_END
#endif
