#pragma once
// Sets of voxels of any size as a sparse 64-tree. A node divides its cube into 4×4×4 children and keeps a 64-bit mask
// of those that hold anything; the children that are there stand one after the other, so that child c is found by
// counting the mask's bits below c. What is solid in one palette index is not divided further, however large it is.
//
// Cell (i,j,k) fills [i,i+1)×[j,j+1)×[k,k+1) and holds a palette index; 0 is empty. Trees are immutable and shared.

#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "kernels/scene_view.h"

namespace spinel {

using glm::ivec3;

struct VoxelTreeMemory {
    std::size_t node_bytes = 0;       // the topology: masks and links …
    std::size_t reference_bytes = 0;  // … and, where equal subtrees are shared, what points to them
    std::size_t palette_bytes = 0;    // of leaves that hold more than one palette index
};

class VoxelTree {
  public:
    static constexpr int max_levels = 10;
    static constexpr int max_edge = 1 << (2 * max_levels);

    // What the tree is made of; kernels walk the same arrays. Links are explained at kernels::VoxelNode.
    struct Arrays {
        kernels::VoxelNode root = {};  // its children are the largest cubes; mask 0: an empty set
        std::vector<kernels::VoxelNode> nodes;
        std::vector<std::uint32_t> references;  // empty: nothing is shared
        std::vector<std::uint32_t> palettes;    // words
    };

    VoxelTree(ivec3 size, Arrays arrays, std::uint64_t voxel_count, std::uint16_t palette_maximum);

    ivec3 size() const { return size_; }
    std::uint64_t voxel_count() const { return voxel_count_; }
    std::uint16_t palette_maximum() const { return palette_maximum_; }
    int level_count() const { return level_count_; }  // the root is 4^level_count cells wide
    VoxelTreeMemory memory() const;
    const Arrays& arrays() const { return arrays_; }

    // The palette index of a cell; 0, empty, outside.
    std::uint16_t at(ivec3 cell) const;

    // The palette index of a whole cube, 0 if it is empty, or nothing if it holds several. Its edge is a power of 4 and
    // its lower corner a multiple of that, inside of the set.
    std::optional<std::uint16_t> cube(ivec3 lower, int edge) const;

    // function(ivec3 lower, int edge, std::uint16_t palette) for disjoint cubes that cover all voxels; edges are powers
    // of 4. In the order of the tree: by the coordinates' base-4 digits, the highest first; z before y before x.
    template <class Function>
    void for_each_cube(const Function& function) const {
        visit(arrays_.root, level_count_ - 1, ivec3(0), function);
    }
    // function(ivec3 cell, std::uint16_t palette) for every voxel.
    template <class Function>
    void for_each(const Function& function) const {
        for_each_cube([&](ivec3 lower, int edge, std::uint16_t palette) {
            for (int z = 0; z < edge; ++z)
                for (int y = 0; y < edge; ++y)
                    for (int x = 0; x < edge; ++x) function(lower + ivec3(x, y, z), palette);
        });
    }

    // How many levels of 4×4×4 a set of this size needs.
    static int levels_for(ivec3 size);

  private:
    template <class Function>
    void visit(const kernels::VoxelNode& node, int level, ivec3 lower, const Function& function) const {
        const kernels::uint kind = node.link & kernels::VOXEL_LINK_KIND;
        kernels::uint rank = 0;
        for (std::uint64_t rest = mask_of(node); rest != 0; rest &= rest - 1, ++rank) {
            const int child = std::countr_zero(rest);
            const ivec3 corner = lower + (ivec3(child & 3, child >> 2 & 3, child >> 4) << (2 * level));
            if (kind == kernels::VOXEL_LINK_CHILDREN) visit(child_of(node, rank), level - 1, corner, function);
            else function(corner, 1 << (2 * level), palette_of(node, rank));
        }
    }
    static std::uint64_t mask_of(const kernels::VoxelNode& node) {
        return node.mask_low | std::uint64_t(node.mask_high) << 32;
    }
    const kernels::VoxelNode& child_of(const kernels::VoxelNode& node, kernels::uint rank) const {
        return arrays_.nodes[arrays_.references.empty() ? node.link + rank : arrays_.references[node.link + rank]];
    }
    std::uint16_t palette_of(const kernels::VoxelNode& node, kernels::uint rank) const {
        const kernels::uint at = node.link & ~kernels::VOXEL_LINK_KIND;
        switch (node.link & kernels::VOXEL_LINK_KIND) {
            case kernels::VOXEL_LINK_BYTES: return arrays_.palettes[at + (rank >> 2)] >> (8 * (rank & 3)) & 0xff;
            case kernels::VOXEL_LINK_HALVES: return arrays_.palettes[at + (rank >> 1)] >> (16 * (rank & 1)) & 0xffff;
            default: return std::uint16_t(at);
        }
    }

    ivec3 size_;
    int level_count_;
    std::uint64_t voxel_count_;
    std::uint16_t palette_maximum_;
    Arrays arrays_;
};
using VoxelTreePointer = std::shared_ptr<const VoxelTree>;

// ---------------------------------------------------------------------------------------------------------- builders
// Each edge of `size` is from 1 to VoxelTree::max_edge. None ever holds a dense grid of its own.

struct VoxelTreeOptions {
    bool share = false;  // equal subtrees are kept once: smaller, a little slower to build and to walk
};

struct VoxelPoint {
    ivec3 cell;
    std::uint16_t palette;  // 0 empties the cell
};

// Of points at the same cell the last one counts.
Result<VoxelTreePointer> build_voxel_tree(ivec3 size, std::vector<VoxelPoint> points,
                                          const VoxelTreeOptions& options = {});

// All cells, x fastest, then y, then z.
Result<VoxelTreePointer> build_voxel_tree(ivec3 size, std::span<const std::uint8_t> cells,
                                          const VoxelTreeOptions& options = {});
Result<VoxelTreePointer> build_voxel_tree(ivec3 size, std::span<const std::uint16_t> cells,
                                          const VoxelTreeOptions& options = {});

// A set given by functions, which are called from several threads at once.
struct VoxelFunction {
    std::function<std::uint16_t(ivec3 cell)> palette;
    // May be missing: the palette index of all cells in lower ≤ cell < upper (0: all are empty), or nothing if they
    // differ or that is not known. What it answers for is never looked at cell by cell.
    std::function<std::optional<std::uint16_t>(ivec3 lower, ivec3 upper)> box;
};
Result<VoxelTreePointer> build_voxel_tree(ivec3 size, const VoxelFunction& function,
                                          const VoxelTreeOptions& options = {});

// The same set with equal subtrees kept once.
VoxelTreePointer with_shared_subtrees(const VoxelTree& tree);

}  // namespace spinel
