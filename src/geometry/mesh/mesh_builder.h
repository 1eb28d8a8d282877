#pragma once
// From a mesh as the user gave it to the arrays that kernels/mesh.h walks.

#include <span>
#include <utility>
#include <vector>

#include "core/pool.h"
#include "core/result.h"
#include "geometry/mesh/mesh_structures.h"
#include "spinel/scene.h"

namespace spinel {

// Indices are relative: nodes to nodes, leaves to triangles, TriangleInfo::vertices to the user's vertices,
// whose attributes are used as they are. Triangles and infos stand in the structure's order. A triangle whose area
// vanishes in single precision is left out: it has no normal, and nothing hits it. If none is left, the structure and
// the triangles are empty.
struct MeshData {
    MeshArrays structure;
    std::vector<kernels::Triangle> triangles;
    std::vector<kernels::TriangleInfo> infos;
    std::vector<kernels::UnitTriangle> unit_triangles;  // of a test that needs them, one a triangle
    bool positions_needed = false;                      // by the test: the user's own, by TriangleInfo::vertices
    kernels::uint walk = 0;                             // MESH_WALK_…
    kernels::uint triangle_test = 0;                    // TRIANGLE_…
    Box bounds;                                         // of the vertices
    Box triangle_bounds;                                // of what is left, no smaller than the structure's
    MeshStatistics statistics;
};

// The map that kernels::triangle_unit() wants. In double, as that of a thin triangle is large; z counts along the
// normal, in units of the root of twice the area, so that all three rows are of a size.
kernels::UnitTriangle unit_triangle(const kernels::Triangle& t);

// At least one triangle; indices within the positions; positions finite; attribute arrays empty or one a
// vertex, slots empty or one a triangle.
Result<void> validate_mesh(const MeshGeometry& mesh);

// What the names in the settings stand for, empty ones for the defaults; or the error of the first that is unknown.
struct AcceleratorChoice {
    const MeshStructure* structure;
    const TriangleTest* test;
    const WidePreset* preset;  // null: the structure has none
};
Result<AcceleratorChoice> choose_accelerator(const AcceleratorSettings& settings);

// All of a mesh but its structure, triangles in the user's order, after validation.
Result<MeshData> read_mesh(const MeshGeometry& mesh, const AcceleratorChoice& choice);
// The structure over triangles with an area.
struct MeshStructureData {
    MeshArrays arrays;
    MeshStatistics statistics;  // without bytes
};
Result<MeshStructureData> build_structure(std::span<const kernels::Triangle> triangles,
                                          const AcceleratorChoice& choice);

// Both. Names of mesh_structures(), triangle_tests() and wide_presets(); empty ones mean the default.
Result<MeshData> build_mesh(const MeshGeometry& mesh, const AcceleratorSettings& accelerator = {});

// Moves a mesh in place of building it anew: `moved` is what `data` was built from by `choice`, with vertices at other
// places. Hits are right whatever moved; statistics stay those of the tree as it was built. False, and nothing is
// changed, where the mesh has to be built anew: the structure has no refit or is another, triangles or slots are
// others, or one has got an area that had none or lost it.
Result<bool> refit_mesh(const MeshGeometry& moved, const AcceleratorChoice& choice, MeshData& data);

// Appends a mesh, its attributes included, to pools that are named as those of a CompiledScene.
template <class Pools>
Result<kernels::Mesh> append_mesh(Pools& out, const MeshGeometry& mesh, const MeshData& data) {
    const auto stream = [](auto& to, const auto& from, const char* what) -> Result<std::uint32_t> {
        if (from.empty()) return kernels::NONE;
        return append_pool(to, from, what);
    };
    kernels::Mesh record = {};
    record.lower = data.triangle_bounds.lower;
    record.upper = data.triangle_bounds.upper;
    record.walk = data.walk;
    record.triangle_test = data.triangle_test;
    record.triangle_count = std::uint32_t(data.triangles.size());
    const MeshArrays& arrays = data.structure;
    Result<std::uint32_t> node_first = std::uint32_t(0), test_first = std::uint32_t(0);
    if (!arrays.nodes.empty()) node_first = append_pool(out.nodes, arrays.nodes, "nodes of meshes");
    if (!arrays.kd_nodes.empty()) node_first = append_pool(out.kd_nodes, arrays.kd_nodes, "nodes of kd-trees");
    if (!arrays.sphere_nodes.empty()) node_first = append_pool(out.sphere_nodes, arrays.sphere_nodes, "spheres");
    if (!arrays.grids.empty()) node_first = append_pool(out.mesh_grids, arrays.grids, "grids");
    if (!arrays.wide_units.empty()) node_first = append_pool(out.wide_units, arrays.wide_units, "units of wide trees");
    if (!data.unit_triangles.empty()) test_first = append_pool(out.unit_triangles, data.unit_triangles, "triangles");
    if (data.positions_needed) test_first = append_pool(out.positions, mesh.positions, "vertices");
    const std::pair<std::uint32_t&, Result<std::uint32_t>> places[] = {
        {record.node_first, node_first},
        {record.test_first, test_first},
        {record.reference_first, append_pool(out.words, arrays.references, "words")},
        {record.triangle_first, append_pool(out.triangles, data.triangles, "triangles")},
        {record.normal_first, stream(out.normals, mesh.normals, "normals of vertices")},
        {record.uv_first, stream(out.uvs, mesh.uvs, "texture coordinates of vertices")},
        {record.second_uv_first, stream(out.uvs, mesh.second_uvs, "texture coordinates of vertices")},
        {record.tangent_first, stream(out.tangents, mesh.tangents, "tangents of vertices")},
        {record.color_first, stream(out.colors, mesh.colors, "colours of vertices")}};
    for (const auto& [first, place] : places) {
        if (!place) return place.error();
        first = *place;
    }
    out.triangle_infos.insert(out.triangle_infos.end(), data.infos.begin(), data.infos.end());  // one a triangle
    return record;
}

}  // namespace spinel
