// Batches of rays against a few instances with sets of voxels among them: every set answers all rays at once, by
// packets and streams; other instances are asked ray by ray. Many instances, or none of voxels, are for the tree over
// instances, which says which of them a ray meets: eight rays together that are coherent, all others one by one.
#include "render/ray_batch.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "devices/cpu/packet_trace.h"
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

// How far apart along an axis rays of a packet may begin.
float packet_side(const SceneView& scene) {
    if (scene.bounded_count == 0) return 0;
    const kernels::BvhNode& all = scene.instance_nodes.at[0];
    return 0.05f * kernels::max_component(all.upper - all.lower);
}

// Whether rays are of one octant, side by side and of much the same direction, so that they are faster together.
bool are_coherent(const Ray rays[packet_size], float side) {
    const auto octant = [](const Ray& ray) {
        const glm::vec3 d = ray.direction;
        return int(std::signbit(d.x)) + 2 * int(std::signbit(d.y)) + 4 * int(std::signbit(d.z));
    };
    const Ray& first = rays[0];
    const float length2 = glm::dot(first.direction, first.direction);
    for (int i = 1; i < packet_size; ++i) {
        const Ray& ray = rays[i];
        const glm::vec3 apart = glm::abs(ray.origin - first.origin);
        const float along = glm::dot(ray.direction, first.direction);
        if (octant(ray) != octant(first) || !(kernels::max_component(apart) <= side) ||
            !(along * along > 0.9f * length2 * glm::dot(ray.direction, ray.direction)))
            return false;
    }
    return true;
}

// Calls together(i) for eight rays from i on that are coherent, alone(i) for each other.
template <class Together, class Alone>
void for_each_packet(const SceneView& scene, std::span<const Ray> rays, const Together& together, const Alone& alone) {
    const float side = packet_side(scene);
    for (std::size_t i = 0; i < rays.size();) {
        if (i + packet_size <= rays.size() && are_coherent(&rays[i], side)) {
            together(i);
            i += packet_size;
        } else {
            alone(i++);
        }
    }
}

constexpr unsigned all_lanes = (1u << packet_size) - 1;

}  // namespace

void device_batch_closest(const SceneView& scene, std::span<const Ray> rays, uint mask, Hit* hits) {
    if (!suits_batches(scene)) {
        return for_each_packet(
            scene, rays, [&](std::size_t i) { cpu_trace_closest8(scene, &rays[i], all_lanes, mask, hits + i); },
            [&](std::size_t i) { hits[i] = kernels::trace_closest(scene, rays[i], mask); });
    }
    LocalRays local;
    for (std::size_t i = 0; i < rays.size(); i += piece_size)
        closest_piece(scene, rays.subspan(i, std::min(piece_size, rays.size() - i)), mask, local, hits + i);
}

void device_batch_any(const SceneView& scene, std::span<const Ray> rays, uint mask, Hit* hits) {
    if (!suits_batches(scene)) {
        const auto tell = [&](std::size_t i, bool blocked) {
            hits[i] = kernels::no_hit(rays[i].t_max);
            if (blocked) hits[i].instance = 0;
        };
        return for_each_packet(
            scene, rays,
            [&](std::size_t i) {
                const unsigned blocked = cpu_trace_any8(scene, &rays[i], all_lanes, mask);
                for (unsigned k = 0; k < packet_size; ++k) tell(i + k, blocked >> k & 1);
            },
            [&](std::size_t i) { tell(i, kernels::trace_any(scene, rays[i], mask)); });
    }
    LocalRays local;
    for (std::size_t i = 0; i < rays.size(); i += piece_size)
        any_piece(scene, rays.subspan(i, std::min(piece_size, rays.size() - i)), mask, local, hits + i);
}

}  // namespace spinel
