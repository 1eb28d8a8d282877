#pragma once
// The naive twin of `single-scatter`: every step of every march is taken, noise is worked out where there is nothing to
// eat, shadows where nothing scatters, and what is hidden by an opaque cloud is marched through as well. What a program
// without any thought would do, as the measure of what thought is worth.

#include "kernels/interior.h"
#include "kernels/path_settings.h"
#include "kernels/pixel_sample.h"
#include "kernels/random.h"

namespace spinel {

kernels::PixelSample reference_single_scatter(const kernels::SceneView& scene, const kernels::MarchSettings& settings,
                                              const kernels::Ray& ray, const kernels::Inside& inside,
                                              kernels::Sampler numbers);

}  // namespace spinel
