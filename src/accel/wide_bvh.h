#pragma once
// Makes eight-wide hierarchies, which CPUs walk, out of binary ones (wide_plan.h), with the vertices of triangles
// gathered in blocks of four.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/wide_plan.h"
#include "core/huge_pages.h"

namespace spinel {

struct WideBvhStatistics {
    double sah_cost = 0;  // expected cost of a ray that meets the root's box, in units of the options' costs
    std::uint32_t depth = 0;
    std::uint32_t node_count = 0;
    std::uint32_t block_count = 0;
    std::uint32_t triangle_count = 0;  // in blocks, those that stand in several of them counted as often
};

struct WideBvh {
    HugeVector<kernels::WideUnit> units;  // the root first; empty without triangles
    WideBvhStatistics statistics;
};

// `binary` is over the triangles; its order may name a triangle several times, in leaves that each bound a part of it.
// The result depends on the arguments only. Units are addressed by 28 bits: about 10⁸ triangles.
WideBvh collapse_bvh(const Bvh& binary, std::span<const kernels::Triangle> triangles,
                     const WideBvhOptions& options = {});

constexpr std::uint32_t wide_block = 4;  // triangles in a block at most

// Writes the block, of WIDE_BLOCK_UNITS, of triangles that `indices` name, at most four.
void write_wide_block(std::span<const kernels::Triangle> triangles, std::span<const std::uint32_t> indices,
                      float* rows);

struct WideChild {
    const kernels::BvhNode* box;  // its bounds alone are read
    std::uint32_t reference;      // as WideUnit has it: the unit of a node, or that of blocks and how many they are
};
// At most eight children, in their order.
void write_wide_node(std::span<const WideChild> children, kernels::WideUnit* units);

// What is written before the hierarchy over it is known: blocks, and nodes over blocks.
class WideParts {
  public:
    WideParts() = default;
    WideParts(std::size_t blocks, std::size_t ready);
    kernels::WideUnit* block(std::size_t number) { return &units_[unit_of_block(number)]; }
    kernels::WideUnit* ready(std::size_t number) { return &units_[unit_of_ready(number)]; }
    static std::uint32_t block_reference(std::size_t first, std::uint32_t count) {
        return count << 28 | unit_of_block(first);
    }

  private:
    friend WideBvh collapse_parts(std::span<const kernels::BvhNode>, WideParts, std::span<const WideReady>,
                                  const WideBvhOptions&);
    static std::uint32_t unit_of_block(std::size_t number) {
        return std::uint32_t(kernels::WIDE_NODE_UNITS + number * kernels::WIDE_BLOCK_UNITS);
    }
    std::uint32_t unit_of_ready(std::size_t number) const {
        return std::uint32_t(first_ready_ + number * kernels::WIDE_NODE_UNITS);
    }

    std::uint32_t first_ready_ = 0;
    HugeVector<kernels::WideUnit> units_;  // the root, blocks, nodes that are ready and others
};

// As collapse_bvh(), with `binary` over blocks, one in each leaf, which its `first` names, and over nodes that are
// ready, which hold blocks alone and may be moved; those of no primitives are not there. Its root is none of them.
// Counts blocks as triangles.
WideBvh collapse_parts(std::span<const kernels::BvhNode> binary, WideParts parts, std::span<const WideReady> ready,
                       const WideBvhOptions& options = {});

}  // namespace spinel
