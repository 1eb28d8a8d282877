#pragma once
// The naive twin of the tape: an expression evaluated by recursion, in double precision, straight from its
// definition. No registers, no cut-offs, no bounds. The compiled solid is tested against its sign.

#include <glm/glm.hpp>

#include "spinel/scene.h"

namespace spinel {

// The expression must be valid (build_sdf accepts it). An endless repeat looks at 5 cells along each axis.
double sdf_reference(const SdfNode& node, glm::dvec3 p);

}  // namespace spinel
