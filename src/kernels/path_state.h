#ifndef SPINEL_KERNELS_PATH_STATE_H
#define SPINEL_KERNELS_PATH_STATE_H
// What a path knows, how it begins, and what its stages share: emission that it meets by chance, the shadow ray that
// light sampling asks for, and how it ends.
#include "camera.h"
#include "device.h"
#include "environment.h"
#include "interior.h"
#include "light.h"
#include "locate.h"
#include "path_settings.h"
#include "pixel_sample.h"
#include "random.h"
#include "spectral_weights.h"
KERNELS_BEGIN

// Of one path, a safety bound, counted: collisions in media, and surfaces as so many of them. A white cloud of an
// optical depth of a thousand scatters light some 10⁵ times and must keep it; between perfect mirrors it may end
// sooner.
const uint MAX_PATH_SEGMENTS = 1u << 22u;
const uint SURFACE_SEGMENTS = 64u;

const int WELL_PLACED_BOUNCES = 4;  // as many collisions of a path are placed by the sampler, not by chance

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

KERNELS_END
#endif
