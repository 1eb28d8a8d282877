#include "spinel/trace.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "geometry/mesh/mesh_structures.h"
#include "kernels/traverse.h"
#include "render/grid_stream.h"
#include "render/ray_packet.h"
#include "render/reference.h"

namespace spinel {
namespace {

using kernels::Hit;
using kernels::NONE;
using kernels::Ray;
using kernels::SceneView;
using kernels::uint;

// The two questions of a method.
struct Walk {
    Hit (*closest)(const SceneView& scene, const Ray& ray, kernels::uint mask);
    bool (*any)(const SceneView& scene, const Ray& ray, kernels::uint mask);
};

Walk walk_of(TraceMethod method) {
    if (method == TraceMethod::brute_force) return {brute_force_closest, brute_force_any};
    return {[](const SceneView& scene, const Ray& ray, kernels::uint mask) {
                return kernels::trace_closest(scene, ray, mask);
            },
            [](const SceneView& scene, const Ray& ray, kernels::uint mask) {
                return kernels::trace_any(scene, ray, mask);
            }};
}

// Distances beyond INFINITE, +∞ among them, mean "no limit".
Ray as_ray(const TraceRay& ray) {
    return {ray.origin, ray.t_min, ray.direction, std::min(ray.t_max, kernels::INFINITE)};
}

bool is_usable(const Ray& ray) {
    const glm::vec3 o = ray.origin, d = ray.direction;
    const float sum = std::abs(o.x) + std::abs(o.y) + std::abs(o.z) + std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    return std::isfinite(sum) && !kernels::is_black(d) && ray.t_min < ray.t_max;
}

std::uint32_t material_slot(const SceneView& scene, const Hit& hit) {
    const kernels::Instance& instance = scene.instances.at[hit.instance];
    switch (instance.geometry_kind) {
        case kernels::GEOMETRY_MESH: {
            const kernels::Mesh& mesh = scene.meshes.at[instance.geometry];
            return scene.triangle_infos.at[mesh.triangle_first + hit.primitive].slot;
        }
        case kernels::GEOMETRY_VOXELS: return hit.primitive - 1u;
        default: return 0;
    }
}

std::uint32_t material_of(const SceneView& scene, const Hit& hit) {
    return scene.slots.at[scene.instances.at[hit.instance].slot_first + material_slot(scene, hit)].material;
}

// The first hit whose surface has a material. t grows from hit to hit, so the loop ends.
Hit first_material(const SceneView& scene, const Walk& walk, Ray ray, kernels::uint mask) {
    for (;;) {
        const Hit hit = walk.closest(scene, ray, mask);
        if (!kernels::is_hit(hit) || material_of(scene, hit) != NONE) return hit;
        assert(hit.t > ray.t_min);
        ray.t_min = hit.t;
    }
}

bool passes_into_material(const SceneView& scene, const Walk& walk, const Ray& ray) {
    return scene.pass_through_count > 0 &&
           kernels::is_hit(first_material(scene, walk, ray, kernels::TRACE_PASS_THROUGH));
}

bool any_material(const SceneView& scene, const Walk& walk, const Ray& ray) {
    return walk.any(scene, ray, kernels::TRACE_SOLID) || passes_into_material(scene, walk, ray);
}

constexpr TraceHit miss = {std::numeric_limits<float>::infinity(), NONE, NONE, 0, 0, 0, 0, 0, 0, 0, 0, NONE};

TraceHit report(const SceneView& scene, const Hit& hit) {
    const kernels::Instance& instance = scene.instances.at[hit.instance];
    std::uint32_t primitive = hit.primitive;
    if (instance.geometry_kind == kernels::GEOMETRY_MESH) {
        primitive = scene.triangle_infos.at[scene.meshes.at[instance.geometry].triangle_first + primitive].primitive;
    }
    // Normals go by the inverse transpose. In double: the square of a small triangle's normal may leave a
    // float's range.
    const glm::dvec3 normal = glm::normalize(glm::dvec3(hit.normal) * glm::dmat3(glm::mat3(instance.world_to_object)));
    return {hit.t,           hit.instance,    primitive,  hit.uv.x,   hit.uv.y,   float(normal.x),
            float(normal.y), float(normal.z), hit.cell.x, hit.cell.y, hit.cell.z, material_of(scene, hit)};
}

}  // namespace

const std::vector<Accelerator>& accelerators() {
    static const std::vector<Accelerator> rows = [] {
        std::vector<Accelerator> list;
        for (const MeshStructure& s : mesh_structures()) list.push_back({s.name, s.doc, s.name});
        list.push_back({"grid-stream", "the uniform grid, all rays together from cell to cell, in passes", "grid",
                        TraceMethod::stream});
        list.push_back({"brute-force",
                        "the naive twin: every primitive in double precision, to test the others against",
                        mesh_structures().front().name, TraceMethod::brute_force});
        return list;
    }();
    return rows;
}

Result<const Accelerator*> find_accelerator(const std::string& name) {
    std::string available;
    for (const Accelerator& accelerator : accelerators()) {
        if (accelerator.name == name) return &accelerator;
        available += (available.empty() ? "" : ", ") + accelerator.name;
    }
    return Error{"unknown accelerator '" + name + "'; available: " + available};
}

namespace {

// How far apart along an axis rays of a packet may begin.
float packet_side(const SceneView& scene) {
    if (scene.bounded_count == 0) return 0;
    const kernels::BvhNode& all = scene.instance_nodes.at[0];
    return 0.05f * kernels::max_component(all.upper - all.lower);
}

// Whether rays, all of them usable, are of one octant, side by side and of much the same direction, so that they are
// faster together.
bool are_coherent(const Ray rays[packet_size], float side) {
    const auto octant = [](const Ray& ray) {
        const glm::vec3 d = ray.direction;
        return int(std::signbit(d.x)) + 2 * int(std::signbit(d.y)) + 4 * int(std::signbit(d.z));
    };
    const Ray& first = rays[0];
    const float length2 = glm::dot(first.direction, first.direction);
    for (int i = 0; i < packet_size; ++i) {
        const Ray& ray = rays[i];
        const glm::vec3 apart = glm::abs(ray.origin - first.origin);
        const float along = glm::dot(ray.direction, first.direction);
        if (!is_usable(ray) || octant(ray) != octant(first) || !(kernels::max_component(apart) <= side) ||
            !(along * along > 0.9f * length2 * glm::dot(ray.direction, ray.direction)))
            return false;
    }
    return true;
}

// As the walk of one ray for each of eight.
void trace_packet(const SceneView& scene, const Walk& walk, Ray rays[packet_size], bool any, TraceHit* hits) {
    constexpr unsigned all = (1u << packet_size) - 1;
    if (any) {
        const unsigned blocked = cpu_trace_any8(scene, rays, all, kernels::TRACE_SOLID);
        for (int i = 0; i < packet_size; ++i)
            if ((blocked >> i & 1) || passes_into_material(scene, walk, rays[i])) hits[i].t = 0;
        return;
    }
    Hit found[packet_size];
    cpu_trace_closest8(scene, rays, all, kernels::TRACE_ALL, found);
    for (int i = 0; i < packet_size; ++i) {
        if (!kernels::is_hit(found[i])) continue;
        if (material_of(scene, found[i]) == NONE) {
            rays[i].t_min = found[i].t;
            found[i] = first_material(scene, walk, rays[i], kernels::TRACE_ALL);
            if (!kernels::is_hit(found[i])) continue;
        }
        hits[i] = report(scene, found[i]);
    }
}

// A grid, the record of its finest cells, and no grid within it.
bool is_uniform_grid(const SceneView& scene, const kernels::Mesh& mesh) {
    return mesh.walk == kernels::MESH_WALK_GRID && scene.words.at[mesh.reference_first] == 1;
}

// The streaming walk answers batches: rays that met an interface without a material go on in the next one.
void trace_stream(const SceneView& scene, std::vector<Ray>& rays, std::vector<std::size_t>& names, bool any,
                  std::vector<StreamPass>& passes, std::vector<TraceHit>& hits) {
    std::vector<Hit> found(rays.size());
    if (any) {
        stream_trace(scene, rays, kernels::TRACE_SOLID, true, found.data(), passes);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (kernels::is_hit(found[i])) {
                hits[names[i]].t = 0;
                continue;
            }
            names[kept] = names[i];
            rays[kept++] = rays[i];
        }
        rays.resize(scene.pass_through_count > 0 ? kept : 0);
    }
    while (!rays.empty()) {
        stream_trace(scene, rays, any ? kernels::TRACE_PASS_THROUGH : kernels::TRACE_ALL, false, found.data(), passes);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!kernels::is_hit(found[i])) continue;
            if (material_of(scene, found[i]) != NONE) {
                if (any) hits[names[i]].t = 0;
                else hits[names[i]] = report(scene, found[i]);
                continue;
            }
            names[kept] = names[i];
            rays[kept] = rays[i];
            rays[kept++].t_min = found[i].t;
        }
        rays.resize(kept);
    }
}

}  // namespace

Result<std::vector<TraceHit>> trace_rays(const SceneView& scene, std::span<const TraceRay> rays,
                                         const TraceOptions& options) {
    std::vector<TraceHit> hits(rays.size(), miss);
    const ThreadLimit limit(options.threads);
    if (options.method == TraceMethod::stream) {
        for (uint i = 0; i < scene.instance_count; ++i) {
            const kernels::Instance& instance = scene.instances.at[i];
            if (instance.geometry_kind == kernels::GEOMETRY_MESH &&
                !is_uniform_grid(scene, scene.meshes.at[instance.geometry]))
                return Error{"the streaming walk needs meshes that are built into 'grid'"};
        }
        std::vector<Ray> usable;
        std::vector<std::size_t> names;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Ray ray = as_ray(rays[i]);
            if (!is_usable(ray)) continue;
            usable.push_back(ray);
            names.push_back(i);
        }
        std::vector<StreamPass> unread;
        trace_stream(scene, usable, names, options.any, options.passes ? *options.passes : unread, hits);
        return hits;
    }
    const Walk walk = walk_of(options.method);
    const float side = options.method == TraceMethod::walk ? packet_side(scene) : -1;
    parallel_for(rays.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (i + packet_size <= end) {
                Ray packet[packet_size];
                for (std::size_t k = 0; k < packet_size; ++k) packet[k] = as_ray(rays[i + k]);
                if (are_coherent(packet, side)) {
                    trace_packet(scene, walk, packet, options.any, &hits[i]);
                    i += packet_size - 1;
                    continue;
                }
            }
            const Ray ray = as_ray(rays[i]);
            if (!is_usable(ray)) continue;
            if (options.any) {
                if (any_material(scene, walk, ray)) hits[i].t = 0;
                continue;
            }
            const Hit hit = first_material(scene, walk, ray, kernels::TRACE_ALL);
            if (kernels::is_hit(hit)) hits[i] = report(scene, hit);
        }
    });
    return hits;
}

}  // namespace spinel
