#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <memory>

#include "cli/bench/bench_rays.h"
#include "cli/bench/bench_report.h"
#include "cli/bench/bench_scaling.h"
#include "cli/bench/bench_structure.h"
#include "cli/bench/volume_bench.h"
#include "cli/bench/world_mesh.h"
#include "cli/commands.h"
#include "scene/compiled_scene.h"
#include "scene/complete.h"
#include "spinel/formats.h"

namespace spinel::cli {
namespace {

using kernels::Ray;

struct BenchArguments {
    std::string input;
    std::string voxels;  // instead of `input`, read with LoadOptions::voxels
    std::vector<float> from, at;
    double fov = 60;
    int size = 512;
    int repeats = 5;
    MeshBench meshes;
    bool scaling = false;
    std::string html;
};

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

void measure(const std::string& subject, const std::vector<BenchStructure>& structures, const std::string& kind,
             const std::vector<Ray>& rays, bool any, int repeats, std::vector<BenchRow>& rows) {
    const Measurement measurement(subject, kind, rays, any, repeats, structures.front());
    for (const BenchStructure& s : structures) measurement.add(s, rows);
}

std::size_t triangles_of(const CompiledScene& scene) {
    std::size_t sum = 0;
    for (const kernels::Mesh& mesh : scene.meshes) sum += mesh.triangle_count;
    return sum;
}

Result<int> run(const BenchArguments& o, const CommonOptions& common) {
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
    if (!is_scene && scene->lights.empty()) {  // something for shadow rays to look for
        DirectionalLight sun;
        sun.direction = {-1, -2, -0.7f};
        scene->lights.push_back({"sun", sun});
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

    BenchReport report;
    report.input = name;
    report.repeats = o.repeats;
    report.triangles = triangles_of(*compiled);
    std::vector<BenchRow>& rows = report.rows;
    {
        const BenchRays rays = scene_rays(compiled->view(), o.size);
        std::vector<BenchStructure> structures = scene_structures(*compiled, scene->accelerator.structure, build_ms);
        const WorldMesh meshes = world_mesh(*scene);
        for (BenchStructure& s : wide_structures(meshes)) structures.push_back(std::move(s));
        for (BenchStructure& s : embree_structures(meshes)) structures.push_back(std::move(s));
        measure("scene", structures, "primary", rays.primary, false, o.repeats, rows);
        measure("scene", structures, "diffuse", rays.diffuse, false, o.repeats, rows);
        measure("scene", structures, "shadow", rays.shadow, true, o.repeats, rows);
        if (!compiled->meshes.empty()) {
            MeshBench meshes = o.meshes;
            meshes.repeats = o.repeats;
            if (!o.html.empty()) meshes.heat_edge = std::min(o.size, 256);
            Result<std::vector<HeatMap>> maps = bench_meshes(*scene, rays, meshes, rows);
            if (!maps) return maps.error();
            report.maps = std::move(*maps);
            if (o.scaling) {
                Result<std::vector<ScalingRow>> scaling = bench_scaling(*scene, meshes, o.size);
                if (!scaling) return scaling.error();
                report.scaling = std::move(*scaling);
            }
        }
    }
    kernels::uint instance = 0;
    if (const VoxelGeometry* voxels = only_voxels(*scene, *compiled, instance)) {
        const BenchRays rays = voxel_rays(compiled->view(), instance, o.size);
        const std::vector<BenchStructure> structures = voxel_structures(*compiled, instance, *voxels->tree);
        measure("voxels", structures, "primary", rays.primary, false, o.repeats, rows);
        measure("voxels", structures, "diffuse", rays.diffuse, false, o.repeats, rows);
    }
    report.look_ups = volume_rows(*scene, *compiled, o.repeats);
    if (!o.html.empty())
        if (const Result<void> written = write_html(report, o.html); !written) return written.error();
    fmt::print("{}", common.json ? rows_json(report) + "\n" : table_text(report));
    return int(exit_ok);
}

}  // namespace

std::function<int()> bench_command(CLI::App& app, const CommonOptions& common) {
    auto o = std::make_shared<BenchArguments>();
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
    app.add_option("--structures", o->meshes.structures,
                   "rows `meshes`: only these of `spinel list accelerators`, by commas")
        ->delimiter(',');
    app.add_option("--triangle-test", o->meshes.triangle_test, "`spinel list triangle-tests` (default: the scene's)");
    app.add_flag("--scaling", o->scaling, "also how structures grow, on coarser versions of the largest mesh");
    app.add_option("--html", o->html, "a page with charts and heat maps, one file");
    return [o, &common] {
        for (const std::string& name : o->meshes.structures)
            if (const auto found = find_mesh_structure(name); !found) return fail(found.error(), exit_usage);
        if (const auto found = find_triangle_test(o->meshes.triangle_test); !found)
            return fail(found.error(), exit_usage);
        if (o->input.empty() && o->voxels.empty())
            return fail({"FILE is required; see spinel bench --help"}, exit_usage);
        if (o->from.size() != o->at.size()) return fail({"--from needs --at"}, exit_usage);
        const Result<int> result = run(*o, common);
        return result ? *result : fail(result.error());
    };
}

}  // namespace spinel::cli
