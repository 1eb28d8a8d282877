#pragma once
// Sound bounds of the noises of kernels/noise.h over a box, by interval arithmetic.

#include "kernels/noise.h"

namespace spinel {

struct Interval {
    float low = 0;
    float high = 0;
};

// Of fractal_noise(kind, p, octaves, gain, lacunarity) for all lower ≤ p ≤ upper.
Interval noise_bounds(kernels::uint kind, glm::vec3 lower, glm::vec3 upper, kernels::uint octaves, float gain,
                      float lacunarity);

}  // namespace spinel
