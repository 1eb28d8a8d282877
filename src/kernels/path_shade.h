#ifndef SPINEL_KERNELS_PATH_SHADE_H
#define SPINEL_KERNELS_PATH_SHADE_H
// The stage of a path at the end of its ray: a collision in a medium before the surface, or the surface. Emission,
// next-event estimation, a new direction.
#include "boundary.h"
#include "equiangular.h"
#include "medium.h"
#include "path_state.h"
#include "phase.h"
#include "surface.h"
KERNELS_BEGIN

// `beside`: relative density with which path_beside() would have come as far, but for the choice of a place.
FN Connection scatter_in_medium(const_in(SceneView) scene, const_in(PathSettings) settings, inout(PathState) state,
                                const_in(MediumEvent) event, float t_max, vec3 beside) {
    Connection c = no_connection(state);
    if (!next_bounce(settings, state)) return c;
    state.flags |= PATH_FIRST_SEEN;  // the first thing seen is no surface
    vec3 p = ray_at(state.ray, event.t);
    vec3 d = state.ray.direction;
    float g = scene.media.at[event.medium].g;
    vec2 u_light = sampler_2d(state.numbers);
    vec2 u_point = sampler_2d(state.numbers);
    vec2 u_phase = sampler_2d(state.numbers);
    LightSample light = sample_light(scene, p, u_light.x, u_light.y, u_point);
    if (light.pdf > 0.0f) {
        float phase = phase_eval(g, dot(d, light.direction));
        c = connection_to(state, light, p, vec3(phase), phase);
        if (settings.equiangular != 0u && light.delta && !light.infinite)
            c.r_light +=
                beside *
                (light.pdf * equiangular_pdf(equiangular_begin(state.ray.origin, d, t_max, light.point), event.t));
    }
    PhaseSample next = phase_sample(g, d, u_phase);
    state.weights.r_light = state.weights.r_path / next.pdf;
    state.ray = Ray(p, 0.0f, next.direction, INFINITE);
    state.vertex = p;
    state.flags &= ~PATH_SPECULAR;
    russian_roulette(settings, state);
    return c;
}

// Goes on behind a surface that does not scatter.
FN void cross_surface(const_in(SceneView) scene, const_in(Surface) s, inout(PathState) state) {
    state.ray = Ray(leave_surface(scene, s, state.ray.direction), 0.0f, state.ray.direction, INFINITE);
}

// A sample of the one or the other half of a BSDF that has a delta lobe, in place of either by chance.
FN BsdfSample half_of_bsdf(const_in(Bsdf) bsdf, vec3 wo, float u_lobe, vec2 u, inout(uint) flags) {
    BsdfSample mirror = bsdf_sample(bsdf, wo, 0.0f, u);  // such a lobe is the first that is chosen from
    if ((mirror.flags & LOBE_DELTA) == 0u) return bsdf_sample(bsdf, wo, u_lobe, u);
    float p = mirror.pdf;
    if ((flags & PATH_TAKES_MIRROR) != 0u) {
        flags |= PATH_FORKED;
        mirror.weight *= p;
        return mirror;
    }
    if (p >= 1.0f) return bsdf_failed();
    BsdfSample rest = bsdf_sample(bsdf, wo, clamp(mix(p, 1.0f, u_lobe), p, ONE_MINUS_EPSILON), u);
    rest.weight *= 1.0f - p;  // densities stay those of all lobes together: so MIS goes on as it does
    return rest;
}

FN Connection path_shade(const_in(SceneView) scene, const_in(PathSettings) settings, inout(PathState) state,
                         const_in(Hit) hit) {
    Connection c = no_connection(state);
    state.segments += 1u;
    if (state.segments >= MAX_PATH_SEGMENTS) {
        state.flags |= PATH_BOUND_REACHED;
        path_end(state);
        return c;
    }
    if (state.inside.count > 0u) {
        ActiveMedia media = active_media(scene, state.inside);
        if (media.count > 0u || !is_black(media.absorption)) {
            float u = state.bounces < WELL_PLACED_BOUNCES ? sampler_1d(state.numbers) : rng_1d(state.rng);
            vec3 r_path = state.weights.r_path;
            vec3 r_light = state.weights.r_light;
            state.weights.r_light = vec3(1.0f);
            MediumEvent event = sample_media(scene, media, state.ray.origin, state.ray.direction, hit.t, u,
                                             settings.transmittance, state.weights, state.rng);
            state.radiance += event.emitted;
            if (event.bound_reached) state.flags |= PATH_BOUND_REACHED;
            if (is_black(state.weights.throughput)) {
                path_end(state);
                return c;
            }
            if (event.scattered)
                return scatter_in_medium(scene, settings, state, event, hit.t, r_path * state.weights.r_light);
            state.weights.r_light *= r_light;
        }
    }
    if (!is_hit(hit)) {
        gather_infinite(scene, settings, state);
        path_end(state);
        return c;
    }
    state.segments += SURFACE_SEGMENTS - 1u;
    Surface s = surface_at(scene, state.ray, hit);
    float opacity = surface_opacity(scene, s);
    bool stopped = false;  // by a surface of opacity < 1
    float n_ratio = 1.0f;
    Inside after = state.inside;
    if (s.leaves != NONE || s.enters != NONE || (s.contact && opacity < 1.0f)) {
        Surface under = s;
        after = cross_boundary(scene, state.ray.direction, TRACE_ALL, s, under, state.inside);
        if (s.contact) opacity = surface_opacity(scene, s);
        if (under.instance != NONE && under.instance != s.instance && opacity < 1.0f &&
            what_meets(scene, under) == MEETS_DIELECTRIC) {
            if (rng_1d(state.rng) < opacity) {
                stopped = true;
            } else {
                state.weights.r_light /= 1.0f - opacity;
                s = under;
                opacity = surface_opacity(scene, s);
            }
        }
        if (after.dropped > 0u) state.flags |= PATH_BOUND_REACHED;
        uint from = inside_dielectric(scene, state.inside);
        uint to = inside_dielectric(scene, after);
        if (s.material != NONE && from == to && scene.materials.at[s.material].kind == MATERIAL_DIELECTRIC) {
            // Hidden in a dielectric of higher priority. Shadow rays stop at dielectrics, hidden or not.
            state.flags |= PATH_SPECULAR;
            state.inside = after;
            cross_surface(scene, s, state);
            return c;
        }
        n_ratio = interior_ior(scene, to) / interior_ior(scene, from);
    }
    if (!stopped && opacity < 1.0f && (opacity <= 0.0f || rng_1d(state.rng) >= opacity)) {
        state.weights.r_light /= 1.0f - opacity;  // a shadow ray multiplies by this instead of trying its luck
        state.inside = after;
        cross_surface(scene, s, state);
        return c;
    }

    vec3 wo = -state.ray.direction;
    uint light_index = light_of_primitive(scene, scene.instances.at[s.instance], s.light_key);
    vec3 emission = surface_emission(scene, s);
    if (!is_black(emission)) {
        // That the path met the emitter at all had the chance `opacity`; light sampling does not depend on it.
        float pdf =
            light_pdf(scene, light_index, state.vertex, state.ray.direction, distance(state.vertex, s.position));
        gather(settings, state, emission, pdf / opacity);
    }

    Frame frame = shading_frame(scene, s, wo);
    Bsdf bsdf = surface_bsdf(scene, s, n_ratio);
    vec3 wo_local = to_local(frame, wo);
    if ((state.flags & PATH_FIRST_SEEN) == 0u) {
        state.flags |= PATH_FIRST_SEEN;
        state.first = FirstHit(frame.z, distance(state.vertex, s.position), bsdf_albedo(bsdf, wo_local),
                               scene.instances.at[s.instance].object);
    }
    if (!next_bounce(settings, state)) return c;

    float wo_side = dot(wo, s.geometric_normal);
    vec2 u_choice = sampler_2d(state.numbers);  // of a light, of a lobe
    vec2 u_point = sampler_2d(state.numbers);
    vec2 u_bsdf = sampler_2d(state.numbers);
    if (!bsdf_is_delta(bsdf)) {
        LightSample light = sample_light(scene, s.position, u_choice.x, rng_1d(state.rng), u_point);
        if (light.pdf > 0.0f) {
            vec3 wi = to_local(frame, light.direction);
            // Shading and geometric normal must agree on which side the light is.
            if ((wi.z > 0.0f) == (dot(light.direction, s.geometric_normal) * wo_side > 0.0f)) {
                vec4 f = bsdf_eval_pdf(bsdf, wo_local, wi);
                c = connection_to(state, light, leave_surface(scene, s, light.direction), vec3(f.x, f.y, f.z), f.w);
                if (wi.z < 0.0f) c.inside = after;
            }
        }
    }
    BsdfSample next;
    if ((state.flags & (PATH_TAKES_MIRROR | PATH_LEAVES_MIRROR)) == 0u)
        next = bsdf_sample(bsdf, wo_local, u_choice.y, u_bsdf);
    else next = half_of_bsdf(bsdf, wo_local, u_choice.y, u_bsdf, state.flags);
    vec3 direction = to_world(frame, next.direction);
    if ((next.flags & LOBE_FAILED) != 0u || is_black(next.weight) ||
        (next.direction.z > 0.0f) != (dot(direction, s.geometric_normal) * wo_side > 0.0f)) {
        path_end(state);
        return c;
    }
    direction = normalize(direction);
    state.weights.throughput *= next.weight;
    if ((next.flags & LOBE_DELTA) != 0u) {
        state.flags |= PATH_SPECULAR;
    } else {
        state.flags &= ~PATH_SPECULAR;
        state.weights.r_light = state.weights.r_path / next.pdf;
    }
    if ((next.flags & LOBE_TRANSMISSION) != 0u) {
        state.inside = after;
        state.eta_scale *= n_ratio * n_ratio;
    }
    state.ray = Ray(leave_surface(scene, s, direction), 0.0f, direction, INFINITE);
    state.vertex = s.position;
    russian_roulette(settings, state);
    return c;
}

KERNELS_END
#endif
