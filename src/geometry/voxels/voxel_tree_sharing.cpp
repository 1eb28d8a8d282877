// Equal subtrees kept once. Kämpe, Sintorn, Assarsson, "High Resolution Sparse Voxel DAGs", SIGGRAPH 2013; here with
// the palette indices as part of what has to be equal. A node's children no longer stand in a row, so they are named by
// a row of references; equal rows are shared as well.

#include <algorithm>
#include <bit>
#include <span>
#include <unordered_map>

#include "geometry/voxels/voxel_tree_parts.h"

namespace spinel {
namespace {

using kernels::VoxelNode;

std::uint64_t mixed(std::uint64_t h, std::uint64_t value) {
    h = (h ^ value) * 0x9e3779b97f4a7c15ull;
    return h ^ h >> 32;
}

struct NodeHash {
    std::size_t operator()(const VoxelNode& n) const { return mixed(mixed(n.link, n.mask_low), n.mask_high); }
};
struct NodeEqual {
    bool operator()(const VoxelNode& a, const VoxelNode& b) const {
        return a.mask_low == b.mask_low && a.mask_high == b.mask_high && a.link == b.link;
    }
};

// Rows of words in a pool, equal rows once.
class Rows {
  public:
    explicit Rows(std::vector<std::uint32_t>& pool) : pool_(pool) {}

    std::uint32_t place(std::span<const std::uint32_t> row) {
        std::uint64_t hash = row.size();
        for (const std::uint32_t word : row) hash = mixed(hash, word);
        const auto [first, last] = places_.equal_range(hash);
        for (auto it = first; it != last; ++it)
            if (it->second + row.size() <= pool_.size() &&
                std::equal(row.begin(), row.end(), pool_.begin() + std::ptrdiff_t(it->second)))
                return it->second;
        const auto at = std::uint32_t(pool_.size());
        pool_.insert(pool_.end(), row.begin(), row.end());
        places_.emplace(hash, at);
        return at;
    }

  private:
    std::vector<std::uint32_t>& pool_;
    std::unordered_multimap<std::uint64_t, std::uint32_t> places_;
};

class Sharing {
  public:
    explicit Sharing(const VoxelTree::Arrays& from) : from_(from) {}

    VoxelTree::Arrays run() && {
        to_.root = translated(from_.root);
        return std::move(to_);
    }

  private:
    // A node with everything under it in the new arrays. Equal subtrees become equal nodes.
    VoxelNode translated(const VoxelNode& node) {
        const std::uint32_t kind = node.link & kernels::VOXEL_LINK_KIND, at = node.link & ~kernels::VOXEL_LINK_KIND;
        const auto count = std::size_t(std::popcount(node.mask_low | std::uint64_t(node.mask_high) << 32));
        if (count == 0 || kind == kernels::VOXEL_LINK_SOLID) return node;
        if (kind == kernels::VOXEL_LINK_CHILDREN) {
            std::array<std::uint32_t, 64> row;
            for (std::size_t i = 0; i < count; ++i) {
                const std::size_t child = from_.references.empty() ? at + i : from_.references[at + i];
                row[i] = number_of(translated(from_.nodes[child]));
            }
            return {node.mask_low, node.mask_high, kind | references_.place({row.data(), count})};
        }
        const std::size_t words = kind == kernels::VOXEL_LINK_BYTES ? (count + 3) / 4 : (count + 1) / 2;
        return {node.mask_low, node.mask_high, kind | palettes_.place({from_.palettes.data() + at, words})};
    }

    std::uint32_t number_of(const VoxelNode& node) {
        const auto [it, fresh] = numbers_.try_emplace(node, std::uint32_t(to_.nodes.size()));
        if (fresh) to_.nodes.push_back(node);
        return it->second;
    }

    const VoxelTree::Arrays& from_;
    VoxelTree::Arrays to_;
    Rows references_{to_.references}, palettes_{to_.palettes};
    std::unordered_map<VoxelNode, std::uint32_t, NodeHash, NodeEqual> numbers_;
};

}  // namespace

VoxelTree::Arrays share_subtrees(const VoxelTree::Arrays& arrays) { return Sharing(arrays).run(); }

VoxelTreePointer with_shared_subtrees(const VoxelTree& tree) {
    return std::make_shared<const VoxelTree>(tree.size(), share_subtrees(tree.arrays()), tree.voxel_count(),
                                             tree.palette_maximum());
}

}  // namespace spinel
