// Which of the CPU's walks the rays of a batch take.
#include <bit>
#include <cstddef>

#include "devices/cpu/voxel_packet.h"
#include "devices/cpu/voxel_walk.h"

namespace spinel {

using kernels::Hit;
using kernels::Ray;
using kernels::SceneView;
using kernels::uint;

unsigned closest_one_by_one(const SceneView& scene, uint grid, uint slot_first, uint instance, const Ray* rays,
                            unsigned lanes, Hit* hits) {
    unsigned found = 0;
    for (; lanes; lanes &= lanes - 1) {
        const int i = std::countr_zero(lanes);
        const float before = hits[i].t;
        cpu_voxels_closest(scene, grid, slot_first, rays[i], hits[i]);
        if (!(hits[i].t < before)) continue;
        hits[i].instance = instance;
        found |= 1u << i;
    }
    return found;
}

#ifdef __AVX2__

unsigned cpu_voxels_closest8(const SceneView& scene, uint grid, uint slot_first, uint instance, const Ray* rays,
                             unsigned lanes, Hit* hits) {
    const RayColumns columns = ray_columns(rays);
    if (are_neighbours(columns, lanes))
        return packet_closest(scene, grid, slot_first, instance, columns, rays, lanes, hits);
    Ray some[packet_size];
    Hit theirs[packet_size];
    std::size_t count = 0;
    for (unsigned rest = lanes; rest; rest &= rest - 1, ++count) {
        const int i = std::countr_zero(rest);
        some[count] = rays[i];
        some[count].t_max = hits[i].t;
    }
    cpu_voxels_closest_stream(scene, grid, slot_first, instance, {some, count}, theirs);
    unsigned found = 0;
    count = 0;
    for (unsigned rest = lanes; rest; rest &= rest - 1, ++count) {
        const int i = std::countr_zero(rest);
        if (!kernels::is_hit(theirs[count])) continue;
        hits[i] = theirs[count];
        found |= 1u << i;
    }
    return found;
}

void cpu_voxels_closest_batch(const SceneView& scene, uint grid, uint slot_first, uint instance,
                              std::span<const Ray> rays, Hit* hits) {
    constexpr unsigned all = (1u << packet_size) - 1;
    std::size_t first = 0;  // of those that are no neighbours
    const auto stream_up_to = [&](std::size_t end) {
        cpu_voxels_closest_stream(scene, grid, slot_first, instance, rays.subspan(first, end - first), hits + first);
    };
    for (std::size_t i = 0; i + packet_size <= rays.size(); i += packet_size) {
        const RayColumns columns = ray_columns(&rays[i]);
        if (!are_neighbours(columns, all)) continue;
        if (first < i) stream_up_to(i);
        for (std::size_t k = i; k < i + packet_size; ++k) hits[k] = kernels::no_hit(rays[k].t_max);
        packet_closest(scene, grid, slot_first, instance, columns, &rays[i], all, hits + i);
        first = i + packet_size;
    }
    stream_up_to(rays.size());
}

#else

unsigned cpu_voxels_closest8(const SceneView& scene, uint grid, uint slot_first, uint instance, const Ray* rays,
                             unsigned lanes, Hit* hits) {
    return closest_one_by_one(scene, grid, slot_first, instance, rays, lanes, hits);
}

void cpu_voxels_closest_batch(const SceneView& scene, uint grid, uint slot_first, uint instance,
                              std::span<const Ray> rays, Hit* hits) {
    cpu_voxels_closest_stream(scene, grid, slot_first, instance, rays, hits);
}

#endif

}  // namespace spinel
