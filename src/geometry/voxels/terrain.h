#pragma once
// Integer terrain: hills with caves and trees, the same everywhere, since it is made of integers alone.
//
// Heights are seven octaves of value noise; caves are where two noises in space are both near their middle, which makes
// winding tunnels; every tile of 16×16 columns may hold one tree. No floating point, no state: a cell depends on its
// coordinates only.

#include <cstdint>
#include <memory>

#include "spinel/voxels.h"

namespace spinel {

enum TerrainPalette : std::uint16_t {
    TERRAIN_GRASS = 1,
    TERRAIN_DIRT = 2,
    TERRAIN_STONE = 3,
    TERRAIN_WOOD = 4,
    TERRAIN_LEAVES = 5,
};

constexpr int terrain_height_limit = 256;  // nothing is above

// Cells 0 ≤ x < width, 0 ≤ z < depth; the width and depth that the noise tables are made for.
class Terrain {
  public:
    Terrain(int width, int depth);
    ~Terrain();

    int height(int x, int z) const;  // of the ground: solid cells go from 0 to it
    std::uint16_t at(ivec3 cell) const;
    std::optional<std::uint16_t> box(ivec3 lower, ivec3 upper) const;

  private:
    struct Tables;
    std::unique_ptr<const Tables> tables_;
};

// With `strata` the palette indices above, otherwise 1 throughout: the shape alone.
Result<VoxelTreePointer> build_terrain(ivec3 size, bool strata = true, const VoxelTreeOptions& options = {});

}  // namespace spinel
