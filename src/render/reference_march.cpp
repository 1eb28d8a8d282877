#include "render/reference_march.h"

#include "kernels/single_scatter.h"
#include "kernels/traverse.h"

namespace spinel {
namespace {

using namespace kernels;

float density_everywhere(const SceneView& scene, const Medium& m, vec3 p) {
    if (m.grid == NONE) return 1;
    const DensityGrid& grid = scene.grids.at[m.grid];
    const vec3 index = m.world_to_grid * vec4(p, 1);
    return grid_density(scene, grid, index) * erosion_factor(m, index / vec3(grid.size));
}

vec3 shadow(const SceneView& scene, vec3 origin, const Arrival& a, Inside inside, float step, float reach, float start,
            bool& bound_reached) {
    Ray ray(origin, 0, a.direction, a.distance);
    vec3 depth(0);
    float done = 0;
    for (uint segment = 0; segment < MAX_SCATTER_SEGMENTS; ++segment) {
        const Hit hit = trace_closest(scene, ray, TRACE_ALL);
        const ActiveMedia media = active_media(scene, inside);
        const float way = std::min(hit.t, std::max(reach - done, 0.0f));
        for (uint i = 0; media.count > 0 && float(i) * step < way; ++i) {
            if (i == MAX_MARCH_STEPS) {
                bound_reached = true;
                break;
            }
            const float t = float(i) * step, width = std::min(step, way - t);
            for (uint k = 0; k < media.count; ++k) {
                const Medium& m = scene.media.at[media.ids[k]];
                const float density = density_everywhere(scene, m, ray.origin + (t + start * width) * a.direction);
                depth += density * (m.scattering + m.absorption) * width;
            }
        }
        depth += media.absorption * way;
        done += hit.t;
        if (!is_hit(hit)) return exp_minus(depth);
        Surface s = surface_at(scene, ray, hit), under = s;
        inside = cross_boundary(scene, a.direction, TRACE_ALL, s, under, inside);
        if (surface_opacity(scene, s) > 0) return vec3(0);
        ray.origin = leave_surface(scene, s, a.direction);
        if (ray.t_max != INFINITE) ray.t_max -= hit.t;
        if (!(ray.t_max > 0)) return exp_minus(depth);
    }
    bound_reached = true;
    return vec3(0);
}

void march(const SceneView& scene, const MarchSettings& settings, float t_end, ScatterState& state) {
    const ActiveMedia media = active_media(scene, state.inside);
    state.transmitted *= exp_minus(media.absorption * (kernels::is_black(media.absorption) ? 0.0f : t_end));
    for (uint i = 0; media.count > 0 && float(i) * settings.step < t_end; ++i) {
        if (i == MAX_MARCH_STEPS) {
            state.bound_reached = true;
            break;
        }
        const float t = float(i) * settings.step, width = std::min(settings.step, t_end - t);
        const vec3 p = ray_at(state.ray, t + state.start * width);
        vec3 source(0), extinction(0);
        for (uint k = 0; k < media.count; ++k) {
            const Medium& m = scene.media.at[media.ids[k]];
            const float density = density_everywhere(scene, m, p);
            extinction += density * (m.scattering + m.absorption);
            source += density * (m.emission + m.scattering * scatter_sky(scene, vec3(0)));
            for (uint l = 0; l < scene.light_count; ++l) {
                if (!single_scatter_light(scene.lights.at[l].kind)) continue;
                const Arrival a = light_arrival(settings, scene.lights.at[l], p);
                source += density * m.scattering * phase_eval(m.g, dot(state.ray.direction, a.direction)) * a.value *
                          shadow(scene, p, a, state.inside, settings.shadow_step, settings.shadow_reach, 0.5f,
                                 state.bound_reached);
            }
        }
        scatter_step(settings, source, extinction, width, state);
    }
}

}  // namespace

PixelSample reference_single_scatter(const SceneView& scene, const MarchSettings& settings, const Ray& ray,
                                     const Inside& inside, Sampler numbers) {
    ScatterState state = scatter_begin(settings, ray, inside, numbers);
    for (uint segment = 0; segment < MAX_SCATTER_SEGMENTS; ++segment) {
        const Hit hit = trace_closest(scene, state.ray, TRACE_ALL);
        march(scene, settings, hit.t, state);
        if (!is_hit(hit)) {
            state.radiance += state.transmitted * environment_radiance(scene, state.ray.direction);
            return scatter_sample(state);
        }
        Surface s;
        if (!scatter_cross(scene, hit, state, s)) continue;
        ScatterSurface seen = scatter_surface(scene, s, state.ray.direction);
        for (uint l = 0; l < scene.light_count; ++l) {
            if (!single_scatter_light(scene.lights.at[l].kind)) continue;
            const Arrival a = light_arrival(settings, scene.lights.at[l], s.position);
            const float start = settings.jitter ? sampler_1d(numbers) : 0.5f;
            seen.light +=
                scatter_surface_light(seen, a) * shadow(scene, leave_surface(scene, s, a.direction), a, state.inside,
                                                        settings.surface_shadow_step, settings.surface_shadow_reach,
                                                        start, state.bound_reached);
        }
        return scatter_sample_of(scene, state, seen);
    }
    state.bound_reached = true;
    return scatter_sample(state);
}

}  // namespace spinel
