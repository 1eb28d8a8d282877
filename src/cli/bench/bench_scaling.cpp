#include "cli/bench/bench_scaling.h"

#include <cmath>
#include <map>
#include <tuple>

#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel::cli {
namespace {

constexpr std::size_t coarsest = 500;  // triangles

// Vertices that share a cell of a lattice become the first of them; triangles that lose a corner are dropped. Rossignac
// and Borrel, "Multi-resolution 3D approximations for rendering complex scenes", 1993.
MeshGeometry clustered(const MeshGeometry& mesh, float cells) {
    vec3 lower = mesh.positions[0], upper = lower;
    for (const vec3& p : mesh.positions) lower = glm::min(lower, p), upper = glm::max(upper, p);
    const float cell = glm::max(glm::max(upper.x - lower.x, upper.y - lower.y), upper.z - lower.z) / cells;
    MeshGeometry coarse;
    std::map<std::tuple<int, int, int>, std::uint32_t> vertices;
    std::vector<std::uint32_t> vertex(mesh.positions.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const ivec3 c = ivec3(glm::floor((mesh.positions[i] - lower) / cell));
        const auto [it, fresh] = vertices.try_emplace({c.x, c.y, c.z}, std::uint32_t(coarse.positions.size()));
        if (fresh) coarse.positions.push_back(mesh.positions[i]);
        vertex[i] = it->second;
    }
    for (const uvec3& t : mesh.triangles) {
        const uvec3 c(vertex[t.x], vertex[t.y], vertex[t.z]);
        if (c.x != c.y && c.y != c.z && c.z != c.x) coarse.triangles.push_back(c);
    }
    return coarse;
}

// Cuts the number of triangles to about a quarter.
MeshGeometry quarter(const MeshGeometry& mesh) {
    const auto wanted = double(mesh.triangles.size()) / 4;
    double few = 2, many = 1 << 14;
    MeshGeometry best = clustered(mesh, float(few));
    for (int i = 0; i < 12; ++i) {
        const double cells = std::sqrt(few * many);
        MeshGeometry tried = clustered(mesh, float(cells));
        const auto count = double(tried.triangles.size());
        if (std::abs(count - wanted) < std::abs(double(best.triangles.size()) - wanted)) best = std::move(tried);
        (count < wanted ? few : many) = cells;
    }
    return best;
}

}  // namespace

Result<std::vector<ScalingRow>> bench_scaling(const Scene& scene, const MeshBench& options, int edge) {
    const Object* largest = nullptr;
    MeshGeometry mesh;
    for (const Object& object : scene.objects) {
        const auto* candidate = std::get_if<MeshGeometry>(&scene.geometries[std::size_t(object.geometry)].data);
        if (!candidate || candidate->triangles.size() <= mesh.triangles.size()) continue;
        largest = &object;
        mesh.positions = candidate->positions;
        mesh.triangles = candidate->triangles;
    }
    std::vector<ScalingRow> list;
    if (!largest) return list;
    Scene alone;
    alone.film.size = {edge, edge};
    alone.cameras = scene.cameras;
    alone.accelerator = scene.accelerator;
    alone.materials = {spinel::Material{"", default_material(kernels::MATERIAL_DIFFUSE)}};
    Object object;
    object.geometry = 0;
    object.materials = {0};
    object.transform = largest->transform;
    alone.objects = {object};
    MeshBench timed = options;
    timed.heat_edge = 0;
    while (mesh.triangles.size() >= coarsest) {
        alone.geometries = {Geometry{"mesh", mesh}};
        BenchRays rays;
        {
            const Result<CompiledScene> compiled = compile(alone);
            if (!compiled) return compiled.error();
            rays.primary = scene_rays(compiled->view(), edge).primary;
        }
        std::vector<BenchRow> rows;
        if (const auto maps = bench_meshes(alone, rays, timed, rows); !maps) return maps.error();
        for (const BenchRow& row : rows)
            list.push_back({row.structure, mesh.triangles.size(), row.build_ms, row.build_ms_two_threads,
                            row.mrays_per_s, row.nodes_per_ray, row.tests_per_ray});
        if (mesh.triangles.size() < 4 * coarsest) break;
        MeshGeometry coarser = quarter(mesh);
        // Triangles between the same distant vertices stay as many, however coarse the lattice is.
        if (coarser.triangles.size() > mesh.triangles.size() / 2) break;
        mesh = std::move(coarser);
    }
    return list;
}

}  // namespace spinel::cli
