#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <memory>

#include "cli/commands.h"
#include "cli/load_options.h"
#include "cli/output_format.h"
#include "core/parallel.h"
#include "scene/convert.h"
#include "spinel/formats.h"

namespace spinel::cli {
namespace {

struct ConvertArguments {
    std::string input;
    std::string output;
    LoadOptions load;
    VoxeliseOptions voxelise;
    bool surface = false;
    int threads = 0;
};

bool is_made_of(const Scene& scene, Representation wanted) {
    return std::all_of(scene.objects.begin(), scene.objects.end(), [&](const Object& object) {
        const auto& data = scene.geometries[std::size_t(object.geometry)].data;
        return wanted == Representation::meshes ? std::holds_alternative<MeshGeometry>(data)
                                                : std::holds_alternative<VoxelGeometry>(data);
    });
}

// A volume alone has samples of its own, so many along its longest edge.
int natural_resolution(const Scene& scene) {
    if (scene.objects.size() != 1) return 0;
    const auto* volume = std::get_if<VolumeGeometry>(&scene.geometries[std::size_t(scene.objects[0].geometry)].data);
    if (!volume) return 0;
    const ivec3 size = scene.grids[std::size_t(volume->grid)].samples->size();
    return std::max({size.x, size.y, size.z});
}

Result<Scene> converted(Scene scene, Representation wanted, const ConvertArguments& o) {
    if (wanted == Representation::any) return scene;
    if (is_made_of(scene, wanted) && o.voxelise.resolution == 0) return scene;
    if (wanted == Representation::meshes) return mesh_scene(scene);
    VoxeliseOptions options = o.voxelise;
    if (options.resolution == 0) options.resolution = natural_resolution(scene);
    if (options.resolution == 0) return Error{"--voxels N is needed: cells along the longest edge"};
    return voxelise_scene(scene, options);
}

Result<int> run(const ConvertArguments& o, const CommonOptions& common) {
    const Result<const Format*> format = output_format(o.output);
    if (!format) return fail(format.error(), exit_usage);
    const ThreadLimit limit(o.threads);
    const auto start = std::chrono::steady_clock::now();
    Result<Scene> scene = load_bare(o.input, o.load);
    if (!scene) return scene.error();
    const Result<Scene> result = converted(std::move(*scene), (*format)->saves, o);
    if (!result) return Error{fmt::format("{}: {}", o.input, result.error().message)};
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const Result<Notes> saved = save_model(*result, o.output);
    if (!saved) return saved.error();
    report_saved(*result, *saved, o.output, seconds, common);
    return int(exit_ok);
}

}  // namespace

std::function<int()> convert_command(CLI::App& app, const CommonOptions& common) {
    auto o = std::make_shared<ConvertArguments>();
    app.add_option("INPUT", o->input, "scene file or model")->required();
    app.add_option("-o,--output", o->output, "what its extension says: voxels or meshes")->required();
    add_load_options(app, o->load);
    app.add_option("--voxels", o->voxelise.resolution,
                   "cells along the longest edge (default: of a volume alone, as many as it has samples)")
        ->check(CLI::Range(1, VoxelTree::max_edge));
    CLI::Option* solid = app.add_flag("--solid", o->voxelise.solid, "fill what meshes enclose");
    app.add_flag("--surface", o->surface, "only the cells that a mesh's triangles touch (the default)")
        ->excludes(solid);
    app.add_option("--threshold", o->voxelise.threshold, "what is at least so dense in a volume is solid")
        ->check(finite_number())
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    app.add_option("--colors", o->voxelise.max_colors, "entries of the palette, 255 being what most formats hold")
        ->check(CLI::Range(1, 65535))
        ->capture_default_str();
    app.add_option("-t,--threads", o->threads, "worker threads (0: one a core)")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    return [o, &common] {
        const Result<int> result = run(*o, common);
        return result ? *result : fail(result.error());
    };
}

}  // namespace spinel::cli
