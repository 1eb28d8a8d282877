#pragma once
// A bare model becomes a picture: what a scene lacks to be photographed is added, fitted to what is there.

#include "spinel/scene.h"

namespace spinel {

// Adds a camera that frames all objects from the front right and a little above, for the film's size. Does nothing if
// there is nothing bounded.
void fit_camera(Scene& scene);

// The same, if there is no camera; a limit to the sparks of indirect light; and sun and sky if there is neither an
// environment nor a light; and a ground plane under the objects and fog around them, as the scene's surroundings say.
void complete_model(Scene& scene);

// Points that stand for the shape of all objects in world space: vertices, voxels, corners of bounds. At most a few ten
// thousand, so that big models cost no more than small ones. Empty if nothing is bounded.
std::vector<vec3> outline_points(const Scene& scene);

}  // namespace spinel
