#include "geometry/mesh/mesh_structures.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "accel/grid_builder.h"
#include "accel/kd_builder.h"
#include "accel/sphere_builder.h"
#include "accel/wide_refit.h"
#include "geometry/mesh/triangle_clip.h"
#include "geometry/mesh/wide_mesh.h"
#include "geometry/voxels/triangle_cells.h"
#include "kernels/mesh_grid.h"

namespace spinel {
namespace {

Result<void> check_index(const char* structure, std::size_t size, std::size_t most) {
    if (size < most) return {};
    return Error{"mesh is too large for a " + std::string(structure) + ": " + std::to_string(size) +
                 " nodes or references; allowed: less than " + std::to_string(most)};
}

Result<void> take(Bvh&& bvh, MeshArrays& arrays, MeshStatistics& statistics) {
    // An entry of a walk's stack holds a node in 28 bits.
    if (auto r = check_index("binary BVH", bvh.nodes.size(), std::size_t(1) << 28); !r) return r;
    if (bvh.statistics.depth > kernels::BVH_MAX_DEPTH)
        return Error{"a binary BVH is " + std::to_string(bvh.statistics.depth) +
                     " levels deep; allowed: " + std::to_string(kernels::BVH_MAX_DEPTH)};
    statistics.sah_cost = bvh.statistics.sah_cost;
    statistics.depth = bvh.statistics.depth;
    statistics.leaf_count = bvh.statistics.leaf_count;
    arrays.nodes = std::move(bvh.nodes);
    arrays.order = std::move(bvh.order);
    return {};
}

std::vector<Box> boxes_of(std::span<const kernels::Triangle> triangles) {
    std::vector<Box> boxes;
    boxes.reserve(triangles.size());
    for (const kernels::Triangle& t : triangles)
        boxes.push_back({glm::min(t.a, glm::min(t.b, t.c)), glm::max(t.a, glm::max(t.b, t.c))});
    return boxes;
}

Result<void> build_stackless(const MeshInput& input, MeshArrays& arrays, MeshStatistics& statistics) {
    if (auto r = take(build_bvh(boxes_of(input.triangles)), arrays, statistics); !r) return r;
    arrays.nodes = with_skip_links(arrays.nodes);
    return {};
}

template <BvhMethod method>
Result<void> build_bvh2(const MeshInput& input, MeshArrays& arrays, MeshStatistics& statistics) {
    return take(build_bvh(boxes_of(input.triangles), {.method = method}), arrays, statistics);
}

void refit_bvh2(std::span<const kernels::Triangle> triangles, MeshArrays& arrays) {
    refit_bvh(arrays.nodes, boxes_of(triangles));
}

Result<void> build_spheres(const MeshInput& input, MeshArrays& arrays, MeshStatistics& statistics) {
    constexpr BvhOptions options;
    if (auto r = take(build_bvh(boxes_of(input.triangles), options), arrays, statistics); !r) return r;
    arrays.sphere_nodes = sphere_nodes(arrays.nodes, [&](std::uint32_t place, const glm::dvec3& from) {
        const kernels::Triangle& t = input.triangles[arrays.order[place]];
        const auto square = [&](const glm::vec3& p) {
            const glm::dvec3 d = glm::dvec3(p) - from;
            return glm::dot(d, d);
        };
        return std::sqrt(std::max({square(t.a), square(t.b), square(t.c)}));
    });
    arrays.nodes.clear();
    statistics.sah_cost = sphere_cost(arrays.sphere_nodes, options.traversal_cost);
    return {};
}

Result<void> build_kd(const MeshInput& input, MeshArrays& arrays, MeshStatistics& statistics) {
    KdTree tree = build_kd_tree(boxes_of(input.triangles), [&](std::uint32_t i, const Box& region) {
        return clipped_bounds(input.triangles[i], region);
    });
    const std::size_t most = std::size_t(1) << 29;
    if (auto r = check_index("kd-tree", std::max(tree.nodes.size(), tree.references.size()), most); !r) return r;
    // Triangles in the order in which leaves name them first.
    std::vector<std::uint32_t> place(input.triangles.size(), kernels::NONE);
    for (std::uint32_t& reference : tree.references) {
        std::uint32_t& p = place[reference];
        if (p == kernels::NONE) {
            p = std::uint32_t(arrays.order.size());
            arrays.order.push_back(reference);
        }
        reference = p;
    }
    arrays.kd_nodes = std::move(tree.nodes);
    arrays.references = std::move(tree.references);
    statistics.sah_cost = tree.sah_cost;
    statistics.depth = tree.depth;
    statistics.leaf_count = tree.leaf_count;
    return {};
}

template <bool hierarchical>
Result<void> build_grids(const MeshInput& input, MeshArrays& arrays, MeshStatistics& statistics) {
    const auto cells_of = [&](std::uint32_t i, const CellGrid& grid, const VisitCell& visit) {
        const kernels::Triangle& t = input.triangles[i];
        const auto in_cells = [&](const glm::vec3& p) {
            return (glm::dvec3(p) - glm::dvec3(grid.lower)) / glm::dvec3(grid.cell);
        };
        const TriangleCells cells(in_cells(t.a), in_cells(t.b), in_cells(t.c), double(kernels::GRID_MARGIN));
        cells.for_each(glm::ivec3(0), grid.size, visit);
    };
    GridOptions options;
    if (hierarchical) options = {.density = 1, .refine_above = 8};
    Grid3 grid = build_grid(boxes_of(input.triangles), cells_of, options);
    if (auto r = check_index("grid", grid.words.size(), kernels::GRID_REFINED); !r) return r;
    arrays.grids = std::move(grid.grids);
    arrays.references = std::move(grid.words);
    arrays.order = std::move(grid.order);
    statistics.sah_cost = grid.sah_cost;
    statistics.depth = grid.depth;
    statistics.leaf_count = grid.list_count;
    return {};
}

// References address whole units, those of the compact layout halves of them.
template <WideBvh (*build)(std::span<const kernels::Triangle>, const WidePreset&), std::size_t most_units>
Result<void> build_wide(const MeshInput& input, MeshArrays& arrays, MeshStatistics& statistics) {
    WideBvh tree = build(input.triangles, *input.preset);
    if (auto r = check_index("wide BVH", tree.units.size(), most_units); !r) return r;
    arrays.wide_units = std::move(tree.units);
    arrays.order.resize(input.triangles.size());
    std::iota(arrays.order.begin(), arrays.order.end(), 0u);
    statistics.sah_cost = tree.statistics.sah_cost * 4;  // a block costs as much as four triangles
    statistics.depth = tree.statistics.depth;
    statistics.leaf_count = tree.statistics.block_count;
    return {};
}

void refit_wide(std::span<const kernels::Triangle> triangles, MeshArrays& arrays) {
    refit_wide_bvh(arrays.wide_units, triangles);
}

constexpr MeshStructure structures[] = {
    {"wide-bvh8", "BVH of eight children, spatial splits where boxes overlap much; AVX2 on CPUs",
     build_wide<build_wide_mesh, std::size_t(1) << 28>, kernels::MESH_WALK_WIDE, true, refit_wide},
    {"wide-bvh8-compact", "the same in half the memory: boxes in bytes, vertices shared within leaves; AVX2 on CPUs",
     build_wide<build_compact_mesh, std::size_t(1) << 27>, kernels::MESH_WALK_COMPACT, true},
    {"bvh2", "binary BVH by binned surface area heuristic, stack walk", build_bvh2<BvhMethod::binned>,
     kernels::MESH_WALK_BVH2, false, refit_bvh2},
    {"bvh2-sweep", "binary BVH by surface area heuristic at every plane", build_bvh2<BvhMethod::sweep>,
     kernels::MESH_WALK_BVH2, false, refit_bvh2},
    {"bvh2-reinsertion",
     "the tree of bvh2, its nodes moved to where they cost the least: for long renders of interiors",
     build_bvh2<BvhMethod::reinsertion>, kernels::MESH_WALK_BVH2, false, refit_bvh2},
    {"bvh2-median", "binary BVH that halves by number", build_bvh2<BvhMethod::median>, kernels::MESH_WALK_BVH2, false,
     refit_bvh2},
    {"bvh2-stackless", "the tree of bvh2, walked by skip links", build_stackless, kernels::MESH_WALK_STACKLESS},
    {"kd-tree", "kd-tree by surface area heuristic over clipped triangles, 8-byte nodes", build_kd,
     kernels::MESH_WALK_KD},
    {"grid", "uniform grid, 3D-DDA, mailboxes", build_grids<false>, kernels::MESH_WALK_GRID},
    {"grid-hierarchical", "grids within the cells of a grid, where much lies close together", build_grids<true>,
     kernels::MESH_WALK_GRID},
    {"spheres", "the tree of bvh2 with balls in place of boxes: an experiment", build_spheres,
     kernels::MESH_WALK_SPHERES},
};

constexpr TriangleTest tests[] = {
    {"watertight", "Woop, Benthin, Wald 2013: no ray slips between two triangles", kernels::TRIANGLE_WATERTIGHT},
    {"moller-trumbore", "Möller and Trumbore 1997", kernels::TRIANGLE_MOLLER_TRUMBORE},
    {"plane", "the plane, then the areas that its point spans with the edges", kernels::TRIANGLE_PLANE},
    {"unit-triangle", "an affine map for each triangle (Woop 2004), 48 bytes in place of 36", kernels::TRIANGLE_UNIT},
    {"watertight-indexed", "watertight, vertices fetched by index in place of gathered ones",
     kernels::TRIANGLE_INDEXED},
};

template <class Row>
Result<const Row*> find(std::span<const Row> table, std::string_view name, const char* what) {
    if (name.empty()) return &table.front();
    std::string available;
    for (const Row& row : table) {
        if (row.name == name) return &row;
        available += (available.empty() ? "" : ", ") + std::string(row.name);
    }
    return Error{"unknown " + std::string(what) + " '" + std::string(name) + "'; available: " + available};
}

}  // namespace

std::span<const MeshStructure> mesh_structures() { return structures; }
std::span<const TriangleTest> triangle_tests() { return tests; }

Result<const MeshStructure*> find_mesh_structure(std::string_view name) {
    return find<MeshStructure>(structures, name, "accelerator");
}
Result<const TriangleTest*> find_triangle_test(std::string_view name) {
    return find<TriangleTest>(tests, name, "triangle test");
}

Result<const WidePreset*> find_preset(const MeshStructure& structure, std::string_view name) {
    if (structure.has_presets)
        return name.empty() ? &default_wide_preset() : find<WidePreset>(wide_presets(), name, "preset");
    if (name.empty()) return nullptr;
    std::string available;
    for (const MeshStructure& row : structures)
        if (row.has_presets) available += (available.empty() ? "" : ", ") + std::string(row.name);
    return Error{"accelerator '" + std::string(structure.name) + "' has no presets, and '" + std::string(name) +
                 "' is asked for; those that have: " + available};
}

}  // namespace spinel
