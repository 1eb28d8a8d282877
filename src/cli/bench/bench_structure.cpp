#include "cli/bench/bench_structure.h"

#include <chrono>
#include <memory>

#include "devices/cpu/packet_trace.h"
#include "devices/cpu/voxel_walk.h"
#include "kernels/traverse.h"

namespace spinel::cli {
namespace {

using kernels::Hit;
using kernels::Ray;
using kernels::SceneView;
using kernels::uint;

constexpr std::size_t most_dense_cells = std::size_t(1) << 29;

template <class Build>
double milliseconds(const Build& build) {
    const auto start = std::chrono::steady_clock::now();
    build();
    return 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// One walk of one set, ray by ray.
template <class Walk>
auto ray_by_ray(Walk walk) {
    return [walk](std::span<const Ray> rays, Hit* hits) {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            Hit hit = kernels::no_hit(rays[i].t_max);
            walk(rays[i], hit);
            if (hit.t < rays[i].t_max) hit.instance = 0;
            hits[i] = hit;
        }
    };
}

template <class T>
double size_of(const std::vector<T>& v) {
    return double(v.size() * sizeof(T));
}

}  // namespace

std::vector<BenchStructure> scene_structures(const CompiledScene& scene, const std::string& scene_structure,
                                             double build_ms) {
    const SceneView view = scene.view();
    double bytes = size_of(scene.instance_nodes) + size_of(scene.instance_order) + size_of(scene.voxel_nodes);
    for (const MeshStatistics& mesh : scene.mesh_statistics) bytes += double(mesh.bytes);
    std::vector<BenchStructure> list;
    BenchStructure single;
    single.name = scene_structure;
    single.build_ms = build_ms;
    single.bytes = bytes;
    single.closest = [view](std::span<const Ray> rays, Hit* hits) {
        for (std::size_t i = 0; i < rays.size(); ++i)
            hits[i] = kernels::trace_closest(view, rays[i], kernels::TRACE_ALL);
    };
    single.any = [view](std::span<const Ray> rays, Hit* hits) {
        for (std::size_t i = 0; i < rays.size(); ++i)
            hits[i].instance = kernels::trace_any(view, rays[i], kernels::TRACE_ALL) ? 0 : kernels::NONE;
    };
    list.push_back(std::move(single));
    BenchStructure packets = list.front();
    packets.name += ", 8 rays";
    packets.closest = [view](std::span<const Ray> rays, Hit* hits) {
        for (std::size_t i = 0; i < rays.size(); i += packet_size)
            cpu_trace_closest8(view, &rays[i], 0xff, kernels::TRACE_ALL, hits + i);
    };
    packets.any = [view](std::span<const Ray> rays, Hit* hits) {
        for (std::size_t i = 0; i < rays.size(); i += packet_size) {
            const unsigned blocked = cpu_trace_any8(view, &rays[i], 0xff, kernels::TRACE_ALL);
            for (int k = 0; k < packet_size; ++k)
                hits[i + std::size_t(k)].instance = blocked >> k & 1 ? 0 : kernels::NONE;
        }
    };
    list.push_back(std::move(packets));
    return list;
}

std::vector<BenchStructure> voxel_structures(const CompiledScene& scene, uint instance, const VoxelTree& tree) {
    const SceneView view = scene.view();
    const uint grid = scene.instances[instance].geometry, slots = scene.instances[instance].slot_first;
    const VoxelTreeMemory memory = tree.memory();
    const double bytes = double(memory.node_bytes + memory.reference_bytes);
    std::vector<BenchStructure> list;
    list.push_back({"64-tree", 0, bytes, [=](std::span<const Ray> rays, Hit* hits) {
                        cpu_voxels_closest_batch(view, grid, slots, 0, rays, hits);
                    }});
    list.push_back({"64-tree, packets", 0, bytes, [=](std::span<const Ray> rays, Hit* hits) {
                        for (std::size_t i = 0; i < rays.size(); i += packet_size) {
                            for (std::size_t k = i; k < i + packet_size; ++k) hits[k] = kernels::no_hit(rays[k].t_max);
                            cpu_voxels_closest8(view, grid, slots, 0, &rays[i], 0xff, hits + i);
                        }
                    }});
    list.push_back({"64-tree, stream", 0, bytes, [=](std::span<const Ray> rays, Hit* hits) {
                        cpu_voxels_closest_stream(view, grid, slots, 0, rays, hits);
                    }});
    list.push_back({"64-tree, one ray", 0, bytes,
                    ray_by_ray([=](const Ray& ray, Hit& hit) { cpu_voxels_closest(view, grid, slots, ray, hit); })});
    list.push_back({"64-tree, kernel", 0, bytes, ray_by_ray([=](const Ray& ray, Hit& hit) {
                        kernels::voxels_closest(view, grid, slots, ray, hit);
                    })});
    for (BenchStructure& s : list)
        s.count = [=](const Ray& ray, bool) {
            const VoxelWalkCount c = cpu_voxels_count(view, grid, slots, ray);
            return kernels::WalkCount(c.nodes, 0u, c.cubes);
        };
    const glm::dvec3 size(tree.size());
    if (size.x * size.y * size.z <= double(most_dense_cells)) {
        auto dense = std::make_shared<DenseVoxels>();
        const double build = milliseconds([&] { *dense = dense_voxels(tree); });
        list.push_back({"dense 3D-DDA", build, size_of(dense->cells),
                        ray_by_ray([=](const Ray& ray, Hit& hit) { dense_closest(view, *dense, slots, ray, hit); })});
        list.back().stride = 8;
    }
    for (BenchStructure& peer : nanovdb_structures(tree)) list.push_back(std::move(peer));
    return list;
}

}  // namespace spinel::cli
