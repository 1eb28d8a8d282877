#pragma once
// A level set as fog: density 1 inside, falling to 0 over the inner half of its band.

#include "spinel/scene.h"

namespace spinel {

// Looked up linearly. The band is as wide as the background says, or, where that is 0, the least value.
Grid fog_of_level_set(const Grid& level_set);

}  // namespace spinel
