#include "spinel/trace.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>

#include "core/parallel.h"
#include "geometry/mesh/mesh_structures.h"
#include "render/grid_stream.h"
#include "render/ray_batch.h"
#include "render/reference.h"

namespace spinel {
namespace {

using kernels::Hit;
using kernels::NONE;
using kernels::Ray;
using kernels::SceneView;
using kernels::uint;

// The two questions of a method: nearest hits or, for `any`, whether there are some.
using BatchWalk = std::function<void(std::span<const Ray> rays, kernels::uint mask, bool any, Hit* hits)>;

void brute_force(const SceneView& scene, std::span<const Ray> rays, uint mask, bool any, Hit* hits) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (!any) {
            hits[i] = brute_force_closest(scene, rays[i], mask);
            continue;
        }
        hits[i] = kernels::no_hit(rays[i].t_max);
        if (brute_force_any(scene, rays[i], mask)) hits[i].instance = 0;
    }
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

constexpr std::size_t batch_size = 4096;

// A grid, and none within it.
bool is_uniform_grid(const SceneView& scene, const kernels::Mesh& mesh) {
    return mesh.walk == kernels::MESH_WALK_GRID && scene.words.at[mesh.reference_first] == 1;
}

// Rays that met an interface without a material go on in the next batch; t grows from hit to hit, so this ends. Names
// are places in `hits`.
void trace_batch(const SceneView& scene, std::vector<Ray>& rays, std::vector<std::size_t>& names, bool any,
                 const BatchWalk& walk, std::vector<TraceHit>& hits) {
    std::vector<Hit> found(rays.size());
    if (any) {
        walk(rays, kernels::TRACE_SOLID, true, found.data());
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
        walk(rays, any ? kernels::TRACE_PASS_THROUGH : kernels::TRACE_ALL, false, found.data());
        std::size_t kept = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!kernels::is_hit(found[i])) continue;
            if (material_of(scene, found[i]) != NONE) {
                if (any) hits[names[i]].t = 0;
                else hits[names[i]] = report(scene, found[i]);
                continue;
            }
            assert(found[i].t > rays[i].t_min);
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
    const auto trace = [&](std::size_t begin, std::size_t end, const BatchWalk& walk) {
        std::vector<Ray> usable;
        std::vector<std::size_t> names;
        for (std::size_t i = begin; i < end; ++i) {
            // Distances beyond INFINITE, +∞ among them, mean "no limit".
            const Ray ray(rays[i].origin, rays[i].t_min, rays[i].direction, std::min(rays[i].t_max, kernels::INFINITE));
            if (!is_usable(ray)) continue;
            usable.push_back(ray);
            names.push_back(i);
        }
        trace_batch(scene, usable, names, options.any, walk, hits);
    };
    if (options.method == TraceMethod::stream) {
        for (uint i = 0; i < scene.instance_count; ++i) {
            const kernels::Instance& instance = scene.instances.at[i];
            if (instance.geometry_kind == kernels::GEOMETRY_MESH &&
                !is_uniform_grid(scene, scene.meshes.at[instance.geometry]))
                return Error{"the streaming walk needs meshes that are built into 'grid'"};
        }
        std::vector<StreamPass> unread;
        std::vector<StreamPass>& passes = options.passes ? *options.passes : unread;
        trace(0, rays.size(), [&](std::span<const Ray> some, uint mask, bool any, Hit* found) {
            stream_trace(scene, some, mask, any, found, passes);
        });
        return hits;
    }
    BatchWalk walk = [&](std::span<const Ray> some, uint mask, bool any, Hit* found) {
        any ? device_batch_any(scene, some, mask, found) : device_batch_closest(scene, some, mask, found);
    };
    if (options.method == TraceMethod::brute_force)
        walk = [&](std::span<const Ray> some, uint mask, bool any, Hit* found) {
            brute_force(scene, some, mask, any, found);
        };
    parallel_for(rays.size(), batch_size, [&](std::size_t begin, std::size_t end) {
        for (; begin < end; begin += batch_size) trace(begin, std::min(begin + batch_size, end), walk);
    });
    return hits;
}

}  // namespace spinel
