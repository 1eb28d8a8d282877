#include "spinel/formats.h"

#include <fmt/format.h>

#include "formats/file_bytes.h"
#include "image/image_io.h"
#include "scene/complete.h"
#include "scene/json_reader.h"
#include "scene/validate.h"

namespace spinel {

namespace {
constexpr std::uintmax_t max_scene_file = std::uintmax_t(1) << 30;
}

Result<Scene> load_scene(const std::filesystem::path& path, ivec2 size, const LoadOptions& options) {
    const bool is_scene_file = path.extension() == ".json";
    Result<Scene> scene = Error{""};
    if (is_scene_file) {
        if (options.heightmap || options.voxels || !options.grid.empty())
            return Error{fmt::format("{}: heights, voxels and grids are chosen inside of a scene file", path.string())};
        const Result<std::string> text = read_file_bytes(path, max_scene_file);
        if (!text) return text.error();
        scene = read_scene_json(*text, path, {load_model, read_pixels}, {options.frame, options.fps});
    } else {
        scene = load_model(path, options);
    }
    if (!scene) return scene;
    if (size.x > 0 && size.y > 0) scene->film.size = size;
    if (!is_scene_file && !options.plain) complete_model(*scene);
    else if (scene->cameras.empty()) fit_camera(*scene);
    if (Result<void> valid = validate(*scene); !valid)
        return Error{fmt::format("{}: {}", path.string(), valid.error().message)};
    if (scene->objects.empty() && std::holds_alternative<std::monostate>(scene->environment))
        return Error{fmt::format("{}: there is nothing in it to render", path.string())};
    return scene;
}

}  // namespace spinel
