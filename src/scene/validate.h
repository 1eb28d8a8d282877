#pragma once
// What must hold for a scene to be rendered, wherever it came from: built by hand, read from JSON or from a
// model.

#include <cstdint>
#include <optional>
#include <string>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

// The first fault of the scene, as one sentence that names the thing.
Result<void> validate(const Scene& scene);

// The fault of one thing, seen alone, to be put behind its name ("has a film of zero size"); nothing if there
// is none. A reader that knows positions asks for these as it goes.
std::optional<std::string> fault(const Camera& camera);
std::optional<std::string> fault(const Film& film);
std::optional<std::string> fault(const Light& light);
std::optional<std::string> fault(const Medium& medium);
std::optional<std::string> fault(const Grid& grid);
std::optional<std::string> fault(const Geometry& geometry);
std::optional<std::string> fault(const EnvironmentData& environment);
std::optional<std::string> fault(const Texture& texture);
std::optional<std::string> fault(const DvrOptions& dvr);
std::optional<std::string> transform_fault(const mat4x3& transform);

// Material slots that the primitives of a geometry use.
std::uint32_t slot_count(const Geometry& geometry);

// "mesh", "voxels", …: the word for it in the scene file.
std::string_view kind_name(const Geometry& geometry);

}  // namespace spinel
