#pragma once
// What the builders of 64-trees share: nodes are written bottom-up, a parent when its children are known.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"
#include "spinel/voxels.h"

namespace spinel {

// A node while its tree is built, with its mask as one word.
struct VoxelBranch {
    std::uint64_t mask = 0;  // 0: nothing is there
    std::uint32_t link = 0;

    bool is_solid() const {
        return mask == ~std::uint64_t(0) && (link & kernels::VOXEL_LINK_KIND) == kernels::VOXEL_LINK_SOLID;
    }
    kernels::VoxelNode node() const { return {std::uint32_t(mask), std::uint32_t(mask >> 32), link}; }
};

// A cube of edge 4^(level + 1), all of one palette index.
VoxelBranch solid_branch(std::uint16_t palette);

// Part of a tree: nodes and palette indices, links relative to its own arrays.
class VoxelTreePart {
  public:
    // The node of 64 voxels: bit i of `mask` stands for palettes[i].
    VoxelBranch leaf(std::uint64_t mask, const std::array<std::uint16_t, 64>& palettes);
    // The node of the children that are not empty.
    VoxelBranch parent(const std::array<VoxelBranch, 64>& children);
    // A branch that stands for a solid cube without having been built of leaves.
    VoxelBranch solid(std::uint16_t palette, int level);
    // Takes in another part whose root is `root`; returns the root as seen from here.
    VoxelBranch append(const VoxelTreePart& part, VoxelBranch root);

    // With everything under `root`; an error if it is more than links can address.
    Result<VoxelTreePointer> finish(ivec3 size, VoxelBranch root, const VoxelTreeOptions& options) &&;

  private:
    std::vector<kernels::VoxelNode> nodes_;
    std::vector<std::uint32_t> palettes_;
    std::uint64_t voxel_count_ = 0;
    std::uint16_t palette_maximum_ = 0;
    bool overflow_ = false;
};

// The palette index of child number `rank` of a node whose children are no nodes.
inline std::uint16_t palette_of(const VoxelTree::Arrays& arrays, const kernels::VoxelNode& node, kernels::uint rank) {
    const kernels::uint at = node.link & ~kernels::VOXEL_LINK_KIND;
    switch (node.link & kernels::VOXEL_LINK_KIND) {
        case kernels::VOXEL_LINK_BYTES: return arrays.palettes[at + (rank >> 2)] >> (8 * (rank & 3)) & 0xff;
        case kernels::VOXEL_LINK_HALVES: return arrays.palettes[at + (rank >> 1)] >> (16 * (rank & 1)) & 0xffff;
        default: return std::uint16_t(at);
    }
}

// One sentence if no tree can have this size.
Result<void> validate_voxel_size(ivec3 size);

// The same set with equal subtrees kept once.
VoxelTree::Arrays share_subtrees(const VoxelTree::Arrays& arrays);

}  // namespace spinel
