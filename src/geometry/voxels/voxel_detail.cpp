#include "geometry/voxels/voxel_detail.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <utility>

#include "geometry/voxels/voxel_tree_parts.h"

namespace spinel {
namespace {

using kernels::uint;
using kernels::VoxelNode;

std::uint64_t mask_of(const VoxelNode& node) { return node.mask_low | std::uint64_t(node.mask_high) << 32; }

// How many voxels of each palette index; few differ within a cube.
using Counts = std::vector<std::pair<std::uint16_t, std::uint64_t>>;

void count(Counts& counts, std::uint16_t palette, std::uint64_t voxels) {
    for (auto& [p, n] : counts)
        if (p == palette) {
            n += voxels;
            return;
        }
    counts.emplace_back(palette, voxels);
}

class Reduction {
  public:
    Reduction(const VoxelTree& tree, const VoxelDetail& detail)
        : tree_(tree), arrays_(tree.arrays()), detail_(detail) {}

    VoxelTreePointer run() && {
        const VoxelBranch root = reduced(arrays_.root, tree_.level_count() - 1, ivec3(0));
        // Fewer nodes than the tree had, so links cannot run out.
        Result<VoxelTreePointer> result = std::move(part_).finish(tree_.size(), root, {});
        assert(result);
        return *result;
    }

  private:
    // The node, whose children are 4^level cells wide, with less detail.
    VoxelBranch reduced(const VoxelNode& node, int level, ivec3 lower) {
        const std::uint64_t mask = mask_of(node);
        if (mask == 0) return {};
        std::array<VoxelBranch, 64> children;
        std::array<std::uint16_t, 64> palettes{};
        const bool divided = (node.link & kernels::VOXEL_LINK_KIND) == kernels::VOXEL_LINK_CHILDREN;
        uint rank = 0;
        for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1, ++rank) {
            const int i = std::countr_zero(rest);
            if (!divided) {
                palettes[std::size_t(i)] = palette_of(arrays_, node, rank);
                if (level > 0) children[std::size_t(i)] = part_.solid(palettes[std::size_t(i)], level - 1);
                continue;
            }
            const VoxelNode& child = child_of(node, rank);
            const ivec3 corner = lower + (ivec3(i & 3, i >> 2 & 3, i >> 4) << (2 * level));
            const std::uint16_t palette = solid_palette(child, level, corner);
            children[std::size_t(i)] =
                palette != 0 ? part_.solid(palette, level - 1) : reduced(child, level - 1, corner);
        }
        return level > 0 ? part_.parent(children) : part_.leaf(mask, palettes);
    }

    // What a child of 4^level cells becomes as a whole; 0: it is divided further.
    std::uint16_t solid_palette(const VoxelNode& child, int level, ivec3 corner) {
        const int edge = 1 << (2 * level);
        if (glm::any(glm::greaterThan(corner + edge, tree_.size())) || !detail_.coarse(corner, edge)) return 0;
        Counts counts;
        if (!plain_counts(child, level - 1, counts) || counts.empty()) return 0;
        const auto most = std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) {
            return a.second != b.second ? a.second < b.second : a.first > b.first;
        });
        return most->first;
    }

    bool plain_counts(const VoxelNode& node, int level, Counts& counts) {
        const bool divided = (node.link & kernels::VOXEL_LINK_KIND) == kernels::VOXEL_LINK_CHILDREN;
        const auto children = uint(std::popcount(mask_of(node)));
        for (uint rank = 0; rank < children; ++rank) {
            if (divided) {
                if (!plain_counts(child_of(node, rank), level - 1, counts)) return false;
                continue;
            }
            const std::uint16_t palette = palette_of(arrays_, node, rank);
            if (!detail_.plain(palette)) return false;
            count(counts, palette, std::uint64_t(1) << (6 * level));
        }
        return true;
    }

    const VoxelNode& child_of(const VoxelNode& node, uint rank) const { return arrays_.nodes[node.link + rank]; }

    const VoxelTree& tree_;
    const VoxelTree::Arrays& arrays_;
    const VoxelDetail& detail_;
    VoxelTreePart part_;
};

}  // namespace

VoxelTreePointer with_less_detail(const VoxelTree& tree, const VoxelDetail& detail) {
    // Sets with shared subtrees stand for more nodes than could ever be written apart, and are small as they are.
    if (!tree.arrays().references.empty()) return std::make_shared<const VoxelTree>(tree);
    return Reduction(tree, detail).run();
}

}  // namespace spinel
