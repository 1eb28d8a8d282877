#pragma once
// The rays that traversal is measured with, made from what a scene's camera sees.

#include <vector>

#include "kernels/scene_view.h"

namespace spinel::cli {

// Each a multiple of eight, neighbours together.
struct BenchRays {
    std::vector<kernels::Ray> primary;  // through the centres of a square of pixels, in blocks of 4×2
    std::vector<kernels::Ray> diffuse;  // one cosine-distributed bounce from each hit
    std::vector<kernels::Ray> shadow;   // from each hit to a light chosen by chance; none where nothing shines
};

// Rays of the scene's camera, whose resolution is edge × edge.
BenchRays scene_rays(const kernels::SceneView& scene, int edge);

// The same for one set of voxels alone, in its own space: the camera's rays carried into that of the instance, bounces
// that start 0.001 voxels off the face.
BenchRays voxel_rays(const kernels::SceneView& scene, kernels::uint instance, int edge);

}  // namespace spinel::cli
