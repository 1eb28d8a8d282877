#pragma once
// Wide hierarchies of meshes that move: the tree stays, its boxes and the vertices in its leaves are written anew.

#include <span>

#include "accel/wide_bvh.h"

namespace spinel {

// `triangles` as the tree was built over, the same number in the same order, at other places. What is found afterwards
// is right whatever moved; it is found fast as long as neighbours stay neighbours. Boxes hold whole triangles from then
// on, so a tree with spatial splits loses what they gave. Bounds of the whole mesh (kernels::Mesh::lower, upper) are
// the caller's to renew.
void refit_wide_bvh(std::span<kernels::WideUnit> units, std::span<const kernels::Triangle> triangles);

}  // namespace spinel
