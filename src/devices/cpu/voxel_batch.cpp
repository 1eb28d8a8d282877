// Which of the CPU's walks the rays of a batch take.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

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

namespace {

void answer_one_by_one(const SceneView& scene, uint grid, uint slot_first, uint instance, std::span<const Ray> rays,
                       Hit* hits) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
        hits[i] = kernels::no_hit(rays[i].t_max);
        closest_one_by_one(scene, grid, slot_first, instance, &rays[i], 1, hits + i);
    }
}

}  // namespace

#ifdef SPINEL_AVX2
SPINEL_AVX2_AS_ELSEWHERE_BEGIN

namespace {

constexpr std::size_t bundle_size = 64;

// Hits of batches that caches do not hold anyway go past them.
constexpr std::size_t streamed_size = 1 << 14;

unsigned closest8_avx2(const SceneView& scene, uint grid, uint slot_first, uint instance, const Ray* rays,
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
    stream_closest(scene, grid, slot_first, instance, {some, count}, theirs);
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

void closest_batch_avx2(const SceneView& scene, uint grid, uint slot_first, uint instance, std::span<const Ray> rays,
                        Hit* hits) {
    constexpr unsigned all = (1u << packet_size) - 1;
    const bool streaming = rays.size() >= streamed_size && reinterpret_cast<std::uintptr_t>(hits) % 16 == 0;
    std::size_t first = 0;  // of those that are no neighbours
    const auto stream_up_to = [&](std::size_t end) {
        if (first < end)
            stream_closest(scene, grid, slot_first, instance, rays.subspan(first, end - first), hits + first);
    };
    for (std::size_t i = 0; i + packet_size <= rays.size();) {
        const std::size_t size = std::min(bundle_size, (rays.size() - i) / packet_size * packet_size);
        if (bundle_closest(scene, grid, slot_first, instance, rays.subspan(i, size), streaming, hits + i)) {
            stream_up_to(i);
            first = i += size;
            continue;
        }
        for (const std::size_t end = i + size; i < end; i += packet_size) {
            const RayColumns columns = ray_columns(&rays[i]);
            if (!are_neighbours(columns, all)) continue;
            stream_up_to(i);
            for (std::size_t k = i; k < i + packet_size; ++k) hits[k] = kernels::no_hit(rays[k].t_max);
            packet_closest(scene, grid, slot_first, instance, columns, &rays[i], all, hits + i);
            first = i + packet_size;
        }
    }
    stream_up_to(rays.size());
    if (streaming) _mm_sfence();
}

}  // namespace

SPINEL_AVX2_END
#endif

unsigned cpu_voxels_closest8(const SceneView& scene, uint grid, uint slot_first, uint instance, const Ray* rays,
                             unsigned lanes, Hit* hits) {
#ifdef SPINEL_AVX2
    if (has_avx2()) return closest8_avx2(scene, grid, slot_first, instance, rays, lanes, hits);
#endif
    return closest_one_by_one(scene, grid, slot_first, instance, rays, lanes, hits);
}

void cpu_voxels_closest_batch(const SceneView& scene, uint grid, uint slot_first, uint instance,
                              std::span<const Ray> rays, Hit* hits) {
#ifdef SPINEL_AVX2
    if (has_avx2()) return closest_batch_avx2(scene, grid, slot_first, instance, rays, hits);
#endif
    answer_one_by_one(scene, grid, slot_first, instance, rays, hits);
}

void cpu_voxels_closest_stream(const SceneView& scene, uint grid, uint slot_first, uint instance,
                               std::span<const Ray> rays, Hit* hits) {
#ifdef SPINEL_AVX2
    if (has_avx2()) return stream_closest(scene, grid, slot_first, instance, rays, hits);
#endif
    answer_one_by_one(scene, grid, slot_first, instance, rays, hits);
}

}  // namespace spinel
