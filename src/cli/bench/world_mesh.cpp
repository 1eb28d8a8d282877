#include "cli/bench/world_mesh.h"

#include <memory>
#include <variant>

#include "cli/bench/bench_measure.h"
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

namespace {

Hit as_hit(const WideHit& found) {
    Hit hit = kernels::no_hit(found.t);
    if (found.triangle != kernels::NONE) hit.instance = 0;
    hit.primitive = found.triangle;
    hit.uv = vec2(found.u, found.v);
    return hit;
}

}  // namespace

namespace {

using BuildWide = WideBvh (*)(std::span<const kernels::Triangle>, const WidePreset&);

// With the tree, on one thread.
BenchStructure built(std::string name, BuildWide build, const WorldMesh& mesh, const WidePreset& preset,
                     std::shared_ptr<const WideBvh>& tree) {
    const ThreadLimit one(1);
    BenchStructure s;
    s.name = std::move(name) + "-" + std::string(preset.name);
    s.build_ms = median_build_ms([&] {
        tree.reset();
        const double start = processor_seconds();
        tree = std::make_shared<const WideBvh>(build(mesh.triangles, preset));
        return processor_seconds() - start;
    });
    s.bytes = double(tree->units.size() * sizeof(kernels::WideUnit));
    return s;
}

BenchStructure compact_structure(const WorldMesh& mesh, const WidePreset& preset) {
    std::shared_ptr<const WideBvh> tree;
    BenchStructure s = built("wide-bvh8-compact", build_compact_mesh, mesh, preset, tree);
    const WideMesh compact{tree->units.data(), mesh.lower, mesh.upper};
    s.closest = [tree, compact](std::span<const Ray> rays, Hit* hits) {
        for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = as_hit(compact_closest(compact, rays[i]));
    };
    s.any = [tree, compact](std::span<const Ray> rays, Hit* hits) {
        for (std::size_t i = 0; i < rays.size(); ++i)
            hits[i].instance = compact_any(compact, rays[i]) ? 0 : kernels::NONE;
    };
    return s;
}

}  // namespace

std::vector<BenchStructure> wide_structures(const WorldMesh& mesh) {
    std::vector<BenchStructure> list;
    if (mesh.triangles.empty()) return list;
    for (const WidePreset& preset : wide_presets()) {
        std::shared_ptr<const WideBvh> tree;
        BenchStructure s = built("wide-bvh8", build_wide_mesh, mesh, preset, tree);
        const WideMesh wide{tree->units.data(), mesh.lower, mesh.upper};
        s.closest = [tree, wide](std::span<const Ray> rays, Hit* hits) {
            for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = as_hit(wide_closest(wide, rays[i]));
        };
        s.any = [tree, wide](std::span<const Ray> rays, Hit* hits) {
            for (std::size_t i = 0; i < rays.size(); ++i)
                hits[i].instance = wide_any(wide, rays[i]) ? 0 : kernels::NONE;
        };
        list.push_back(s);
        list.push_back(compact_structure(mesh, preset));
        if (&preset != &default_wide_preset()) continue;
        s.name += "-8";
        s.closest = [tree, wide](std::span<const Ray> rays, Hit* hits) {
            WideHit found[packet_size];
            for (std::size_t i = 0; i < rays.size(); i += packet_size) {
                wide_closest8(wide, &rays[i], 0xff, found);
                for (std::size_t k = 0; k < packet_size; ++k) hits[i + k] = as_hit(found[k]);
            }
        };
        s.any = [tree, wide](std::span<const Ray> rays, Hit* hits) {
            for (std::size_t i = 0; i < rays.size(); i += packet_size) {
                const unsigned blocked = wide_any8(wide, &rays[i], 0xff);
                for (std::size_t k = 0; k < packet_size; ++k)
                    hits[i + k].instance = blocked >> k & 1 ? 0 : kernels::NONE;
            }
        };
        list.push_back(std::move(s));
    }
    return list;
}

#ifndef SPINEL_EMBREE
std::vector<BenchStructure> embree_structures(const WorldMesh&) { return {}; }
#endif

}  // namespace spinel::cli
