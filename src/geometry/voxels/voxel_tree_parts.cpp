#include "geometry/voxels/voxel_tree_parts.h"

#include <algorithm>
#include <string>
#include <utility>

namespace spinel {

using kernels::VoxelNode;

namespace {

constexpr std::uint64_t max_link = ~kernels::VOXEL_LINK_KIND;

bool has_words(std::uint32_t link) {
    const std::uint32_t kind = link & kernels::VOXEL_LINK_KIND;
    return kind == kernels::VOXEL_LINK_BYTES || kind == kernels::VOXEL_LINK_HALVES;
}

}  // namespace

VoxelBranch solid_branch(std::uint16_t palette) { return {~std::uint64_t(0), kernels::VOXEL_LINK_SOLID | palette}; }

VoxelBranch VoxelTreePart::leaf(std::uint64_t mask, const std::array<std::uint16_t, 64>& palettes) {
    if (mask == 0) return {};
    const std::uint16_t first = palettes[std::size_t(std::countr_zero(mask))];
    std::uint16_t maximum = 0;
    bool uniform = true;
    for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1) {
        const std::uint16_t palette = palettes[std::size_t(std::countr_zero(rest))];
        maximum = std::max(maximum, palette);
        uniform &= palette == first;
    }
    voxel_count_ += std::uint64_t(std::popcount(mask));
    palette_maximum_ = std::max(palette_maximum_, maximum);
    if (uniform) return {mask, kernels::VOXEL_LINK_SOLID | first};

    const std::size_t at = palettes_.size();
    overflow_ |= at > max_link;
    const std::uint32_t bits = maximum < 256 ? 8 : 16;
    std::uint32_t shift = 0;
    for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1) {
        if (shift == 0) palettes_.push_back(0);
        palettes_.back() |= std::uint32_t(palettes[std::size_t(std::countr_zero(rest))]) << shift;
        shift = (shift + bits) % 32;
    }
    return {mask, (bits == 8 ? kernels::VOXEL_LINK_BYTES : kernels::VOXEL_LINK_HALVES) | std::uint32_t(at)};
}

VoxelBranch VoxelTreePart::parent(const std::array<VoxelBranch, 64>& children) {
    VoxelBranch branch;
    const VoxelBranch* first = nullptr;
    bool solid = true;
    for (std::size_t i = 0; i < 64; ++i) {
        if (children[i].mask == 0) continue;
        branch.mask |= std::uint64_t(1) << i;
        if (!first) first = &children[i];
        solid &= children[i].is_solid() && children[i].link == first->link;
    }
    if (!first) return {};
    if (solid) {
        branch.link = first->link;
        return branch;
    }
    overflow_ |= nodes_.size() + 64 > max_link;
    branch.link = kernels::VOXEL_LINK_CHILDREN | std::uint32_t(nodes_.size());
    for (const VoxelBranch& child : children)
        if (child.mask != 0) nodes_.push_back(child.node());
    return branch;
}

VoxelBranch VoxelTreePart::solid(std::uint16_t palette, int level) {
    voxel_count_ += std::uint64_t(1) << (6 * (level + 1));
    palette_maximum_ = std::max(palette_maximum_, palette);
    return solid_branch(palette);
}

VoxelBranch VoxelTreePart::append(const VoxelTreePart& part, VoxelBranch root) {
    const std::size_t node_first = nodes_.size(), word_first = palettes_.size();
    const auto moved = [&](std::uint32_t link) {
        const std::uint32_t kind = link & kernels::VOXEL_LINK_KIND;
        if (kind == kernels::VOXEL_LINK_CHILDREN) return link + std::uint32_t(node_first);
        return has_words(link) ? link + std::uint32_t(word_first) : link;
    };
    voxel_count_ += part.voxel_count_;
    palette_maximum_ = std::max(palette_maximum_, part.palette_maximum_);
    overflow_ |=
        part.overflow_ || node_first + part.nodes_.size() > max_link || word_first + part.palettes_.size() > max_link;
    for (const VoxelNode& node : part.nodes_) nodes_.push_back({node.mask_low, node.mask_high, moved(node.link)});
    palettes_.insert(palettes_.end(), part.palettes_.begin(), part.palettes_.end());
    if (root.mask != 0) root.link = moved(root.link);
    return root;
}

Result<VoxelTreePointer> VoxelTreePart::finish(ivec3 size, VoxelBranch root, const VoxelTreeOptions& options) && {
    if (overflow_)
        return Error{"a voxel set needs more than the " + std::to_string(max_link) +
                     " nodes or words of palette indices that can be addressed"};
    nodes_.shrink_to_fit();
    palettes_.shrink_to_fit();
    VoxelTree::Arrays arrays{root.node(), std::move(nodes_), {}, std::move(palettes_)};
    if (options.share) arrays = share_subtrees(arrays);
    return std::make_shared<const VoxelTree>(size, std::move(arrays), voxel_count_, palette_maximum_);
}

Result<void> validate_voxel_size(ivec3 size) {
    for (int axis = 0; axis < 3; ++axis)
        if (size[axis] < 1 || size[axis] > VoxelTree::max_edge)
            return Error{"voxel set has size " + std::to_string(size.x) + "×" + std::to_string(size.y) + "×" +
                         std::to_string(size.z) + "; every edge must be from 1 to " +
                         std::to_string(VoxelTree::max_edge)};
    return {};
}

}  // namespace spinel
