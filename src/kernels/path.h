#ifndef SPINEL_KERNELS_PATH_H
#define SPINEL_KERNELS_PATH_H
// The path tracer as a state machine. A device may run its four stages as one kernel (path_follow below) or as separate
// kernels over queues of states:
//
//   path_generate   a camera ray
//   path_extend     the nearest hit along it
//   path_shade      medium or surface: emission, next-event estimation (asks for a Connection), a new direction
//   path_connect    the shadow ray, through media and past interfaces
//
// Unidirectional path tracing with next-event estimation and multiple importance sampling (Veach 1997, balance
// heuristic in the one-sample form of Miller, Georgiev, Jarosz 2019 so that volumes and colour channels join in; see
// medium.h).
#include "boundary.h"
#include "camera.h"
#include "device.h"
#include "equiangular.h"
#include "locate.h"
#include "medium.h"
#include "path_settings.h"
#include "phase.h"
#include "pixel_sample.h"
#include "surface.h"
KERNELS_BEGIN

// Of one path, a safety bound, counted: collisions in media, and surfaces as so many of them. A white cloud of an
// optical depth of a thousand scatters light some 10⁵ times and must keep it; between perfect mirrors it may end
// sooner.
const uint MAX_PATH_SEGMENTS = 1u << 22u;
const uint SURFACE_SEGMENTS = 64u;
const uint MAX_SHADOW_SEGMENTS = 4096u;  // interfaces crossed by one shadow ray

const int WELL_PLACED_BOUNCES = 4;  // as many collisions of a path are placed by the sampler, not by chance

// Of the random numbers of path_beside(): beyond those of all connections.
const uint SALT_BESIDE = 0x80000000u;

const uint PATH_ALIVE = 1u;
const uint PATH_SPECULAR = 2u;    // the last scattering was a delta: light sampling could not have made it
const uint PATH_FIRST_SEEN = 4u;  // AOVs are recorded
const uint PATH_BOUND_REACHED = 8u;
// For whoever follows both ways where a surface is polished (whitted.h). They are asked for one after the other, of the
// same state:
const uint PATH_TAKES_MIRROR = 16u;   // the lobe that has no width, …
const uint PATH_LEAVES_MIRROR = 32u;  // … and one of the others
const uint PATH_FORKED = 64u;         // there was one

struct PathState {
    Ray ray;
    SpectralWeights weights;
    vec3 radiance;    // gathered
    vec3 vertex;      // last scattering point: light sampling's receiver
    float eta_scale;  // undoes the scaling of radiance by refraction for Russian roulette
    int bounces;
    uint segments;
    uint flags;
    Inside inside;
    Sampler numbers;
    Rng rng;  // for loops without a bound on their draws
    FirstHit first;
};

// A shadow ray that was asked for; value is what it carries if nothing is in the way.
struct Connection {
    bool valid;
    Ray ray;      // its end lies before the light; to infinity, or t_max = 1 with a direction as long as the way
    vec3 value;   // throughput · scattering · radiance
    vec3 r_path;  // relative densities, see medium.h
    vec3 r_light;
    Inside inside;
    uint salt;  // of its own random numbers, so that shadow rays and paths do not wait for each other
};

FN PathState path_generate(const_in(SceneView) scene, const_in(PathSettings) settings, uvec2 pixel, uint index) {
    PathState state;
    state.numbers = make_sampler(pixel, index, settings.seed);
    vec2 u_film = sampler_2d(state.numbers);
    vec2 u_lens = sampler_2d(state.numbers);
    float u_hero = sampler_1d(state.numbers);
    state.ray = camera_ray(scene.camera, pixel, u_film, u_lens);
    state.weights = SpectralWeights(vec3(1.0f), vec3(1.0f), vec3(1.0f), min(uint(u_hero * 3.0f), 2u));
    state.radiance = vec3(0.0f);
    state.vertex = state.ray.origin;
    state.eta_scale = 1.0f;
    state.bounces = 0;
    state.segments = 0u;
    state.flags = PATH_ALIVE | PATH_SPECULAR;
    state.inside = inside_nothing();
    if (scene.camera.locate_rays != 0u) {
        state.inside = interiors_at(scene, state.ray.origin);
        if (state.inside.dropped > 0u) state.flags |= PATH_BOUND_REACHED;
    } else {
        for (uint i = 0u; i < scene.camera_inside_count; ++i)
            inside_enter(state.inside, scene.words.at[scene.camera_inside_first + i]);
    }
    state.rng = make_rng(state.numbers, 0u);
    state.first = FirstHit(vec3(0.0f), 0.0f, vec3(0.0f), NONE);
    return state;
}

FN Hit path_extend(const_in(SceneView) scene, const_in(PathState) state) {
    return trace_closest(scene, state.ray, TRACE_ALL);
}

FN void path_end(inout(PathState) state) { state.flags &= ~PATH_ALIVE; }

// Indirect light of one path is limited where the settings say so: a bias that is asked for.
FN vec3 clamped(const_in(PathSettings) settings, int bounces, vec3 radiance) {
    if (settings.clamp <= 0.0f || bounces < 2) return radiance;
    float most = max_component(radiance);
    return most > settings.clamp ? radiance * (settings.clamp / most) : radiance;
}

// Emission found by following the path: `pdf` is the density with which light sampling would have found it.
FN void gather(const_in(PathSettings) settings, inout(PathState) state, vec3 radiance, float pdf) {
    if (is_black(radiance)) return;
    vec3 densities = state.weights.r_path;
    if ((state.flags & PATH_SPECULAR) == 0u) densities += state.weights.r_light * pdf;
    float density = average(densities);
    if (density > 0.0f)
        state.radiance += clamped(settings, state.bounces, state.weights.throughput * radiance / density);
}

FN void gather_infinite(const_in(SceneView) scene, const_in(PathSettings) settings, inout(PathState) state) {
    vec3 d = state.ray.direction;
    float p = scene.environment.light == NONE ? 0.0f : scene.light_table.at[scene.environment.light].probability;
    gather(settings, state, environment_radiance(scene, d), p > 0.0f ? p * environment_pdf(scene, d) : 0.0f);
    for (uint i = 0u; i < scene.infinite_light_count; ++i) {
        RECORD(Light) light = scene.lights.at[i];
        if (light.kind == LIGHT_DIRECTIONAL && directional_seen(light, d))
            gather(settings, state, light.radiance,
                   scene.light_table.at[i].probability / (2.0f * PI * disc_one_minus_cos(light.radius)));
    }
}

FN Connection no_connection(const_in(PathState) state) {
    return Connection(false, state.ray, vec3(0.0f), vec3(0.0f), vec3(0.0f), state.inside, 0u);
}

// Asks for a shadow ray; scatter is f·|cos| or the phase function, pdf the density of its own sampling of that
// direction.
FN Connection connection_to(const_in(PathState) state, const_in(LightSample) light, vec3 origin, vec3 scatter,
                            float pdf) {
    Connection c = no_connection(state);
    c.valid = !is_black(scatter) && !is_black(light.radiance);
    if (light.infinite) {
        c.ray = Ray(origin, 0.0f, light.direction, INFINITE);
    } else {
        // Both ends are moved off their surfaces, so that neither hides the other, however close or far they are.
        vec3 to = light.point - origin;
        vec3 end = light.point - (dot(to, light.normal) > 0.0f ? light.error : -light.error) * light.normal;
        c.ray = Ray(origin, 0.0f, end - origin, 1.0f);
        if (is_black(c.ray.direction)) c.valid = false;
    }
    c.salt = 1u + state.segments;
    c.value = state.weights.throughput * scatter * light.radiance;
    c.r_light = state.weights.r_path * light.pdf;
    c.r_path = light.delta ? vec3(0.0f) : state.weights.r_path * (pdf * light.opacity);
    return c;
}

// Ends paths that carry little, by what they can still add in the brightest channel; unbiased.
FN void russian_roulette(const_in(PathSettings) settings, inout(PathState) state) {
    if (state.bounces < settings.roulette_start) return;
    float carried = max_component(state.weights.throughput) * state.eta_scale / average(state.weights.r_path);
    if (!(carried < 1.0f)) return;
    // The root: what a path can still find (a caustic, a lamp) may be far brighter than what it has found so far.
    float survive = max(sqrt(carried), 0.05f);
    if (rng_1d(state.rng) >= survive) path_end(state);
    else state.weights.throughput /= survive;
}

// Counts a scattering event. False: that was one too many.
FN bool next_bounce(const_in(PathSettings) settings, inout(PathState) state) {
    if (settings.max_bounces >= 0 && state.bounces >= settings.max_bounces) {
        path_end(state);
        return false;
    }
    state.bounces += 1;
    return true;
}

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

// Shades the hit at the end of a path's ray, and connects.
FN void path_step(const_in(SceneView) scene, const_in(PathSettings) settings, inout(PathState) state,
                  const_in(Hit) hit) {
    Connection c = path_shade(scene, settings, state, hit);
    if (c.valid && !trace_occluded(scene, c.ray))
        state.radiance += clamped(settings, state.bounces, path_connect(scene, settings, state, c));
}

// Follows a path from the hit at the end of its ray to its own end.
FN void path_follow(const_in(SceneView) scene, const_in(PathSettings) settings, inout(PathState) state, Hit hit) {
    for (uint i = 0u; i <= MAX_PATH_SEGMENTS && (state.flags & PATH_ALIVE) != 0u; ++i) {
        if (i > 0u) hit = path_extend(scene, state);
        path_beside(scene, settings, state, hit);
        path_step(scene, settings, state, hit);
    }
}

KERNELS_END
#endif
