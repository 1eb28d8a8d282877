#pragma once
// The way back: a scene as a scene file.

#include <string>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

// A text that read_scene_json reads back to the same scene, except for names: what has none, or one that is
// taken, gets one. Geometry is written in place, pictures by the path they came from; a picture without one
// is an error.
Result<std::string> write_scene_json(const Scene& scene);

}  // namespace spinel
