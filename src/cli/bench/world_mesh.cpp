#include "cli/bench/world_mesh.h"

#include <chrono>
#include <memory>
#include <variant>

#include "core/parallel.h"
#include "devices/cpu/mesh_walk.h"
#include "geometry/mesh/wide_mesh.h"

namespace spinel::cli {

using kernels::Hit;
using kernels::Ray;

WorldMesh world_mesh(const Scene& scene) {
    WorldMesh out;
    for (const Object& object : scene.objects) {
        const auto* mesh = std::get_if<MeshGeometry>(&scene.geometries[std::size_t(object.geometry)].data);
        if (!mesh) return {};
        const auto first = std::uint32_t(out.positions.size());
        for (const vec3& p : mesh->positions) {
            out.positions.push_back(object.transform * vec4(p, 1));
            out.lower = glm::min(out.lower, out.positions.back());
            out.upper = glm::max(out.upper, out.positions.back());
        }
        for (const uvec3& t : mesh->triangles) {
            const uvec3 index = t + first;
            const kernels::Triangle triangle{out.positions[index.x], out.positions[index.y], out.positions[index.z]};
            const vec3 normal = glm::cross(triangle.b - triangle.a, triangle.c - triangle.a);
            if (!(glm::dot(normal, normal) > 0)) continue;  // as geometry/mesh/mesh_builder.cpp
            out.indices.push_back(index);
            out.triangles.push_back(triangle);
        }
    }
    return out;
}

std::vector<BenchStructure> wide_structures(const WorldMesh& mesh) {
    std::vector<BenchStructure> list;
    if (mesh.triangles.empty()) return list;
    for (const WidePreset& preset : wide_presets()) {
        const ThreadLimit one(1);
        const auto start = std::chrono::steady_clock::now();
        const auto tree = std::make_shared<const WideBvh>(build_wide_mesh(mesh.triangles, preset));
        BenchStructure s;
        s.name = "wide-bvh8-" + std::string(preset.name);
        s.build_ms = 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        s.bytes = double(tree->units.size() * sizeof(kernels::WideUnit));
        const WideMesh wide{tree->units.data(), mesh.lower, mesh.upper};
        s.closest = [tree, wide](std::span<const Ray> rays, Hit* hits) {
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const WideHit found = wide_closest(wide, rays[i]);
                hits[i] = kernels::no_hit(found.t);
                if (found.triangle != kernels::NONE) hits[i].instance = 0;
                hits[i].primitive = found.triangle;
                hits[i].uv = vec2(found.u, found.v);
            }
        };
        s.any = [tree, wide](std::span<const Ray> rays, Hit* hits) {
            for (std::size_t i = 0; i < rays.size(); ++i)
                hits[i].instance = wide_any(wide, rays[i]) ? 0 : kernels::NONE;
        };
        list.push_back(std::move(s));
    }
    return list;
}

#ifndef SPINEL_EMBREE
std::vector<BenchStructure> embree_structures(const WorldMesh&) { return {}; }
#endif

}  // namespace spinel::cli
