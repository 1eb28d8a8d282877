#include "cli/load_options.h"

#include <CLI/CLI.hpp>

namespace spinel::cli {

void add_load_options(CLI::App& app, LoadOptions& options) {
    app.add_option("--frame", options.frame, "of an animated model or scene, from 0 (default: the first)")
        ->check(CLI::Range(0, 1 << 20));
    app.add_option("--fps", options.fps, "frames a second of a scene's animation (default: the scene's, else 30)")
        ->check(finite_number())
        ->check(CLI::Range(1e-6, 1e6));
    app.add_option("--heightmap", options.heightmap,
                   "picture or .hgt as terrain: so many voxels from black to white, or from the lowest to the highest")
        ->check(finite_number())
        ->check(CLI::Range(1.0, 65536.0));
    app.add_option("--grid", options.grid, "of a file of volumes, the one of this name (default: all)");
}

Result<Scene> load_bare(const std::string& file, const LoadOptions& options) {
    const bool is_scene = std::filesystem::path(file).extension() == ".json";
    return is_scene ? load_scene(file, {0, 0}, options) : load_model(file, options);
}

}  // namespace spinel::cli
