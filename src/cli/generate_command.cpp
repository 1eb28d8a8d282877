#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdio>
#include <memory>

#include "cli/commands.h"
#include "cli/output_format.h"
#include "core/parallel.h"
#include "scene/worlds/worlds.h"

namespace spinel::cli {
namespace {

struct GenerateArguments {
    std::string world;
    std::string output;
    std::string size;
    std::uint32_t seed = 0;
    int threads = 0;
};

Result<ivec3> parse_world_size(const std::string& text) {
    if (text.empty()) return ivec3(0);
    ivec3 size(0);
    int used = 0;
    if (std::sscanf(text.c_str(), "%9dx%9dx%9d%n", &size.x, &size.y, &size.z, &used) == 3 &&
        std::size_t(used) == text.size() && glm::all(glm::greaterThan(size, ivec3(0))) &&
        glm::all(glm::lessThanEqual(size, ivec3(VoxelTree::max_edge))))
        return size;
    return Error{fmt::format("--size '{}': expected WIDTHxHEIGHTxDEPTH in voxels, each from 1 to {}", text,
                             VoxelTree::max_edge)};
}

int run(const GenerateArguments& o, const CommonOptions& common) {
    const World* world = find_world(o.world);
    if (!world) {
        std::string names;
        for (const World& row : worlds()) names += fmt::format("{}{}", names.empty() ? "" : ", ", row.name);
        return fail({fmt::format("unknown world '{}'; available: {}", o.world, names)}, exit_usage);
    }
    const Result<ivec3> size = parse_world_size(o.size);
    if (!size) return fail(size.error(), exit_usage);
    const Result<const Format*> format = output_format(o.output, true);
    if (!format) return fail(format.error(), exit_usage);
    const ThreadLimit limit(o.threads);
    const auto start = std::chrono::steady_clock::now();
    const Result<Scene> scene = make_world(*world, *size, o.seed);
    if (!scene) return fail(scene.error(), exit_usage);  // a size or seed that the world does not have
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const Result<Notes> saved = save_model(*scene, o.output);
    if (!saved) return fail(saved.error());
    report_saved(*scene, *saved, o.output, seconds, common);
    return exit_ok;
}

}  // namespace

std::function<int()> generate_command(CLI::App& app, const CommonOptions& common) {
    auto o = std::make_shared<GenerateArguments>();
    app.add_option("WORLD", o->world, "`spinel list worlds`")->required();
    app.add_option("-o,--output", o->output, "a file of voxels")->required();
    app.add_option("--size", o->size, "WIDTHxHEIGHTxDEPTH in voxels (default: the world's own)");
    app.add_option("--seed", o->seed, "another seed, another world")->capture_default_str();
    app.add_option("-t,--threads", o->threads, "worker threads (0: one a core)")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    return [o, &common] { return run(*o, common); };
}

}  // namespace spinel::cli
