#include "cli/bench/bench_meshes.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include "core/parallel.h"
#include "geometry/mesh/mesh_builder.h"
#include "kernels/camera.h"
#include "kernels/counted.h"

namespace spinel::cli {
namespace {

using kernels::Hit;
using kernels::Ray;

// Each mesh with a structure of its own, as only the wide ones can be joined.
Result<CompiledScene> compile_apart(const Scene& scene, const AcceleratorSettings& accelerator) {
    return compile(scene, {.accelerator = accelerator, .join_meshes = false});
}

// What building all meshes of the scene takes on some threads, the structures alone.
Result<double> build_milliseconds(const Scene& scene, const AcceleratorSettings& accelerator, int threads) {
    const ThreadLimit limit(threads);
    const Result<CompiledScene> built = compile_apart(scene, accelerator);
    if (!built) return built.error();
    double sum = 0;
    for (const MeshStatistics& mesh : built->mesh_statistics) sum += mesh.build_ms;
    return sum;
}

// What moving them takes, trees as they are: the structures alone, as for building.
Result<double> refit_milliseconds(const Scene& scene, const MeshStructure& row,
                                  const AcceleratorSettings& accelerator) {
    double sum = 0;
    if (!row.refit) return sum;
    const ThreadLimit limit(1);
    for (const Geometry& geometry : scene.geometries) {
        const auto* mesh = std::get_if<MeshGeometry>(&geometry.data);
        if (!mesh) continue;
        Result<MeshData> data = build_mesh(*mesh, accelerator);
        if (!data) return data.error();
        if (data->triangles.empty()) continue;
        const auto start = std::chrono::steady_clock::now();
        row.refit(data->triangles, data->structure);
        sum += 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    return sum;
}

BenchStructure structure_of(const MeshStructure& row, const std::shared_ptr<const CompiledScene>& scene) {
    BenchStructure s;
    s.name = row.name;
    double weighted = 0, triangles = 0;
    for (std::size_t i = 0; i < scene->meshes.size(); ++i) {
        const MeshStatistics& statistics = scene->mesh_statistics[i];
        s.bytes += double(statistics.bytes);
        s.depth = std::max(s.depth, statistics.depth);
        weighted += statistics.sah_cost * scene->meshes[i].triangle_count;
        triangles += scene->meshes[i].triangle_count;
    }
    s.sah_cost = triangles > 0 ? weighted / triangles : 0;
    s.closest = [scene, view = scene->view()](std::span<const Ray> rays, Hit* hits) {
        for (std::size_t i = 0; i < rays.size(); ++i)
            hits[i] = kernels::trace_closest(view, rays[i], kernels::TRACE_ALL);
    };
    s.any = [scene, view = scene->view()](std::span<const Ray> rays, Hit* hits) {
        for (std::size_t i = 0; i < rays.size(); ++i)
            hits[i].instance = kernels::trace_any(view, rays[i], kernels::TRACE_ALL) ? 0 : kernels::NONE;
    };
    s.triangle = [scene](const Hit& hit) {
        const kernels::Instance& shown = scene->instances[hit.instance];
        if (shown.geometry_kind != kernels::GEOMETRY_MESH) return hit.primitive;
        return scene->triangle_infos[scene->meshes[shown.geometry].triangle_first + hit.primitive].primitive;
    };
    s.count = [scene, view = scene->view()](const Ray& ray, bool any) {
        kernels::WalkCount count = kernels::no_count();
        if (any) kernels::trace_any_counted(view, ray, kernels::TRACE_ALL, count);
        else kernels::trace_closest_counted(view, ray, kernels::TRACE_ALL, count);
        return count;
    };
    return s;
}

HeatMap heat_map(const MeshStructure& row, const CompiledScene& scene, int edge) {
    HeatMap map{row.name, edge, std::vector<std::uint32_t>(std::size_t(edge) * std::size_t(edge))};
    const kernels::SceneView view = scene.view();
    kernels::Camera camera = view.camera;
    camera.resolution = {edge, edge};
    parallel_for(map.counts.size(), std::size_t(edge), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const kernels::uvec2 pixel(i % std::size_t(edge), i / std::size_t(edge));
            kernels::WalkCount count = kernels::no_count();
            kernels::trace_closest_counted(view, kernels::camera_ray(camera, pixel, vec2(0.5f), vec2(0.5f)),
                                           kernels::TRACE_ALL, count);
            map.counts[i] = count.steps + count.boxes + count.tests;
        }
    });
    return map;
}

}  // namespace

Result<std::vector<HeatMap>> bench_meshes(const Scene& scene, const BenchRays& rays, const MeshBench& options,
                                          std::vector<BenchRow>& rows) {
    std::vector<HeatMap> maps;
    std::optional<Measurement> primary, diffuse, shadow;
    for (const MeshStructure& row : mesh_structures()) {
        const auto& wanted = options.structures;
        if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), row.name) == wanted.end()) continue;
        const AcceleratorSettings accelerator{
            row.name, options.triangle_test.empty() ? scene.accelerator.triangle_test : options.triangle_test};
        Result<CompiledScene> compiled = compile_apart(scene, accelerator);
        if (!compiled) return compiled.error();
        const auto shared = std::make_shared<const CompiledScene>(std::move(*compiled));
        BenchStructure s = structure_of(row, shared);
        for (const auto& [threads, ms] : {std::pair(1, &s.build_ms), std::pair(2, &s.build_ms_two_threads)}) {
            const Result<double> measured = build_milliseconds(scene, accelerator, threads);
            if (!measured) return measured.error();
            *ms = *measured;
        }
        const Result<double> refit = refit_milliseconds(scene, row, accelerator);
        if (!refit) return refit.error();
        s.refit_ms = *refit;
        if (!primary) {
            primary.emplace("meshes", "primary", rays.primary, false, options.repeats, s);
            diffuse.emplace("meshes", "diffuse", rays.diffuse, false, options.repeats, s);
            shadow.emplace("meshes", "shadow", rays.shadow, true, options.repeats, s);
        }
        primary->add(s, rows);
        diffuse->add(s, rows);
        shadow->add(s, rows);
        if (options.heat_edge > 0) maps.push_back(heat_map(row, *shared, options.heat_edge));
    }
    return maps;
}

}  // namespace spinel::cli
