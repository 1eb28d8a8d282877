#include "geometry/voxels/voxel_mips.h"

#include <array>
#include <bit>
#include <cstddef>

#include "geometry/voxels/voxel_tree_parts.h"

namespace spinel {
namespace {

using glm::vec3;
using kernels::uint;
using kernels::VoxelLook;
using kernels::VoxelNode;

// The bits of children 0 … 63 that have no neighbour to the lower and to the upper side of an axis within the node.
constexpr std::uint64_t lower_sides[] = {0x1111111111111111ull, 0x000f000f000f000full, 0x000000000000ffffull};
constexpr std::uint64_t upper_sides[] = {0x8888888888888888ull, 0xf000f000f000f000ull, 0xffff000000000000ull};

// How many of the six sides of each child look into an empty one of the same node; what lies beyond is not known.
std::array<std::uint8_t, 64> open_sides(std::uint64_t mask) {
    std::array<std::uint8_t, 64> count{};
    for (int axis = 0; axis < 3; ++axis) {
        const int step = 1 << (2 * axis);
        const std::uint64_t below = ~(mask << step) & ~lower_sides[axis];
        const std::uint64_t above = ~(mask >> step) & ~upper_sides[axis];
        for (std::uint64_t rest = mask & below; rest != 0; rest &= rest - 1)
            ++count[std::size_t(std::countr_zero(rest))];
        for (std::uint64_t rest = mask & above; rest != 0; rest &= rest - 1)
            ++count[std::size_t(std::countr_zero(rest))];
    }
    return count;
}

// Of the covered part of a column, what its cubes do not cover must not be hidden by each other: taken as independent.
vec3 coverage_of(const std::array<VoxelLook, 64>& children, std::uint64_t mask) {
    std::array<std::array<float, 16>, 3> open;
    for (auto& columns : open) columns.fill(1);
    for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1) {
        const auto i = std::size_t(std::countr_zero(rest));
        const std::size_t x = i & 3, y = i >> 2 & 3, z = i >> 4;
        open[0][y + 4 * z] *= 1 - children[i].coverage.x;
        open[1][x + 4 * z] *= 1 - children[i].coverage.y;
        open[2][x + 4 * y] *= 1 - children[i].coverage.z;
    }
    vec3 coverage(1);
    for (int axis = 0; axis < 3; ++axis)
        for (const float o : open[std::size_t(axis)]) coverage[axis] -= o / 16;
    return glm::clamp(coverage, vec3(0), vec3(1));
}

VoxelLook look_of_children(const std::array<VoxelLook, 64>& children, std::uint64_t mask) {
    VoxelLook look = kernels::no_voxel_look();
    look.coverage = coverage_of(children, mask);
    const std::array<std::uint8_t, 64> open = open_sides(mask);
    float weights = 0;
    for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1) {
        const auto i = std::size_t(std::countr_zero(rest));
        const VoxelLook& child = children[i];
        // What shows counts most: earth under grass gives the ground no colour.
        const float weight = (0.1f + float(open[i])) * (child.coverage.x + child.coverage.y + child.coverage.z);
        weights += weight;
        look.albedo += weight * child.albedo;
        look.share += weight * child.share;
        look.emission += child.emitting * child.emission;
        look.emitting += child.emitting;
    }
    if (weights > 0) {
        look.albedo /= weights;
        look.share /= weights;
    }
    if (look.emitting > 0) look.emission /= look.emitting;
    look.emitting /= 64;
    return look;
}

class Builder {
  public:
    Builder(const VoxelTree& tree, std::span<const VoxelLook> looks)
        : arrays_(tree.arrays()), looks_(looks), known_(arrays_.nodes.size(), false), nodes_(arrays_.nodes.size()) {}

    VoxelMips run() && {
        VoxelMips mips;
        mips.palette.push_back(kernels::pack_voxel_look(look_of(arrays_.root)));
        for (const VoxelLook& look : looks_) mips.palette.push_back(kernels::pack_voxel_look(look));
        mips.nodes.reserve(nodes_.size());
        for (const VoxelLook& look : nodes_) mips.nodes.push_back(kernels::pack_voxel_look(look));
        return mips;
    }

  private:
    VoxelLook look_of(const VoxelNode& node) {
        const std::uint64_t mask = node.mask_low | std::uint64_t(node.mask_high) << 32;
        const uint kind = node.link & kernels::VOXEL_LINK_KIND, at = node.link & ~kernels::VOXEL_LINK_KIND;
        std::array<VoxelLook, 64> children;
        uint rank = 0;
        for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1, ++rank) {
            VoxelLook& child = children[std::size_t(std::countr_zero(rest))];
            if (kind == kernels::VOXEL_LINK_CHILDREN) child = look_of_node(at + rank);
            else child = looks_[palette_of(arrays_, node, rank) - 1u];
        }
        return look_of_children(children, mask);
    }

    const VoxelLook& look_of_node(std::size_t at) {
        const std::size_t index = arrays_.references.empty() ? at : arrays_.references[at];
        if (!known_[index]) {
            const VoxelLook look = look_of(arrays_.nodes[index]);
            nodes_[index] = look;
            known_[index] = true;
        }
        return nodes_[index];
    }

    const VoxelTree::Arrays& arrays_;
    std::span<const VoxelLook> looks_;
    std::vector<bool> known_;
    std::vector<VoxelLook> nodes_;
};

}  // namespace

VoxelMips build_voxel_mips(const VoxelTree& tree, std::span<const VoxelLook> looks) {
    return Builder(tree, looks).run();
}

}  // namespace spinel
