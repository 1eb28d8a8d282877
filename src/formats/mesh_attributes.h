#pragma once
// Vertex attributes that mesh files leave out.

#include "spinel/scene.h"

namespace spinel {

// Merges vertices that are equal in every attribute, to the bit.
void weld_vertices(MeshGeometry& mesh);

// Normals that are smooth over edges whose faces meet at less than `crease_degrees` and sharp over the
// others: at each corner the mean of such neighbours' face normals, weighted by the angle at the corner
// (Thürmer, Wüthrich 1998), which does not depend on how a surface is cut into triangles. Vertices at the
// same place count as one. Splits vertices where needed. Corners around which everything is degenerate get a
// zero normal: "use the geometric one".
void generate_normals(MeshGeometry& mesh, float crease_degrees);

// Tangents along +u for normal mapping, from positions, normals and uvs; vertices where mirrored and
// unmirrored uvs meet are split. Zero where the uvs have no direction.
void generate_tangents(MeshGeometry& mesh);

}  // namespace spinel
