#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/load_options.h"
#include "formats/npy.h"
#include "geometry/mesh/mesh_builder.h"
#include "scene/compiled_scene.h"
#include "spinel/formats.h"
#include "spinel/trace.h"

namespace spinel::cli {
namespace {

struct TraceArguments {
    std::string input;
    std::string voxels;  // instead of `input`, read with LoadOptions::voxels
    std::string rays;
    std::string output;
    LoadOptions load;
    std::string accelerator;  // empty: the scene's
    std::string triangle_test, preset;
    TraceOptions trace;
};

Result<int> run(const TraceArguments& o, const CommonOptions& common) {
    TraceOptions trace = o.trace;
    CompileOptions compiling;
    compiling.accelerator.triangle_test = o.triangle_test;
    compiling.accelerator.preset = o.preset;
    if (!o.accelerator.empty()) {
        const auto accelerator = find_accelerator(o.accelerator);
        if (!accelerator) return fail(accelerator.error(), exit_usage);
        trace.method = (*accelerator)->method;
        compiling.accelerator.structure = (*accelerator)->structure;
    }
    if (const auto known = choose_accelerator(compiling.accelerator); !known) return fail(known.error(), exit_usage);
    LoadOptions load = o.load;
    load.voxels = !o.voxels.empty();
    const std::string& input = load.voxels ? o.voxels : o.input;
    const Result<Scene> scene = load_bare(input, load);
    if (!scene) return scene.error();
    const Result<CompiledScene> compiled = compile(*scene, compiling);
    if (!compiled) return Error{fmt::format("{}: {}", input, compiled.error().message)};
    const Result<std::vector<TraceRay>> rays = read_rays_npy(o.rays);
    if (!rays) return rays.error();
    std::vector<StreamPass> passes;
    trace.passes = &passes;
    const auto start = std::chrono::steady_clock::now();
    const Result<std::vector<TraceHit>> hits = trace_rays(compiled->view(), *rays, trace);
    if (!hits) return hits.error();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (Result<void> written = write_hits_npy(o.output, *hits); !written) return written.error();
    std::size_t hit_count = 0;
    for (const TraceHit& hit : *hits) hit_count += hit.t < kernels::INFINITE;
    const std::string name = o.accelerator.empty() ? scene->accelerator.structure : o.accelerator;
    const double rate = 1e-6 * double(rays->size()) / std::max(seconds, 1e-9);
    if (common.json) {
        nlohmann::ordered_json json = {{"rays", rays->size()},
                                       {"hits", hit_count},
                                       {"seconds", seconds},
                                       {"mrays_per_s", rate},
                                       {"accelerator", name}};
        for (const StreamPass& pass : passes)
            json["passes"].push_back({{"active", pass.active},
                                      {"waiting", pass.waiting},
                                      {"inactive", pass.inactive},
                                      {"overflow", pass.overflow},
                                      {"dead", pass.dead}});
        fmt::print("{}\n", json.dump());
    } else if (!common.quiet)
        fmt::print(stderr, "{} rays, {} hits, {:.3f} s, {:.2f} Mrays/s ({})\n", rays->size(), hit_count, seconds, rate,
                   name);
    return int(exit_ok);
}

}  // namespace

std::function<int()> trace_command(CLI::App& app, const CommonOptions& common) {
    auto o = std::make_shared<TraceArguments>();
    CLI::Option* file = app.add_option("FILE", o->input, "scene file or model");
    app.add_option("--voxels", o->voxels, "instead of FILE: a .vdb whose active voxels are solid, whatever it holds")
        ->excludes(file);
    add_load_options(app, o->load);
    app.add_option("--rays", o->rays, "rays.npy: float32 [N,8] = origin, t_min, direction, t_max")->required();
    app.add_option("-o,--output", o->output, "hits.npy: structured array, one record a ray")->required();
    app.add_option("--accel", o->accelerator, "`spinel list accelerators` (default: the scene's)");
    app.add_option("--accel-preset", o->preset,
                   "how wide-bvh8 and wide-bvh8-compact are built: fast, balanced, high (default: the scene's)");
    app.add_option("--triangle-test", o->triangle_test, "`spinel list triangle-tests` (default: the scene's)");
    app.add_flag("--any", o->trace.any, "only whether anything is hit: t is 0 if so, infinity if not");
    app.add_option("-t,--threads", o->trace.threads, "worker threads (0: one a core)")->check(CLI::Range(0, 1024));
    return [o, &common] {
        if (o->input.empty() && o->voxels.empty())
            return fail({"FILE is required; see spinel trace --help"}, exit_usage);
        if (std::filesystem::path(o->output).extension() != ".npy")
            return fail({"cannot write '" + o->output + "': hits are written as .npy"}, exit_usage);
        const Result<int> result = run(*o, common);
        return result ? *result : fail(result.error());
    };
}

}  // namespace spinel::cli
