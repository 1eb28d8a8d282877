#pragma once
// What a black body looks like.

#include "kernels/portable.h"

namespace spinel {

// Linear Rec.709 of a black body's radiance at so many kelvin, relative to its luminance at `reference` kelvin. Colours
// outside of Rec.709, the deep reds, lose their negative parts.
glm::vec3 black_body(float kelvin, float reference);

}  // namespace spinel
