#include "devices/cpu/packet_trace.h"

#include <algorithm>
#include <bit>

#include "devices/cpu/mesh_walk.h"
#include "devices/cpu/voxel_walk.h"
#include "kernels/traverse.h"

namespace spinel {
namespace {

using kernels::BvhNode;
using kernels::Hit;
using kernels::Ray;
using kernels::SceneView;
using kernels::uint;

// One loop for each step of the test over eight rays, so that the compiler makes vectors of them.
struct SlabPacket {
    float lower_origin[3][packet_size];
    float upper_origin[3][packet_size];
    float inverse[3][packet_size];
    float t_min[packet_size];
    float t_max[packet_size];  // of the nearest hits

    SlabPacket(const Ray rays[packet_size], unsigned lanes) {
        for (int i = 0; i < packet_size; ++i) {
            // Rays that are not asked for repeat one that is: any number would do, but must be one.
            const Ray& ray = rays[lanes >> i & 1 ? i : std::countr_zero(lanes)];
            const kernels::SlabRay slab = kernels::instance_slab_ray(ray);
            for (int a = 0; a < 3; ++a) {
                lower_origin[a][i] = slab.lower_origin[a];
                upper_origin[a][i] = slab.upper_origin[a];
                inverse[a][i] = slab.inverse[a];
            }
            t_min[i] = ray.t_min;
            t_max[i] = ray.t_max;
        }
    }

    // The rays that kernels::slab_entry() finds in the box, and where the first of them enters.
    unsigned enter(const BvhNode& box, unsigned lanes, float& nearest) const {
        float in[packet_size], out[packet_size];
        std::copy_n(t_min, packet_size, in);
        std::copy_n(t_max, packet_size, out);
        for (int a = 0; a < 3; ++a)
            for (int i = 0; i < packet_size; ++i) {
                const float t0 = (box.lower[a] - lower_origin[a][i]) * inverse[a][i];
                const float t1 = (box.upper[a] - upper_origin[a][i]) * inverse[a][i];
                in[i] = std::max(in[i], std::min(t0, t1));
                out[i] = std::min(out[i], std::max(t0, t1));
            }
        unsigned inside = 0;
        for (int i = 0; i < packet_size; ++i) inside |= unsigned(in[i] <= out[i]) << i;
        inside &= lanes;
        nearest = kernels::INFINITE;
        for (unsigned rest = inside; rest; rest &= rest - 1) nearest = std::min(nearest, in[std::countr_zero(rest)]);
        return inside;
    }
};

bool is_mesh_for_packets(const SceneView& scene, const kernels::Instance& placed) {
    return placed.geometry_kind == kernels::GEOMETRY_MESH &&
           walks_in_packets(scene.meshes.at[kernels::walked_geometry(placed)]);
}

// As kernels::instance_closest for each ray.
void instance_closest8(const SceneView& scene, uint instance, const Ray rays[packet_size], unsigned lanes,
                       Hit hits[packet_size]) {
    const kernels::Instance& placed = scene.instances.at[instance];
    const bool voxels = placed.geometry_kind == kernels::GEOMETRY_VOXELS &&
                        scene.voxel_grids.at[placed.geometry].walk == kernels::VOXEL_WALK_TREE;
    const bool mesh = is_mesh_for_packets(scene, placed);
    if ((!voxels && !mesh) || std::has_single_bit(lanes)) {
        for (unsigned rest = lanes; rest; rest &= rest - 1) {
            const int i = std::countr_zero(rest);
            kernels::instance_closest(scene, instance, rays[i], hits[i]);
        }
        return;
    }
    Ray local[packet_size];
    Hit before[packet_size];
    for (int i = 0; i < packet_size; ++i) local[i] = kernels::ray_to_local(placed, rays[i]);
    for (unsigned rest = lanes; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        before[i] = hits[i];
        hits[i].t = kernels::instance_limit(instance, hits[i]);
        local[i].t_max = hits[i].t;
    }
    const unsigned found =
        mesh ? cpu_mesh_closest8(scene, kernels::walked_geometry(placed), instance, local, lanes, hits)
             : cpu_voxels_closest8(scene, placed.geometry, placed.slot_first, instance, local, lanes, hits);
    for (unsigned rest = placed.member_count > 0 ? lanes : lanes & ~found; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        kernels::settle_hit(scene, instance, local[i].t_max, before[i], hits[i]);
    }
}

// Calls visit(instance, rays) for all that any ray may hit, the nearer of two nodes first, while it returns rays that
// still ask.
template <class Visit>
void walk(const SceneView& scene, const SlabPacket& slab, unsigned lanes, uint mask, const Visit& visit) {
    struct Entry {
        uint node;
        unsigned lanes;
    };
    const auto leaf = [&](uint first, uint count, unsigned inside) {
        for (uint i = first; i < first + count && lanes; ++i) {
            const uint instance = scene.instance_order.at[i];
            if (kernels::instance_admitted(scene.instances.at[instance].flags, mask) && (inside & lanes))
                lanes = visit(instance, inside & lanes);
        }
    };
    if (scene.bounded_count > 0) {
        Entry stack[kernels::BVH_MAX_DEPTH + 2] = {{0, lanes}};
        int size = 1;
        while (size > 0 && lanes) {
            const Entry entry = stack[--size];
            const BvhNode& node = scene.instance_nodes.at[entry.node];
            // Once more: something nearer may have been hit meanwhile.
            float nearest;
            const unsigned inside = slab.enter(node, entry.lanes & lanes, nearest);
            if (!inside) continue;
            if (node.count > 0) {
                leaf(node.first, node.count, inside);
                continue;
            }
            float left_nearest, right_nearest;
            const unsigned left = slab.enter(scene.instance_nodes.at[node.first], inside, left_nearest);
            const unsigned right = slab.enter(scene.instance_nodes.at[node.first + 1], inside, right_nearest);
            const bool right_first = right_nearest < left_nearest;
            if (const unsigned far = right_first ? left : right) stack[size++] = {node.first + !right_first, far};
            if (const unsigned near = right_first ? right : left) stack[size++] = {node.first + right_first, near};
        }
    }
    leaf(scene.bounded_count, scene.unbounded_count, lanes);
}

}  // namespace

void cpu_trace_closest8(const SceneView& scene, const Ray rays[packet_size], unsigned lanes, uint mask,
                        Hit hits[packet_size]) {
    if (!lanes) return;
    for (int i = 0; i < packet_size; ++i)
        if (lanes >> i & 1) hits[i] = kernels::no_hit(rays[i].t_max);
    SlabPacket slab(rays, lanes);
    walk(scene, slab, lanes, mask, [&](uint instance, unsigned inside) {
        instance_closest8(scene, instance, rays, inside, hits);
        for (int i = 0; i < packet_size; ++i)
            if (lanes >> i & 1) slab.t_max[i] = hits[i].t;
        return lanes;
    });
}

unsigned cpu_trace_any8(const SceneView& scene, const Ray rays[packet_size], unsigned lanes, uint mask) {
    if (!lanes) return 0;
    unsigned blocked = 0;
    const SlabPacket slab(rays, lanes);
    walk(scene, slab, lanes, mask, [&](uint instance, unsigned inside) {
        const kernels::Instance& placed = scene.instances.at[instance];
        if (is_mesh_for_packets(scene, placed) && !std::has_single_bit(inside)) {
            Ray local[packet_size];
            for (int i = 0; i < packet_size; ++i) local[i] = kernels::ray_to_local(placed, rays[i]);
            blocked |= cpu_mesh_any8(scene, kernels::walked_geometry(placed), local, inside);
        } else if (placed.geometry_kind == kernels::GEOMETRY_VOXELS) {
            Hit hits[packet_size];
            for (int i = 0; i < packet_size; ++i) hits[i] = kernels::no_hit(rays[i].t_max);
            instance_closest8(scene, instance, rays, inside, hits);
            for (unsigned rest = inside; rest; rest &= rest - 1) {
                const int i = std::countr_zero(rest);
                blocked |= unsigned(kernels::is_hit(hits[i])) << i;
            }
        } else {
            for (unsigned rest = inside; rest; rest &= rest - 1) {
                const int i = std::countr_zero(rest);
                blocked |= unsigned(kernels::instance_any(scene, instance, rays[i])) << i;
            }
        }
        return lanes & ~blocked;
    });
    return blocked;
}

}  // namespace spinel
