// Embree 3, the peer to beat, on the same triangles and rays.

#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <memory>

#include "cli/bench/bench_measure.h"
#include "cli/bench/world_mesh.h"

namespace spinel::cli {
namespace {

using kernels::Hit;
using kernels::Ray;

struct Mode {
    const char* name;
    RTCBuildQuality quality;
    RTCSceneFlags flags;
    bool packets;
};

constexpr Mode modes[] = {
    {"embree-high", RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE, false},
    {"embree-medium", RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_NONE, false},
    {"embree-low", RTC_BUILD_QUALITY_LOW, RTC_SCENE_FLAG_NONE, false},
    {"embree-robust", RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_ROBUST, false},
    {"embree-compact", RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_COMPACT, false},
    {"embree-high-8", RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE, true},
};

struct Built {
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = nullptr;
    std::atomic<std::ptrdiff_t> bytes{0};
    std::vector<vec3> positions;  // with what Embree may read beyond the last
    double build_ms = 0;

    Built(const WorldMesh& mesh, const Mode& mode) : positions(mesh.positions) {
        positions.emplace_back(0);
        rtcSetDeviceMemoryMonitorFunction(
            device,
            [](void* self, ssize_t change, bool) {
                static_cast<Built*>(self)->bytes += change;
                return true;
            },
            this);
        build_ms = median_build_ms([&] {
            if (scene) rtcReleaseScene(scene);
            bytes = 0;
            scene = rtcNewScene(device);
            rtcSetSceneBuildQuality(scene, mode.quality);
            rtcSetSceneFlags(scene, mode.flags);
            RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
            rtcSetGeometryBuildQuality(geometry, mode.quality);
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions.data(), 0,
                                       sizeof(vec3), mesh.positions.size());
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                                       sizeof(uvec3), mesh.indices.size());
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(scene, geometry);
            rtcReleaseGeometry(geometry);
            const double start = processor_seconds();
            rtcCommitScene(scene);
            return processor_seconds() - start;
        });
    }
    Built(const Built&) = delete;
    Built& operator=(const Built&) = delete;
    ~Built() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
};

RTCRay embree_ray(const Ray& ray) {
    RTCRay r = {};
    r.org_x = ray.origin.x, r.org_y = ray.origin.y, r.org_z = ray.origin.z;
    r.dir_x = ray.direction.x, r.dir_y = ray.direction.y, r.dir_z = ray.direction.z;
    r.tnear = ray.t_min;
    r.tfar = ray.t_max;
    r.mask = ~0u;
    return r;
}

void put(Hit& hit, float t, unsigned geometry, unsigned triangle, float u, float v) {
    hit = kernels::no_hit(t);
    hit.uv = vec2(u, v);
    hit.primitive = triangle;
    if (geometry != RTC_INVALID_GEOMETRY_ID) hit.instance = 0;
}

void closest_one(RTCScene scene, std::span<const Ray> rays, Hit* hits) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        RTCRayHit r;
        r.ray = embree_ray(rays[i]);
        r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &r);
        put(hits[i], r.ray.tfar, r.hit.geomID, r.hit.primID, r.hit.u, r.hit.v);
    }
}

void any_one(RTCScene scene, std::span<const Ray> rays, Hit* hits) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        RTCRay r = embree_ray(rays[i]);
        rtcOccluded1(scene, &context, &r);
        hits[i].instance = r.tfar < 0 ? 0 : kernels::NONE;
    }
}

// RTCRay8 and RTCRayHit8 begin with the same arrays.
template <class Packet>
void fill(Packet& r, const Ray* rays) {
    for (int k = 0; k < 8; ++k) {
        r.org_x[k] = rays[k].origin.x, r.org_y[k] = rays[k].origin.y, r.org_z[k] = rays[k].origin.z;
        r.dir_x[k] = rays[k].direction.x, r.dir_y[k] = rays[k].direction.y, r.dir_z[k] = rays[k].direction.z;
        r.tnear[k] = rays[k].t_min;
        r.tfar[k] = rays[k].t_max;
        r.time[k] = 0;
        r.mask[k] = ~0u;
        r.id[k] = r.flags[k] = 0;
    }
}

constexpr int all_eight[8] = {-1, -1, -1, -1, -1, -1, -1, -1};

void closest_eight(RTCScene scene, std::span<const Ray> rays, Hit* hits) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (std::size_t i = 0; i < rays.size(); i += 8) {
        RTCRayHit8 r;
        fill(r.ray, &rays[i]);
        for (int k = 0; k < 8; ++k) r.hit.geomID[k] = r.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
        alignas(32) int valid[8];
        std::copy_n(all_eight, 8, valid);
        rtcIntersect8(valid, scene, &context, &r);
        for (int k = 0; k < 8; ++k)
            put(hits[i + std::size_t(k)], r.ray.tfar[k], r.hit.geomID[k], r.hit.primID[k], r.hit.u[k], r.hit.v[k]);
    }
}

void any_eight(RTCScene scene, std::span<const Ray> rays, Hit* hits) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (std::size_t i = 0; i < rays.size(); i += 8) {
        RTCRay8 r;
        fill(r, &rays[i]);
        alignas(32) int valid[8];
        std::copy_n(all_eight, 8, valid);
        rtcOccluded8(valid, scene, &context, &r);
        for (int k = 0; k < 8; ++k) hits[i + std::size_t(k)].instance = r.tfar[k] < 0 ? 0 : kernels::NONE;
    }
}

}  // namespace

std::vector<BenchStructure> embree_structures(const WorldMesh& mesh) {
    std::vector<BenchStructure> list;
    if (mesh.triangles.empty()) return list;
    for (const Mode& mode : modes) {
        const auto built = std::make_shared<Built>(mesh, mode);
        BenchStructure s;
        s.name = mode.name;
        s.build_ms = built->build_ms;
        s.bytes = double(built->bytes);
        const auto closest = mode.packets ? closest_eight : closest_one;
        const auto any = mode.packets ? any_eight : any_one;
        s.closest = [built, closest](std::span<const Ray> rays, Hit* hits) { closest(built->scene, rays, hits); };
        s.any = [built, any](std::span<const Ray> rays, Hit* hits) { any(built->scene, rays, hits); };
        list.push_back(std::move(s));
    }
    return list;
}

}  // namespace spinel::cli
