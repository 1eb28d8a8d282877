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

// Blocks that are written before the hierarchy over them is known.
class WideBlocks {
  public:
    explicit WideBlocks(std::size_t count);
    std::span<kernels::WideUnit> units() { return std::span(units_).subspan(kernels::WIDE_NODE_UNITS); }

  private:
    friend WideBvh collapse_blocks(const Bvh&, WideBlocks, const WideBvhOptions&);
    HugeVector<kernels::WideUnit> units_;  // behind the root
};

// As collapse_bvh(), with `binary` over the blocks, one in each leaf, which its `first` names. Counts blocks as
// triangles.
WideBvh collapse_blocks(const Bvh& binary, WideBlocks blocks, const WideBvhOptions& options = {});

}  // namespace spinel
