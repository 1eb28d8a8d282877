// Batches of rays against a few instances with sets of voxels among them: every set answers all rays at once, by
// packets and streams; other instances are asked ray by ray. Many instances, or none of voxels, are the kernels': their
// tree over instances says which of them a ray meets.
#include "render/ray_batch.h"

#include <algorithm>
#include <vector>

#include "devices/cpu/voxel_walk.h"
#include "kernels/traverse.h"

namespace spinel {
namespace {

using kernels::Hit;
using kernels::Instance;
using kernels::Ray;
using kernels::SceneView;
using kernels::uint;

constexpr uint most_instances = 8;

// As many rays as stay in the second cache with their hits.
constexpr std::size_t piece_size = 2048;

bool is_voxel_tree(const SceneView& scene, const Instance& instance) {
    return instance.geometry_kind == kernels::GEOMETRY_VOXELS &&
           scene.voxel_grids.at[instance.geometry].walk == kernels::VOXEL_WALK_TREE;
}

bool suits_batches(const SceneView& scene) {
    const uint count = scene.bounded_count + scene.unbounded_count;
    if (count > most_instances) return false;
    for (uint i = 0; i < count; ++i)
        if (is_voxel_tree(scene, scene.instances.at[scene.instance_order.at[i]])) return true;
    return false;
}

// Calls visit(instance) for those that the mask admits.
template <class Visit>
void for_each_instance(const SceneView& scene, uint mask, const Visit& visit) {
    for (uint i = 0; i < scene.bounded_count + scene.unbounded_count; ++i) {
        const uint instance = scene.instance_order.at[i];
        if (kernels::instance_admitted(scene.instances.at[instance].flags, mask)) visit(instance);
    }
}

// Rays of one instance and what they hit there.
class LocalRays {
  public:
    // `limit(i)` is up to where ray i asks.
    template <class Limit>
    const std::vector<Hit>& ask(const SceneView& scene, uint instance, std::span<const Ray> rays, const Limit& limit) {
        const Instance& placed = scene.instances.at[instance];
        rays_.resize(rays.size());
        hits_.resize(rays.size());
        for (std::size_t i = 0; i < rays.size(); ++i) {
            rays_[i] = kernels::ray_to_local(placed, rays[i]);
            rays_[i].t_max = limit(i);
        }
        cpu_voxels_closest_batch(scene, placed.geometry, placed.slot_first, instance, rays_, hits_.data());
        return hits_;
    }

  private:
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
};

void closest_piece(const SceneView& scene, std::span<const Ray> rays, uint mask, LocalRays& local, Hit* hits) {
    for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = kernels::no_hit(rays[i].t_max);
    for_each_instance(scene, mask, [&](uint instance) {
        if (!is_voxel_tree(scene, scene.instances.at[instance])) {
            for (std::size_t i = 0; i < rays.size(); ++i) kernels::instance_closest(scene, instance, rays[i], hits[i]);
            return;
        }
        const std::vector<Hit>& found =
            local.ask(scene, instance, rays, [&](std::size_t i) { return kernels::instance_limit(instance, hits[i]); });
        for (std::size_t i = 0; i < rays.size(); ++i)
            if (kernels::is_hit(found[i])) hits[i] = found[i];
    });
}

void any_piece(const SceneView& scene, std::span<const Ray> rays, uint mask, LocalRays& local, Hit* hits) {
    for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = kernels::no_hit(rays[i].t_max);
    std::vector<Ray> open(rays.begin(), rays.end());  // rays that nothing is in the way of so far …
    std::vector<std::size_t> names(rays.size());      // … and which they are
    for (std::size_t i = 0; i < names.size(); ++i) names[i] = i;
    for_each_instance(scene, mask, [&](uint instance) {
        const auto keep_others = [&](const auto& is_blocked) {
            std::size_t kept = 0;
            for (std::size_t i = 0; i < open.size(); ++i) {
                if (is_blocked(i)) {
                    hits[names[i]].instance = instance;
                    continue;
                }
                open[kept] = open[i];
                names[kept++] = names[i];
            }
            open.resize(kept);
        };
        if (!is_voxel_tree(scene, scene.instances.at[instance]))
            return keep_others([&](std::size_t i) { return kernels::instance_any(scene, instance, open[i]); });
        const std::vector<Hit>& found = local.ask(scene, instance, open, [&](std::size_t i) { return open[i].t_max; });
        keep_others([&](std::size_t i) { return kernels::is_hit(found[i]); });
    });
}

}  // namespace

void device_batch_closest(const SceneView& scene, std::span<const Ray> rays, uint mask, Hit* hits) {
    if (!suits_batches(scene)) {
        for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = kernels::trace_closest(scene, rays[i], mask);
        return;
    }
    LocalRays local;
    for (std::size_t i = 0; i < rays.size(); i += piece_size)
        closest_piece(scene, rays.subspan(i, std::min(piece_size, rays.size() - i)), mask, local, hits + i);
}

void device_batch_any(const SceneView& scene, std::span<const Ray> rays, uint mask, Hit* hits) {
    if (!suits_batches(scene)) {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            hits[i] = kernels::no_hit(rays[i].t_max);
            if (kernels::trace_any(scene, rays[i], mask)) hits[i].instance = 0;
        }
        return;
    }
    LocalRays local;
    for (std::size_t i = 0; i < rays.size(); i += piece_size)
        any_piece(scene, rays.subspan(i, std::min(piece_size, rays.size() - i)), mask, local, hits + i);
}

}  // namespace spinel
