#pragma once
// Polygons of mesh files, cut into triangles.

#include <span>
#include <vector>

#include "spinel/scene.h"

namespace spinel {

// Appends the n − 2 triangles of a polygon of n ≥ 3 corners, which need be neither convex nor quite flat. Ear
// clipping (Meisters 1975) seen along Newell's normal; polygons of more than 1024 corners are taken to be
// convex.
void triangulate(std::span<const vec3> positions, std::span<const unsigned> polygon, std::vector<uvec3>& triangles);

}  // namespace spinel
