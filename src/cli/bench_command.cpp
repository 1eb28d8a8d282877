#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/bench/bench_rays.h"
#include "cli/bench/bench_structure.h"
#include "cli/bench/volume_bench.h"
#include "cli/bench/world_mesh.h"
#include "cli/commands.h"
#include "scene/compiled_scene.h"
#include "scene/complete.h"
#include "spinel/formats.h"

namespace spinel::cli {
namespace {

using kernels::Hit;
using kernels::Ray;

struct Options {
    std::string input;
    std::string voxels;  // instead of `input`, read with LoadOptions::voxels
    std::vector<float> from, at;
    double fov = 60;
    int size = 512;
    int repeats = 5;
};

struct Row {
    std::string subject, structure, rays;
    double build_ms, bytes, mrays_per_s;
    double differing;  // share of rays that see something else than the first structure does
};

double cpu_seconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

using Trace = std::function<void(std::span<const Ray>, Hit*)>;

// The median of several runs, one thread. Hits are written over those of the batch before, as a renderer does: what is
// measured is the walk, not the memory.
double rays_per_second(const Trace& trace, std::span<const Ray> rays, int repeats) {
    constexpr std::size_t batch = 1024;
    std::vector<Hit> hits(batch);
    std::vector<double> seconds;
    for (int i = 0; i < repeats; ++i) {
        const double start = cpu_seconds();
        for (std::size_t k = 0; k < rays.size(); k += batch)
            trace(rays.subspan(k, std::min(batch, rays.size() - k)), hits.data());
        seconds.push_back(cpu_seconds() - start);
    }
    std::nth_element(seconds.begin(), seconds.begin() + repeats / 2, seconds.end());
    return double(rays.size()) / seconds[std::size_t(repeats) / 2];
}

std::vector<Ray> every(std::size_t stride, const std::vector<Ray>& rays) {
    std::vector<Ray> some;
    for (std::size_t i = 0; i + 8 <= rays.size(); i += 8 * stride)
        some.insert(some.end(), rays.begin() + std::ptrdiff_t(i), rays.begin() + std::ptrdiff_t(i) + 8);
    return some;
}

bool same(const Hit& a, const Hit& b, bool any) {
    if (kernels::is_hit(a) != kernels::is_hit(b)) return false;
    return any || !kernels::is_hit(a) || (a.cell == b.cell && std::abs(a.t - b.t) <= 1e-4f * std::abs(a.t));
}

void measure(const std::string& subject, const std::vector<BenchStructure>& structures, const std::string& kind,
             const std::vector<Ray>& rays, bool any, int repeats, std::vector<Row>& rows) {
    if (rays.size() < 8) return;
    const auto trace_of = [any](const BenchStructure& s) { return any && s.any ? s.any : s.closest; };
    std::vector<Hit> expected(rays.size());
    trace_of(structures.front())(rays, expected.data());
    for (const BenchStructure& s : structures) {
        const std::vector<Ray> some = every(s.stride, rays);
        Row row{subject, s.name, kind, s.build_ms, s.bytes, 0, 0};
        row.mrays_per_s = 1e-6 * rays_per_second(trace_of(s), some, repeats);
        std::vector<Hit> found(some.size());
        trace_of(s)(some, found.data());
        std::size_t differing = 0;
        for (std::size_t i = 0; i < found.size(); ++i)
            differing += !same(expected[i / 8 * 8 * s.stride + i % 8], found[i], any);
        row.differing = double(differing) / double(found.size());
        rows.push_back(row);
    }
}

// The set of voxels that the scene shows, if it is one alone; and its first instance.
const VoxelGeometry* only_voxels(const Scene& scene, const CompiledScene& compiled, kernels::uint& instance) {
    if (compiled.voxel_grids.size() != 1 || compiled.voxel_grids[0].walk != kernels::VOXEL_WALK_TREE) return nullptr;
    const auto shown =
        std::find_if(compiled.instances.begin(), compiled.instances.end(),
                     [](const kernels::Instance& i) { return i.geometry_kind == kernels::GEOMETRY_VOXELS; });
    instance = kernels::uint(shown - compiled.instances.begin());
    const int geometry = scene.objects[instance].geometry;  // an instance for each object
    const auto* voxels = std::get_if<VoxelGeometry>(&scene.geometries[std::size_t(geometry)].data);
    return voxels && voxels->level_of_detail == 0 ? voxels : nullptr;
}

// The first volume of one channel that the scene shows, by a medium's density; none: no rows.
std::vector<LookUpRow> volume_rows(const Scene& scene, const CompiledScene& compiled, int repeats) {
    for (const Object& object : scene.objects) {
        if (object.interior < 0) continue;
        const int grid = scene.media[std::size_t(object.interior)].grid;
        // Media are compiled in the order of the objects, so the first volume shown is the first grid compiled.
        if (grid >= 0 && !compiled.grids.empty())
            return measure_look_ups(compiled, compiled.grids[0], scene.grids[std::size_t(grid)], repeats);
    }
    return {};
}

void print(const Options& o, const CommonOptions& common, const std::vector<Row>& rows,
           const std::vector<LookUpRow>& look_ups) {
    if (common.json) {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const Row& row : rows)
            list.push_back({{"subject", row.subject},
                            {"structure", row.structure},
                            {"rays", row.rays},
                            {"mrays_per_s", row.mrays_per_s},
                            {"build_ms", row.build_ms},
                            {"bytes", row.bytes},
                            {"differing", row.differing}});
        nlohmann::ordered_json json = {{"rows", list}};
        for (const LookUpRow& row : look_ups)
            json["look_ups"].push_back({{"structure", row.structure},
                                        {"places", row.places},
                                        {"mlookups_per_s", row.mlookups_per_s},
                                        {"bytes", row.bytes},
                                        {"bytes_per_voxel", row.bytes_per_voxel},
                                        {"difference", row.difference}});
        fmt::print("{}\n", json_text(json, 2));
        return;
    }
    fmt::print("{}: one thread, median of {}, processor time\n", o.voxels.empty() ? o.input : o.voxels, o.repeats);
    fmt::print("{:<8} {:<20} {:<8} {:>9} {:>11} {:>13} {:>9}\n", "subject", "structure", "rays", "Mrays/s", "build ms",
               "bytes", "differ");
    for (const Row& row : rows)
        fmt::print("{:<8} {:<20} {:<8} {:>9.3f} {:>11.2f} {:>13.0f} {:>8.4f}%\n", row.subject, row.structure, row.rays,
                   row.mrays_per_s, row.build_ms, row.bytes, 100 * row.differing);
    if (look_ups.empty()) return;
    fmt::print("{:<8} {:<20} {:<8} {:>9} {:>13} {:>13} {:>11}\n", "subject", "structure", "places", "M/s", "bytes",
               "bytes/voxel", "difference");
    for (const LookUpRow& row : look_ups)
        fmt::print("{:<8} {:<20} {:<8} {:>9.3f} {:>13.0f} {:>13.3f} {:>11.2g}\n", "volume", row.structure, row.places,
                   row.mlookups_per_s, row.bytes, row.bytes_per_voxel, row.difference);
}

Result<int> run(const Options& o, const CommonOptions& common) {
    const std::string& name = o.voxels.empty() ? o.input : o.voxels;
    LoadOptions as_voxels;
    as_voxels.voxels = true;
    const bool is_scene = std::filesystem::path(o.input).extension() == ".json";
    Result<Scene> scene = !o.voxels.empty() ? load_model(o.voxels, as_voxels)
                          : is_scene        ? load_scene(o.input)
                                            : load_model(o.input);
    if (!scene) return scene.error();
    if (!o.from.empty()) {
        Camera camera;
        camera.from = {o.from[0], o.from[1], o.from[2]};
        camera.at = {o.at[0], o.at[1], o.at[2]};
        camera.fov = float(o.fov);
        scene->cameras = {camera};
    }
    scene->film.size = {o.size, o.size};
    if (scene->cameras.empty()) fit_camera(*scene);
    if (scene->cameras.empty())
        return Error{fmt::format("{}: there is nothing that a camera could be fitted to", name)};
    scene->cameras.resize(1);
    const auto start = std::chrono::steady_clock::now();
    const Result<CompiledScene> compiled = compile(*scene);
    if (!compiled) return Error{fmt::format("{}: {}", name, compiled.error().message)};
    const double build_ms = 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

    std::vector<Row> rows;
    {
        const BenchRays rays = scene_rays(compiled->view(), o.size);
        std::vector<BenchStructure> structures = scene_structures(*compiled, scene->accelerator.structure, build_ms);
        const WorldMesh meshes = world_mesh(*scene);
        for (BenchStructure& s : wide_structures(meshes)) structures.push_back(std::move(s));
        for (BenchStructure& s : embree_structures(meshes)) structures.push_back(std::move(s));
        measure("scene", structures, "primary", rays.primary, false, o.repeats, rows);
        measure("scene", structures, "diffuse", rays.diffuse, false, o.repeats, rows);
        measure("scene", structures, "shadow", rays.shadow, true, o.repeats, rows);
    }
    kernels::uint instance = 0;
    if (const VoxelGeometry* voxels = only_voxels(*scene, *compiled, instance)) {
        const BenchRays rays = voxel_rays(compiled->view(), instance, o.size);
        const std::vector<BenchStructure> structures = voxel_structures(*compiled, instance, *voxels->tree);
        measure("voxels", structures, "primary", rays.primary, false, o.repeats, rows);
        measure("voxels", structures, "diffuse", rays.diffuse, false, o.repeats, rows);
    }
    print(o, common, rows, volume_rows(*scene, *compiled, o.repeats));
    return int(exit_ok);
}

}  // namespace

std::function<int()> bench_command(CLI::App& app, const CommonOptions& common) {
    auto o = std::make_shared<Options>();
    CLI::Option* file = app.add_option("FILE", o->input, "scene file or model");
    app.add_option("--voxels", o->voxels, "instead of FILE: a .vdb whose active voxels are solid, whatever it holds")
        ->excludes(file);
    CLI::Option* from =
        app.add_option("--from", o->from, "where the camera stands, x,y,z; else the scene's own or a fitted one")
            ->delimiter(',')
            ->expected(3)
            ->check(finite_number());
    app.add_option("--at", o->at, "what it looks at, x,y,z")
        ->delimiter(',')
        ->expected(3)
        ->check(finite_number())
        ->needs(from);
    app.add_option("--fov", o->fov, "its vertical angle of view in degrees")
        ->check(CLI::Range(1.0, 170.0))
        ->needs(from);
    app.add_option("--size", o->size, "edge of the square of pixels")
        ->check(CLI::Range(8, 8192))
        ->capture_default_str();
    app.add_option("--repeats", o->repeats, "runs, of which the median counts")
        ->check(CLI::Range(1, 99))
        ->capture_default_str();
    return [o, &common] {
        if (o->input.empty() && o->voxels.empty())
            return fail({"FILE is required; see spinel bench --help"}, exit_usage);
        if (o->from.size() != o->at.size()) return fail({"--from needs --at"}, exit_usage);
        const Result<int> result = run(*o, common);
        return result ? *result : fail(result.error());
    };
}

}  // namespace spinel::cli
