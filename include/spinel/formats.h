#pragma once
// Files of 3D things. load_scene() gives what can be rendered. load_model() gives what a model file holds, a scene
// fragment: geometries, materials, textures, grids and media, with objects that place them; cameras and lights only
// where the file has some. A fragment is a valid part of a scene: the caller adds what is missing, or merges it into a
// scene of its own.

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

// What a file is asked for besides being read. An option that its format does not know is an error.
struct LoadOptions {
    std::optional<int> frame;        // of an animation, from 0; none: the first
    double fps = 0;                  // frames a second of a scene file's animation; 0: its own
    std::optional<float> heightmap;  // pictures and heights are terrain: its highest column has so many voxels,
                                     // the lowest one
    bool voxels = false;             // active voxels of a volume are solid ones
    bool plain = false;              // load_scene: a model gets a camera, but neither light nor ground
    std::string grid = {};           // of a volume file, the one of this name; empty: all
};

// When a scene file with an animation is looked at.
struct Moment {
    std::optional<int> frame;  // none: 0
    double fps = 0;            // frames a second; 0: the file's, else 30
};

// What a file could not say of a scene that was saved, a sentence each.
using Notes = std::vector<std::string>;

// What a format can hold of what a scene may be made of.
enum class Representation { any, meshes, voxels };

struct Format {
    std::string_view name;                     // "vox"
    std::vector<std::string_view> extensions;  // lower case, with the dot
    std::string_view description;              // one line for `spinel list formats`
    Result<Scene> (*load)(const std::filesystem::path& path, const LoadOptions& options);
    Result<Notes> (*save)(const Scene& scene, const std::filesystem::path& path);  // null: cannot be written
    Representation saves = Representation::any;
    bool animated = false;  // knows LoadOptions::frame
    bool heights = false;   // knows LoadOptions::heightmap
    bool volumes = false;   // knows LoadOptions::voxels
    bool grids = false;     // knows LoadOptions::grid
};

// One row for each format. To add one, write its load function and add its row in formats.cpp.
std::span<const Format> formats();

// The format whose extension the file has (upper or lower case; the longest counts: ".hgt.gz"), or null.
const Format* format_of(const std::filesystem::path& path);

// A scene file (.json), or a model of any registered format: what can be rendered. A model gets a camera, sun, sky and
// ground of its own; a scene file gets a camera if it has none, and nothing else. `size` (0, 0: the scene's film)
// decides what a fitted camera must frame. Of the options a scene file knows `frame` and `fps`, of its animation.
Result<Scene> load_scene(const std::filesystem::path& path, ivec2 size = {0, 0}, const LoadOptions& options = {});

Result<Scene> load_model(const std::filesystem::path& path, const LoadOptions& options = {});
Result<Notes> save_model(const Scene& scene, const std::filesystem::path& path);

}  // namespace spinel
