#pragma once
// The acceleration structures that a mesh can be built into, and the tests of rays against its triangles: two tables.
//
// To add a structure: a build function and its row here, with a refit function if boxes can follow vertices; if it is
// walked in a way of its own, a constant MESH_WALK_… in kernels/scene_view.h, the walk in a header of its own and its
// case in kernels/mesh.h. Scene files, `spinel trace`, `bench` and `list`, error messages and the tests against brute
// force take it from the table.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "accel/bvh_builder.h"
#include "core/huge_pages.h"
#include "core/result.h"

namespace spinel {

struct WidePreset;

// Triangles with an area.
struct MeshInput {
    std::span<const kernels::Triangle> triangles;
    const WidePreset* preset;  // null for structures that have none
};

// What a walk reads besides the triangles; every array but those of the structure's own walk stays empty.
struct MeshArrays {
    std::vector<std::uint32_t> order;  // of all triangles as they are to be stored, each once
    std::vector<kernels::BvhNode> nodes;
    std::vector<kernels::KdNode> kd_nodes;
    std::vector<kernels::SphereNode> sphere_nodes;
    std::vector<kernels::MeshGrid> grids;
    HugeVector<kernels::WideUnit> wide_units;
    std::vector<std::uint32_t> references;  // of structures that name triangles by their place in the order
};

struct MeshStatistics {
    double sah_cost = 0;         // what a ray that meets the bounds is expected to cost, in triangle tests
    std::uint32_t depth = 0;     // levels below the root, of trees and of grids within grids
    std::size_t leaf_count = 0;  // leaves, or cells that are not empty
    std::size_t bytes = 0;       // nodes, references and what the test reads of triangles
    double build_ms = 0;         // of the structure alone
};

struct MeshStructure {
    const char* name;
    const char* doc;
    // Fails where there is more than the indices of nodes can tell apart.
    Result<void> (*build)(const MeshInput& input, MeshArrays& arrays, MeshStatistics& statistics);
    kernels::uint walk;        // MESH_WALK_…
    bool has_presets = false;  // those of wide_mesh.h
    // Boxes anew for triangles that have moved, in the order of the structure: right whatever moved, fast as long as
    // neighbours stay neighbours. Null: it has to be built anew.
    void (*refit)(std::span<const kernels::Triangle> triangles, MeshArrays& arrays) = nullptr;
};

// The first is the default.
std::span<const MeshStructure> mesh_structures();

struct TriangleTest {
    const char* name;
    const char* doc;
    kernels::uint test;  // TRIANGLE_…
};

// The first is the default.
std::span<const TriangleTest> triangle_tests();

// By name, the default for an empty one, or an error that lists what there is.
Result<const MeshStructure*> find_mesh_structure(std::string_view name);
Result<const TriangleTest*> find_triangle_test(std::string_view name);
// Null for structures without presets, to which a name is an error.
Result<const WidePreset*> find_preset(const MeshStructure& structure, std::string_view name);

}  // namespace spinel
