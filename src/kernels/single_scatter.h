#ifndef SPINEL_KERNELS_SINGLE_SCATTER_H
#define SPINEL_KERNELS_SINGLE_SCATTER_H
// `single-scatter`: light that media scatter once on its way from the lights without a surface to the camera, by
// marching in fixed steps, and the shadows that media cast. Without noise but for the place where a march begins.
//
// Along a camera ray, in each step of length Δ, with the density ρ and what arrives of the lights, L, in its middle:
//   energy-conserving  radiance += T · (S − S·exp(−σt ρ Δ)) / (σt ρ),  S = σs ρ L (phase function included)
//   naive              radiance += T · S · Δ
// and then T ·= exp(−σt ρ Δ). The first is exact where nothing changes within a step (Hillaire, "Physically Based and
// Unified Volumetric Rendering in Frostbite", 2015); the second grows brighter than it may in dense media.
// Towards each light the same medium is marched in steps of its own, as far as the settings let it.
//
// Marches are straight: this is what the shortcuts of devices (devices/cpu/march.cpp) are tested against.
//
// Lights are points, spots and directional lights, the last without their size. The environment is even light, without
// shadows: its mean above and below the horizon. Surfaces that emit are seen, but light nothing. Glass is seen through
// without being bent, as in the previews (preview_shade.h).
#include "boundary.h"
#include "device.h"
#include "medium.h"
#include "path_settings.h"
#include "phase.h"
#include "preview_shade.h"
KERNELS_BEGIN

const uint MAX_MARCH_STEPS = 65536u;  // of one segment
const uint MAX_SCATTER_SEGMENTS = 4096u;

// A camera ray on its way.
struct ScatterState {
    Ray ray;  // the piece that comes next
    Inside inside;
    float start;  // where in its step a march looks, 0 … 1
    float travelled;
    vec3 transmitted;
    vec3 radiance;
    bool bound_reached;
};

// What arrives of a light if nothing is in the way.
struct Arrival {
    vec3 direction;  // unit, to the light
    float distance;
    vec3 value;  // irradiance on a surface that faces it
};

// Even light from the environment towards a normal, irradiance over π. Without one the previews' studio is no light.
FN vec3 scatter_sky(const_in(SceneView) scene, vec3 normal) {
    return scene.environment.width > 0u ? preview_sky(scene, normal) : vec3(0.0f);
}

FN bool single_scatter_light(uint kind) {
    return kind == LIGHT_POINT || kind == LIGHT_SPOT || kind == LIGHT_DIRECTIONAL;
}

FN Arrival light_arrival(const_in(MarchSettings) settings, const_in(Light) light, vec3 p) {
    if (light.kind == LIGHT_DIRECTIONAL) {
        float size = light.radius > 0.0f ? PI * sqr(sin(light.radius)) : 1.0f;
        return Arrival(-light.direction, INFINITE, light.radiance * size);
    }
    vec3 to = light.position - p;
    float d2 = dot(to, to);
    if (!(d2 > 0.0f)) return Arrival(vec3(0.0f, 1.0f, 0.0f), 0.0f, vec3(0.0f));
    float d = sqrt(d2);
    Arrival a = Arrival(to / d, d, light.radiance / d2);
    if (light.kind == LIGHT_SPOT) {
        float c = -dot(a.direction, light.direction);
        if (c < light.cos_outer) a.value = vec3(0.0f);
        else if (c < light.cos_inner) a.value *= smoothstep(light.cos_outer, light.cos_inner, c);
    }
    if (settings.light_reach > 0.0f) a.value *= sqr(clamp(1.0f - d / settings.light_reach, 0.0f, 1.0f));
    return a;
}

// Optical depth of media from `origin` to t_end along a unit direction; steps begin at the origin.
FN vec3 march_depth(const_in(SceneView) scene, const_in(ActiveMedia) media, vec3 origin, vec3 direction, float t_end,
                    float step, float start, inout(bool) bound_reached) {
    vec3 depth = vec3(0.0f);
    if (media.count == 0u) return depth;
    for (uint i = 0u; i < MAX_MARCH_STEPS; ++i) {
        float t = float(i) * step;
        if (t >= t_end) return depth;
        float width = min(step, t_end - t);
        MediumPoint m = media_at(scene, media, origin + (t + start * width) * direction);
        depth += (m.scattering + m.absorption) * width;
    }
    bound_reached = true;
    return depth;
}

FN vec3 exp_minus(vec3 depth) { return vec3(exp(-depth.x), exp(-depth.y), exp(-depth.z)); }

// Part of the light that comes through from `distance` away along a unit direction; media count as far as `reach`.
FN vec3 march_shadow(const_in(SceneView) scene, vec3 origin, vec3 direction, float distance, Inside inside, float step,
                     float reach, float start, inout(bool) bound_reached) {
    Ray ray = Ray(origin, 0.0f, direction, distance);
    if (trace_occluded(scene, ray)) return vec3(0.0f);
    if (inside.count == 0u && scene.pass_through_count == 0u) return vec3(1.0f);
    vec3 clear = vec3(1.0f);
    vec3 depth = vec3(0.0f);
    float done = 0.0f;
    for (uint i = 0u; i < MAX_SCATTER_SEGMENTS; ++i) {
        Hit hit = no_hit(ray.t_max);
        if (scene.pass_through_count > 0u) hit = trace_closest(scene, ray, TRACE_PASS_THROUGH);
        ActiveMedia media = active_media(scene, inside);
        float way = min(hit.t, max(reach - done, 0.0f));
        if (!is_black(media.absorption)) depth += media.absorption * way;
        depth += march_depth(scene, media, ray.origin, direction, way, step, start, bound_reached);
        done += hit.t;
        if (!is_hit(hit)) return clear * exp_minus(depth);
        Surface s = surface_at(scene, ray, hit);
        Surface under = s;
        inside = cross_boundary(scene, direction, TRACE_PASS_THROUGH, s, under, inside);
        if (inside.dropped > 0u) bound_reached = true;
        clear *= 1.0f - surface_opacity(scene, s);
        if (is_black(clear)) return clear;
        ray.origin = leave_surface(scene, s, direction);
        if (ray.t_max != INFINITE) ray.t_max -= hit.t;
        if (!(ray.t_max > 0.0f)) return clear * exp_minus(depth);
    }
    bound_reached = true;
    return vec3(0.0f);
}

// One step of the camera's march: S = source · (what arrives), extinction per unit length.
FN void scatter_step(const_in(MarchSettings) settings, vec3 source, vec3 extinction, float width,
                     inout(ScatterState) state) {
    vec3 left = exp_minus(extinction * width);
    if (settings.naive != 0u) {
        state.radiance += state.transmitted * source * width;
    } else {
        vec3 share;  // ∫ exp(−σt x) dx over the step
        for (int k = 0; k < 3; ++k)
            share[k] = extinction[k] * width > 1.0e-4f ? (1.0f - left[k]) / extinction[k]
                                                       : width * (1.0f - 0.5f * extinction[k] * width);
        state.radiance += state.transmitted * source * share;
    }
    state.transmitted *= left;
}

// Light that the media at p send back along the ray: emission, and what they scatter once.
FN vec3 scatter_source(const_in(SceneView) scene, const_in(MarchSettings) settings, const_in(ActiveMedia) media,
                       const_in(MediumPoint) point, vec3 p, inout(ScatterState) state) {
    vec3 source = point.emission;
    if (is_black(point.scattering)) return source;
    source += point.scattering * scatter_sky(scene, vec3(0.0f));
    for (uint i = 0u; i < scene.light_count; ++i) {
        RECORD(Light) light = scene.lights.at[i];
        if (!single_scatter_light(light.kind)) continue;
        Arrival a = light_arrival(settings, light, p);
        if (is_black(a.value)) continue;
        vec3 scattered = vec3(0.0f);
        for (uint k = 0u; k < media.count; ++k) {
            RECORD(Medium) m = scene.media.at[media.ids[k]];
            float density = media.count == 1u ? 1.0f : medium_density(scene, m, p);
            scattered += (media.count == 1u ? point.scattering : density * m.scattering) *
                         phase_eval(m.g, dot(state.ray.direction, a.direction));
        }
        source += scattered * a.value *
                  march_shadow(scene, p, a.direction, a.distance, state.inside, settings.shadow_step,
                               settings.shadow_reach, 0.5f, state.bound_reached);
    }
    return source;
}

// The media along the ray from its origin to t_end.
FN void scatter_march(const_in(SceneView) scene, const_in(MarchSettings) settings, float t_end,
                      inout(ScatterState) state) {
    ActiveMedia media = active_media(scene, state.inside);
    if (!is_black(media.absorption)) state.transmitted *= exp_minus(media.absorption * t_end);
    if (media.count == 0u) return;
    for (uint i = 0u; i < MAX_MARCH_STEPS; ++i) {
        float t = float(i) * settings.step;
        if (t >= t_end) return;
        float width = min(settings.step, t_end - t);
        vec3 p = ray_at(state.ray, t + state.start * width);
        MediumPoint point = media_at(scene, media, p);
        vec3 extinction = point.scattering + point.absorption;
        if (is_black(extinction) && is_black(point.emission)) continue;
        scatter_step(settings, scatter_source(scene, settings, media, point, p, state), extinction, width, state);
    }
    state.bound_reached = true;
}

FN ScatterState scatter_begin(const_in(MarchSettings) settings, Ray ray, Inside inside, inout(Sampler) numbers) {
    float start = settings.jitter != 0u ? sampler_1d(numbers) : 0.5f;
    return ScatterState(ray, inside, start, 0.0f, vec3(1.0f), vec3(0.0f), inside.dropped > 0u);
}

// Crosses what the ray hits, or stops there: true, and `s` is what is seen.
FN bool scatter_cross(const_in(SceneView) scene, const_in(Hit) hit, inout(ScatterState) state, inout(Surface) s) {
    s = surface_at(scene, state.ray, hit);
    state.travelled += distance(state.ray.origin, s.position);
    Inside after = state.inside;
    if (s.leaves != NONE || s.enters != NONE || s.contact) {
        Surface under = s;
        after = cross_boundary(scene, state.ray.direction, TRACE_ALL, s, under, state.inside);
        if (after.dropped > 0u) state.bound_reached = true;
    }
    bool seen = s.material != NONE && surface_opacity(scene, s) >= 0.5f;
    if (seen && !preview_is_glass(scene, s.material)) return true;
    if (seen) {
        RECORD(Material) m = scene.materials.at[s.material];
        if (s.entering) {
            float f0 = sqr((m.ior - 1.0f) / (m.ior + 1.0f));
            float cosine = min(abs(dot(state.ray.direction, s.normal)), 1.0f);
            float fresnel = f0 + (1.0f - f0) * pow(1.0f - cosine, 5.0f);
            vec3 mirrored = environment_radiance(scene, normalize(reflect(state.ray.direction, s.normal)));
            state.radiance += state.transmitted * fresnel * mirrored;
            state.transmitted *= 1.0f - fresnel;
        }
        state.transmitted *= m.color;
    }
    state.ray.origin = leave_surface(scene, s, state.ray.direction);
    state.inside = after;
    return false;
}

// A surface that is seen, ready for its lights.
struct ScatterSurface {
    Surface surface;
    Frame frame;
    Bsdf bsdf;
    vec3 wo;     // local
    vec3 light;  // reflected so far, emission included
};

FN ScatterSurface scatter_surface(const_in(SceneView) scene, const_in(Surface) s, vec3 direction) {
    Frame frame = shading_frame(scene, s, -direction);
    Bsdf bsdf = surface_bsdf(scene, s, 1.0f);
    vec3 wo = to_local(frame, -direction);
    vec3 light = surface_emission(scene, s) + bsdf_albedo(bsdf, wo) * scatter_sky(scene, frame.z);
    return ScatterSurface(s, frame, bsdf, wo, light);
}

// What a light gives to the surface if nothing is in its way; 0 where it is behind it.
FN vec3 scatter_surface_light(const_in(ScatterSurface) seen, const_in(Arrival) a) {
    vec3 wi = to_local(seen.frame, a.direction);
    float side = dot(to_world(seen.frame, seen.wo), seen.surface.geometric_normal);
    if (!(wi.z > 0.0f) || !(dot(a.direction, seen.surface.geometric_normal) * side > 0.0f)) return vec3(0.0f);
    return bsdf_eval(seen.bsdf, seen.wo, wi) * a.value;
}

FN PixelSample scatter_sample(const_in(ScatterState) state) {
    return PixelSample(state.radiance, FirstHit(vec3(0.0f), 0.0f, vec3(0.0f), NONE), state.bound_reached);
}

FN PixelSample scatter_sample_of(const_in(SceneView) scene, const_in(ScatterState) state,
                                 const_in(ScatterSurface) seen) {
    return PixelSample(state.radiance + state.transmitted * seen.light,
                       FirstHit(seen.frame.z, state.travelled, bsdf_albedo(seen.bsdf, seen.wo),
                                scene.instances.at[seen.surface.instance].object),
                       state.bound_reached);
}

FN PixelSample single_scatter(const_in(SceneView) scene, const_in(MarchSettings) settings, Ray ray, Inside inside,
                              Hit hit, Sampler numbers) {
    ScatterState state = scatter_begin(settings, ray, inside, numbers);
    for (uint i = 0u; i < MAX_SCATTER_SEGMENTS; ++i) {
        scatter_march(scene, settings, hit.t, state);
        if (!is_hit(hit)) {
            state.radiance += state.transmitted * environment_radiance(scene, state.ray.direction);
            return scatter_sample(state);
        }
        Surface s;
        if (scatter_cross(scene, hit, state, s)) {
            ScatterSurface seen = scatter_surface(scene, s, state.ray.direction);
            for (uint k = 0u; k < scene.light_count; ++k) {
                RECORD(Light) light = scene.lights.at[k];
                if (!single_scatter_light(light.kind)) continue;
                Arrival a = light_arrival(settings, light, s.position);
                float start = settings.jitter != 0u ? sampler_1d(numbers) : 0.5f;
                vec3 given = scatter_surface_light(seen, a);
                if (is_black(given)) continue;
                seen.light += given * march_shadow(scene, leave_surface(scene, s, a.direction), a.direction, a.distance,
                                                   state.inside, settings.surface_shadow_step,
                                                   settings.surface_shadow_reach, start, state.bound_reached);
            }
            return scatter_sample_of(scene, state, seen);
        }
        hit = trace_closest(scene, state.ray, TRACE_ALL);
    }
    state.bound_reached = true;
    return scatter_sample(state);
}

KERNELS_END
#endif
