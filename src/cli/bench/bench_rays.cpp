#include "cli/bench/bench_rays.h"

#include <algorithm>
#include <cmath>

#include "kernels/camera.h"
#include "kernels/frame.h"
#include "kernels/light.h"
#include "kernels/random.h"
#include "kernels/surface.h"
#include "kernels/traverse.h"
#include "kernels/warp.h"

namespace spinel::cli {
namespace {

using namespace kernels;

constexpr int tile = 8;

std::vector<Ray> camera_rays(const SceneView& scene, int edge) {
    std::vector<Ray> rays;
    rays.reserve(std::size_t(edge) * std::size_t(edge));
    for (int ty = 0; ty < edge; ty += tile)
        for (int tx = 0; tx < edge; tx += tile)
            for (int block = 0; block < tile * tile / 8; ++block)
                for (int i = 0; i < 8; ++i) {
                    const uvec2 pixel(uint(tx + (block & 1) * 4 + (i & 3)), uint(ty + (block >> 1) * 2 + (i >> 2)));
                    if (int(std::max(pixel.x, pixel.y)) < edge)
                        rays.push_back(camera_ray(scene.camera, pixel, vec2(0.5f), vec2(0.5f)));
                }
    return rays;
}

void cut_to_groups(std::vector<Ray>& rays) { rays.resize(rays.size() / 8 * 8); }

vec3 cosine_direction(vec3 normal, Rng& rng) {
    const float u = rng_1d(rng), v = rng_1d(rng);
    return normalize(to_world(make_frame(normal), square_to_cosine_hemisphere(vec2(u, v))));
}

}  // namespace

BenchRays scene_rays(const SceneView& scene, int edge) {
    BenchRays rays;
    rays.primary = camera_rays(scene, edge);
    for (std::size_t i = 0; i < rays.primary.size(); ++i) {
        const Ray& ray = rays.primary[i];
        const Hit hit = trace_closest(scene, ray, TRACE_ALL);
        if (!is_hit(hit)) continue;
        Rng rng(hash_uint(uint(i)), 0);
        const Surface s = surface_at(scene, ray, hit);
        const vec3 normal = dot(s.geometric_normal, ray.direction) < 0 ? s.geometric_normal : -s.geometric_normal;
        const vec3 bounce = cosine_direction(normal, rng);
        rays.diffuse.push_back({leave_surface(scene, s, bounce), 0, bounce, INFINITE});
        const float u_light = rng_1d(rng), u_keep = rng_1d(rng), u = rng_1d(rng), v = rng_1d(rng);
        const LightSample light = sample_light(scene, s.position, u_light, u_keep, vec2(u, v));
        if (!(light.pdf > 0)) continue;
        const vec3 from = leave_surface(scene, s, light.direction);
        rays.shadow.push_back(light.infinite ? Ray{from, 0, light.direction, INFINITE}
                                             : Ray{from, 0, light.point - from, 0.999f});
    }
    cut_to_groups(rays.primary);
    cut_to_groups(rays.diffuse);
    cut_to_groups(rays.shadow);
    return rays;
}

BenchRays voxel_rays(const SceneView& scene, uint instance, int edge) {
    BenchRays rays;
    const Instance& set = scene.instances.at[instance];
    rays.primary = camera_rays(scene, edge);
    for (std::size_t i = 0; i < rays.primary.size(); ++i) {
        Ray& ray = rays.primary[i];
        ray = ray_to_local(set, ray);
        Hit hit = no_hit(ray.t_max);
        voxels_closest(scene, set.geometry, set.slot_first, ray, hit);
        if (!(hit.t < ray.t_max)) continue;
        Rng rng(hash_uint(uint(i)), 0);
        rays.diffuse.push_back(
            {ray_at(ray, hit.t) + 0.001f * hit.normal, 0, cosine_direction(hit.normal, rng), INFINITE});
    }
    cut_to_groups(rays.primary);
    cut_to_groups(rays.diffuse);
    return rays;
}

}  // namespace spinel::cli
