#include "spinel/voxels.h"

#include <algorithm>
#include <utility>

namespace spinel {

VoxelTree::VoxelTree(ivec3 size, Arrays arrays, std::uint64_t voxel_count, std::uint16_t palette_maximum)
    : size_(size),
      level_count_(levels_for(size)),
      voxel_count_(voxel_count),
      palette_maximum_(palette_maximum),
      arrays_(std::move(arrays)) {}

int VoxelTree::levels_for(ivec3 size) {
    const int edge = std::max({size.x, size.y, size.z});
    int levels = 1;
    while (levels < max_levels && 1 << (2 * levels) < edge) ++levels;
    return levels;
}

VoxelTreeMemory VoxelTree::memory() const {
    return {(arrays_.nodes.size() + 1) * sizeof(kernels::VoxelNode), arrays_.references.size() * sizeof(std::uint32_t),
            arrays_.palettes.size() * sizeof(std::uint32_t)};
}

std::uint16_t VoxelTree::at(ivec3 cell) const {
    for (int axis = 0; axis < 3; ++axis)
        if (cell[axis] < 0 || cell[axis] >= size_[axis]) return 0;
    const kernels::VoxelNode* node = &arrays_.root;
    for (int level = level_count_ - 1;; --level) {
        const ivec3 digit = cell >> (2 * level) & 3;
        const std::uint64_t mask = mask_of(*node), bit = std::uint64_t(1) << (digit.x + 4 * digit.y + 16 * digit.z);
        if (!(mask & bit)) return 0;
        const auto rank = kernels::uint(std::popcount(mask & (bit - 1)));
        if ((node->link & kernels::VOXEL_LINK_KIND) != kernels::VOXEL_LINK_CHILDREN) return palette_of(*node, rank);
        node = &child_of(*node, rank);
    }
}

std::optional<std::uint16_t> VoxelTree::cube(ivec3 lower, int edge) const {
    const kernels::VoxelNode* node = &arrays_.root;
    if (mask_of(*node) == 0) return std::uint16_t(0);
    for (int level = level_count_ - 1; level >= 0 && 1 << (2 * level) >= edge; --level) {
        const ivec3 digit = lower >> (2 * level) & 3;
        const std::uint64_t mask = mask_of(*node), bit = std::uint64_t(1) << (digit.x + 4 * digit.y + 16 * digit.z);
        if (!(mask & bit)) return std::uint16_t(0);
        const auto rank = kernels::uint(std::popcount(mask & (bit - 1)));
        if ((node->link & kernels::VOXEL_LINK_KIND) != kernels::VOXEL_LINK_CHILDREN) return palette_of(*node, rank);
        node = &child_of(*node, rank);
    }
    // Where its neighbours are divided, a solid cube is a node of its own.
    const kernels::uint kind = node->link & kernels::VOXEL_LINK_KIND;
    const bool solid = mask_of(*node) == ~std::uint64_t(0) && kind != kernels::VOXEL_LINK_CHILDREN &&
                       kind != kernels::VOXEL_LINK_BYTES && kind != kernels::VOXEL_LINK_HALVES;
    return solid ? std::optional(palette_of(*node, 0)) : std::nullopt;
}

}  // namespace spinel
