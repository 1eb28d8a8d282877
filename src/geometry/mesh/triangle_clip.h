#pragma once
// Bounds of the part of a triangle that lies in a box, for structures that cut space.

#include "accel/bvh_builder.h"

namespace spinel {

// No smaller than the part: computed in double (Sutherland and Hodgman 1974) and rounded outwards, but within the
// region. lower > upper if nothing of the triangle is in there.
Box clipped_bounds(const kernels::Triangle& triangle, const Box& region);

}  // namespace spinel
