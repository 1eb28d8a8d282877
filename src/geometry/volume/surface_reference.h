#pragma once
// The naive twin of kernels/sdf_grid.h: look-ups in double precision, from the samples as they were read.

#include "spinel/scene.h"

namespace spinel {

// The grid's value at p in index space less the level, negated where the solid is above it: below 0 in the solid.
// Linear or cubic, as the grid's filter says; beyond the outermost samples it is what it is there.
double surface_reference(const VolumeGeometry& volume, const Grid& grid, glm::dvec3 p);

}  // namespace spinel
