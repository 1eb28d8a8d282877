// Equal subtrees kept once. Kämpe, Sintorn, Assarsson, "High Resolution Sparse Voxel DAGs", SIGGRAPH 2013; here with
// the palette indices as part of what has to be equal. A node's children no longer stand in a row, so they are named by
// a row of references; equal rows are shared as well, and a row begins within the last one where that ends as it
// begins.

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <unordered_map>
#include <utility>

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
        starts_.push_back(at);
        return at;
    }

    const std::vector<std::uint32_t>& starts() const { return starts_; }

  private:
    std::vector<std::uint32_t>& pool_;
    std::vector<std::uint32_t> starts_;  // of the rows, which stand one after the other
    std::unordered_multimap<std::uint64_t, std::uint32_t> places_;
};

// Rows put in an order in which many overlap: of all pairs of which one may follow the other, those with the longest
// overlap first. Tarhio, Ukkonen, "A greedy approximation algorithm for constructing shortest common superstrings",
// Theoretical Computer Science 57, 1988.
class OverlappingRows {
  public:
    OverlappingRows(std::span<const std::uint32_t> pool, std::span<const std::uint32_t> starts)
        : pool_(pool), starts_(starts), links_(starts.size()), hashes_(pool.size()) {
        for (std::size_t i = 0; i < powers_.size(); ++i) powers_[i] = i == 0 ? 1 : powers_[i - 1] * base;
        for (std::uint32_t i = 0; i < links_.size(); ++i) {
            links_[i].front = links_[i].back = i;
            std::uint64_t hash = 0;
            for (std::size_t k = 0; k < row(i).size(); ++k)
                hashes_[starts_[i] + k] = hash = hash * base + mixed(0, row(i)[k] + 1);
        }
        for (std::size_t overlap = longest - 1; overlap > 0; --overlap) join(overlap);
    }

    // The rows one after the other; `place(start, at)` is told where each one stands now.
    template <class Place>
    std::vector<std::uint32_t> packed(const Place& place) const {
        std::vector<std::uint32_t> words;
        for (std::uint32_t first = 0; first < links_.size(); ++first) {
            if (links_[first].follows) continue;
            for (std::uint32_t i = first; i != none; i = links_[i].next) {
                const std::span<const std::uint32_t> r = row(i);
                place(starts_[i], std::uint32_t(words.size() - links_[i].overlap));
                words.insert(words.end(), r.begin() + links_[i].overlap, r.end());
            }
        }
        return words;
    }

  private:
    static constexpr std::uint32_t none = ~0u;
    static constexpr std::size_t longest = 64;
    static constexpr std::uint64_t base = 0x9e3779b97f4a7c15ull;

    struct Link {
        std::uint32_t next = none;  // the row that follows
        bool follows = false;       // another one …
        std::uint32_t overlap = 0;  // … with so many words
        std::uint32_t front, back;  // of a row's chain; kept for the last and for the first of its rows
    };

    std::span<const std::uint32_t> row(std::uint32_t i) const {
        const std::size_t end = i + 1 < starts_.size() ? starts_[i + 1] : pool_.size();
        return pool_.subspan(starts_[i], end - starts_[i]);
    }
    std::uint64_t hash_of_first(std::uint32_t i, std::size_t count) const { return hashes_[starts_[i] + count - 1]; }
    std::uint64_t hash_of_last(std::uint32_t i, std::size_t count) const {
        const std::size_t size = row(i).size();
        return hash_of_first(i, size) - hash_of_first(i, size - count) * powers_[count];
    }

    // Puts rows after those that end as they begin.
    void join(std::size_t overlap) {
        std::unordered_map<std::uint64_t, std::uint32_t> first;   // of the rows that begin alike …
        std::vector<std::uint32_t> another(links_.size(), none);  // … and what comes after one of them
        for (std::uint32_t i = std::uint32_t(links_.size()); i-- > 0;) {
            if (links_[i].follows || row(i).size() <= overlap) continue;
            const auto [it, fresh] = first.try_emplace(hash_of_first(i, overlap), i);
            if (!fresh) another[i] = std::exchange(it->second, i);
        }
        for (std::uint32_t i = 0; i < links_.size(); ++i) {
            if (links_[i].next != none || row(i).size() <= overlap) continue;
            const auto it = first.find(hash_of_last(i, overlap));
            if (it == first.end()) continue;
            std::uint32_t* slot = &it->second;
            if (*slot == links_[i].front) slot = &another[*slot];  // a chain does not follow itself
            const std::uint32_t j = *slot;
            if (j == none) continue;
            if (!std::ranges::equal(row(i).last(overlap), row(j).first(overlap))) continue;
            *slot = another[j];
            if (it->second == none) first.erase(it);
            links_[i].next = j;
            links_[j].follows = true;
            links_[j].overlap = std::uint32_t(overlap);
            const std::uint32_t front = links_[i].front, back = links_[j].back;
            links_[front].back = back;
            links_[back].front = front;
        }
    }

    std::span<const std::uint32_t> pool_, starts_;
    std::vector<Link> links_;
    std::vector<std::uint64_t> hashes_;  // of a row up to each of its words
    std::array<std::uint64_t, longest + 1> powers_;
};

class Sharing {
  public:
    explicit Sharing(const VoxelTree::Arrays& from) : from_(from) {}

    VoxelTree::Arrays run() && {
        to_.root = translated(from_.root);
        pack_references();
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

    void pack_references() {
        std::unordered_map<std::uint32_t, std::uint32_t> places;
        to_.references =
            OverlappingRows(to_.references, references_.starts()).packed([&](std::uint32_t start, std::uint32_t at) {
                places[start] = at;
            });
        const auto move = [&](VoxelNode& node) {
            const bool is_parent = (node.link & kernels::VOXEL_LINK_KIND) == kernels::VOXEL_LINK_CHILDREN &&
                                   (node.mask_low | node.mask_high) != 0;
            if (is_parent) node.link = kernels::VOXEL_LINK_CHILDREN | places.at(node.link);
        };
        for (VoxelNode& node : to_.nodes) move(node);
        move(to_.root);
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
