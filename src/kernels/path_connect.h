#ifndef SPINEL_KERNELS_PATH_CONNECT_H
#define SPINEL_KERNELS_PATH_CONNECT_H
// Shadow rays of a path: what is left of a connection's light behind media and interfaces, and the second way to light
// that media scatter, beside the path's own collisions.
#include "boundary.h"
#include "equiangular.h"
#include "medium.h"
#include "path_state.h"
#include "phase.h"
#include "surface.h"
KERNELS_BEGIN

const uint MAX_SHADOW_SEGMENTS = 4096u;  // interfaces crossed by one shadow ray

// Of the random numbers of path_beside(): beyond those of all connections.
const uint SALT_BESIDE = 0x80000000u;

// What a connection brings home that nothing stops for sure.
FN vec3 path_connect(const_in(SceneView) scene, const_in(PathSettings) settings, inout(PathState) state, Connection c) {
    SpectralWeights w = SpectralWeights(vec3(1.0f), vec3(1.0f), vec3(1.0f), state.weights.hero);
    if (c.inside.count > 0u || scene.pass_through_count > 0u) {
        Ray ray = c.ray;
        Rng rng = make_rng(state.numbers, c.salt);
        float stretch = length(ray.direction);
        vec3 direction = ray.direction / stretch;
        bool arrived = false;
        for (uint i = 0u; i < MAX_SHADOW_SEGMENTS && !arrived; ++i) {
            Hit hit = no_hit(ray.t_max);
            if (scene.pass_through_count > 0u) hit = trace_closest(scene, ray, TRACE_PASS_THROUGH);
            if (c.inside.count > 0u) {
                float way = hit.t == INFINITE ? INFINITE : hit.t * stretch;
                if (attenuate(scene, active_media(scene, c.inside), ray.origin, direction, way, settings.transmittance,
                              w, rng))
                    state.flags |= PATH_BOUND_REACHED;
            }
            if (is_black(w.throughput)) return vec3(0.0f);
            if (!is_hit(hit)) {
                arrived = true;
                continue;
            }
            Surface s = surface_at(scene, ray, hit);
            Surface under = s;
            Inside behind = cross_boundary(scene, direction, TRACE_PASS_THROUGH, s, under, c.inside);
            c.inside = behind;
            if (behind.dropped > 0u) state.flags |= PATH_BOUND_REACHED;
            float clear = 1.0f - surface_opacity(scene, s);
            if (!(clear > 0.0f)) return vec3(0.0f);
            w.throughput *= clear;
            w.r_path *= clear;
            vec3 end = ray_at(ray, ray.t_max);
            ray.origin = leave_surface(scene, s, direction);
            if (ray.t_max != INFINITE) {
                ray.direction = end - ray.origin;
                arrived = dot(ray.direction, direction) <= 0.0f;
                stretch = length(ray.direction);
            }
        }
        if (!arrived) {  // too many interfaces: taken as a shadow, and counted
            state.flags |= PATH_BOUND_REACHED;
            return vec3(0.0f);
        }
    }
    float density = average(c.r_light * w.r_light + c.r_path * w.r_path);
    return density > 0.0f ? c.value * w.throughput / density : vec3(0.0f);
}

// Light from points that the media up to `hit` scatter into the ray, looked for where the light is strong: a second way
// to what path_shade() finds by a collision and light sampling, which counts it in (scatter_in_medium).
FN void path_beside(const_in(SceneView) scene, const_in(PathSettings) settings, inout(PathState) state,
                    const_in(Hit) hit) {
    if (settings.equiangular == 0u || state.inside.count == 0u || !has_point_lights(scene)) return;
    if (settings.max_bounces >= 0 && state.bounces >= settings.max_bounces) return;
    ActiveMedia media = active_media(scene, state.inside);
    if (media.count == 0u) return;
    uint salt = SALT_BESIDE + 2u * state.segments;
    Rng rng = make_rng(state.numbers, salt);
    vec2 u = state.bounces < WELL_PLACED_BOUNCES ? sampler_2d(state.numbers) : vec2(rng_1d(rng), rng_1d(rng));
    uint index = pick_light(scene, u.x, rng_1d(rng));
    if (!is_point_light(scene.lights.at[index])) return;
    vec3 o = state.ray.origin;
    vec3 d = state.ray.direction;
    Equiangular places = equiangular_begin(o, d, hit.t, scene.lights.at[index].position);
    float t = equiangular_sample(places, u.y);
    if (!(t > 0.0f && t < hit.t)) return;
    vec3 p = o + t * d;
    LightSample light = sample_one_light(scene, index, p, vec2(0.0f));
    if (!(light.pdf > 0.0f)) return;
    MediumPoint point = media_at(scene, media, p);
    if (is_black(point.scattering)) return;
    SpectralWeights w = SpectralWeights(vec3(1.0f), vec3(1.0f), vec3(1.0f), state.weights.hero);
    if (attenuate(scene, media, o, d, t, settings.transmittance, w, rng)) state.flags |= PATH_BOUND_REACHED;
    if (is_black(w.throughput)) return;
    MediumPick pick = pick_scattering_medium(scene, media, p, point.scattering, rng_1d(rng));
    float phase = phase_eval(scene.media.at[pick.medium].g, dot(d, light.direction));
    Connection c = connection_to(state, light, p, phase * w.throughput * pick.scattering, 0.0f);
    c.r_light *= w.r_light * equiangular_pdf(places, t) + w.r_path * (point.scattering + point.absorption);
    c.salt = salt + 1u;
    if (c.valid && !trace_occluded(scene, c.ray))
        state.radiance += clamped(settings, state.bounces + 1, path_connect(scene, settings, state, c));
}

KERNELS_END
#endif
