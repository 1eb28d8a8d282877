#pragma once
// Puts one scene's things behind another's, for models that stand in a scene.

#include <vector>

#include "spinel/scene.h"

namespace spinel {

// Appends textures, materials, grids, media and geometries of `model` to `scene` and returns the model's
// objects with their indices shifted. Cameras, lights, environment and settings of the model are left out.
std::vector<Object> merge_model(Scene& scene, Scene model);

// a ∘ b: what b does, then a.
mat4x3 compose(const mat4x3& a, const mat4x3& b);

}  // namespace spinel
