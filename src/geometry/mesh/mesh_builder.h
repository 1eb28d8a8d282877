#pragma once
// From a mesh as the user gave it to the arrays that kernels/mesh.h walks.

#include <vector>

#include "accel/bvh_builder.h"
#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

// Indices are relative: nodes to nodes, leaves to triangles, TriangleInfo::vertices to the user's vertices,
// whose attributes are used as they are. Triangles and infos stand in leaf order. A triangle whose area vanishes in
// single precision is left out: it has no normal, and nothing hits it. If none is left, nodes and triangles are empty.
struct MeshData {
    std::vector<kernels::BvhNode> nodes;
    std::vector<kernels::Triangle> triangles;
    std::vector<kernels::TriangleInfo> infos;
    Box bounds;  // of the vertices
    BvhStatistics statistics;
};

// At least one triangle; indices within the positions; positions finite; attribute arrays empty or one a
// vertex, slots empty or one a triangle.
Result<void> validate_mesh(const MeshGeometry& mesh);

// Validates first.
Result<MeshData> build_mesh(const MeshGeometry& mesh, const BvhOptions& options = {});

}  // namespace spinel
