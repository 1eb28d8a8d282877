#pragma once
// Builds the uniform and hierarchical grids that kernels/mesh_grid.h walks, from boxes and a way to ask which cells a
// primitive touches: the grid never knows a shape.

#include <functional>
#include <span>
#include <vector>

#include "accel/bvh_builder.h"

namespace spinel {

// Calls visit(cell) for the cells, 0 ≤ cell < size, of a grid that begins at `lower` that a primitive touches or comes
// within kernels::GRID_MARGIN of a cell's edge to: for some cells too many, for none too few. Called from several
// threads.
struct CellGrid {
    glm::vec3 lower;
    glm::vec3 cell;
    glm::ivec3 size;
};
using VisitCell = std::function<void(glm::ivec3 cell)>;
using CellsOfPrimitive = std::function<void(std::uint32_t primitive, const CellGrid& grid, const VisitCell& visit)>;

struct GridOptions {
    double density = 4;  // cells for each primitive
    std::uint32_t refine_above =
        0;                   // a cell with more primitives becomes a grid, if that makes it cheaper; 0: none does
    float step_cost = 0.5f;  // of going to the next cell, in primitive tests
    // In cells, for each primitive, and 2²⁰ besides: where there would be more, the grid is coarser and less is
    // refined.
    std::size_t references = 16;
};

struct Grid3 {
    std::vector<kernels::MeshGrid> grids;  // the first holds all
    // Nothing; then cells and lists, each its length and places in `order`.
    std::vector<std::uint32_t> words;
    std::vector<std::uint32_t> order;  // of all boxes, those of a cell together where possible
    double sah_cost = 0;               // of a ray that meets the bounds, in primitive tests
    std::uint32_t depth = 0;           // grids within grids
    std::size_t list_count = 0;        // cells that are neither empty nor refined
};

// All boxes finite and ordered, at most BVH_MAX_PRIMITIVES. The result depends on the boxes only, not on the number of
// threads.
Grid3 build_grid(std::span<const Box> boxes, const CellsOfPrimitive& cells_of, const GridOptions& options = {});

}  // namespace spinel
