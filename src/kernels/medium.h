#ifndef SPINEL_KERNELS_MEDIUM_H
#define SPINEL_KERNELS_MEDIUM_H
// Light in participating media: free flight by null collisions against majorants, transmittance by ratio tracking, and
// the bookkeeping of spectral multiple importance sampling over the three colour channels.
//
//   Novák, Selle, Jarosz, "Residual Ratio Tracking for Estimating Attenuation in Participating Media", 2014
//   Kutz, Habel, Li, Novák, "Spectral and Decomposition Tracking for Rendering Heterogeneous Volumes", 2017
//   Miller, Georgiev, Jarosz, "A Null-Scattering Path Integral Formulation of Light Transport", 2019
//
// A path picks one hero channel, whose extinction drives every random distance. Throughput and the path densities of
// all three channels are kept relative to the hero's density:
//   throughput  f_i / p_hero          radiance carried by channel i
//   r_path      p_i / p_hero          density, had channel i been the hero
//   r_light     the same for the path whose last vertex was chosen by light sampling
// A contribution is throughput·Le / mean(r_path + r_light): the balance heuristic over channels and strategies.
#include "grey_medium.h"
#include "interior.h"
KERNELS_BEGIN

// Walks the coarse majorant cells of one medium along a ray by 3D-DDA (Amanatides and Woo 1987); t in world units.
struct MajorantWalk {
    float majorant;  // bounds of the density from the current t to t_next
    float minorant;
    float t_next;
    float t_leave;  // of the grid's box
    vec3 t_cross;   // where the next cell boundary lies on each axis
    vec3 t_delta;
    ivec3 cell;
    ivec3 step;
    bool before_grid;  // still in the empty space in front of it
};

FN void majorant_load(const_in(SceneView) scene, const_in(Medium) m, inout(MajorantWalk) w) {
    uint index = uint(w.cell.x) + uint(m.majorant_size.x) * (uint(w.cell.y) + uint(m.majorant_size.y) * uint(w.cell.z));
    w.majorant = scene.floats.at[m.majorant_first + index];
    w.minorant = scene.floats.at[m.minorant_first + index];
    w.t_next = min(min(w.t_cross.x, min(w.t_cross.y, w.t_cross.z)), w.t_leave);
}

FN MajorantWalk majorant_begin(const_in(SceneView) scene, const_in(Medium) m, vec3 origin, vec3 direction,
                               float t_max) {
    MajorantWalk w = MajorantWalk(1.0f, 1.0f, t_max, t_max, vec3(t_max), vec3(0.0f), ivec3(0), ivec3(0), false);
    if (m.grid == NONE) return w;
    RECORD(DensityGrid) grid = scene.grids.at[m.grid];
    vec3 o = m.world_to_grid * vec4(origin, 1.0f);
    vec3 d = m.world_to_grid * vec4(direction, 0.0f);
    float t0 = 0.0f;
    float t1 = t_max;
    for (int a = 0; a < 3; ++a) {
        float extent = float(grid.size[a]);
        if (d[a] == 0.0f) {
            if (o[a] < 0.0f || o[a] >= extent) t1 = -1.0f;
        } else {
            float near_t = (0.0f - o[a]) / d[a];
            float far_t = (extent - o[a]) / d[a];
            t0 = max(t0, min(near_t, far_t));
            t1 = min(t1, max(near_t, far_t));
        }
    }
    if (!(t0 < t1)) {
        w.majorant = 0.0f;
        w.minorant = 0.0f;
        w.t_leave = -1.0f;
        return w;
    }
    w.t_leave = t1;
    float edge = m.majorant_cell;
    vec3 p = o + t0 * d;
    for (int a = 0; a < 3; ++a) {
        w.cell[a] = clamp(int(floor(p[a] / edge)), 0, m.majorant_size[a] - 1);
        if (d[a] > 0.0f) {
            w.step[a] = 1;
            w.t_cross[a] = (float(w.cell[a] + 1) * edge - o[a]) / d[a];
            w.t_delta[a] = edge / d[a];
        } else if (d[a] < 0.0f) {
            w.step[a] = -1;
            w.t_cross[a] = (float(w.cell[a]) * edge - o[a]) / d[a];
            w.t_delta[a] = -edge / d[a];
        } else {
            w.step[a] = 0;
            w.t_cross[a] = INFINITE;
            w.t_delta[a] = 0.0f;
        }
    }
    if (t0 > 0.0f) {  // empty space in front of the grid is a cell of its own
        w.majorant = 0.0f;
        w.minorant = 0.0f;
        w.t_next = t0;
        w.before_grid = true;
        return w;
    }
    majorant_load(scene, m, w);
    return w;
}

FN void majorant_advance(const_in(SceneView) scene, const_in(Medium) m, float t_max, inout(MajorantWalk) w) {
    if (m.grid == NONE || w.t_next >= w.t_leave) {  // behind the grid
        w.majorant = m.grid == NONE ? 1.0f : 0.0f;
        w.minorant = w.majorant;
        w.t_next = t_max;
        w.t_leave = -1.0f;
        return;
    }
    if (w.before_grid) {
        w.before_grid = false;
    } else if (w.t_cross.x <= w.t_cross.y && w.t_cross.x <= w.t_cross.z) {
        w.cell.x += w.step.x;
        w.t_cross.x += w.t_delta.x;
    } else if (w.t_cross.y <= w.t_cross.z) {
        w.cell.y += w.step.y;
        w.t_cross.y += w.t_delta.y;
    } else {
        w.cell.z += w.step.z;
        w.t_cross.z += w.t_delta.z;
    }
    if (w.cell.x < 0 || w.cell.y < 0 || w.cell.z < 0 || w.cell.x >= m.majorant_size.x ||
        w.cell.y >= m.majorant_size.y || w.cell.z >= m.majorant_size.z) {
        w.majorant = 0.0f;
        w.minorant = 0.0f;
        w.t_next = t_max;
        w.t_leave = -1.0f;
        return;
    }
    majorant_load(scene, m, w);
}

// All active media side by side: from t to t_next their extinction is bounded by `majorant`.
struct MediaWalk {
    MajorantWalk walks[8];  // of ActiveMedia::ids
    vec3 majorant;
    vec3 control;  // extinction that shadow rays take in closed form
    uint transmittance;
    float t;
    float t_next;
};

FN void media_walk_bound(const_in(SceneView) scene, const_in(ActiveMedia) media, float t_max, inout(MediaWalk) w) {
    w.majorant = vec3(0.0f);
    w.control = vec3(0.0f);
    w.t_next = t_max;
    for (uint i = 0u; i < media.count; ++i) {
        RECORD(Medium) m = scene.media.at[media.ids[i]];
        vec3 extinction = m.scattering + m.absorption;
        if (media.homogeneous) w.control += extinction;
        else if (w.transmittance == TRANSMITTANCE_RESIDUAL) w.control += w.walks[i].minorant * extinction;
        if (!media.homogeneous) extinction = max(extinction, vec3(m.emission_rate));
        w.majorant += w.walks[i].majorant * extinction;
        w.t_next = min(w.t_next, w.walks[i].t_next);
    }
}

FN MediaWalk media_walk_begin(const_in(SceneView) scene, const_in(ActiveMedia) media, vec3 origin, vec3 direction,
                              float t_max, uint transmittance) {
    MediaWalk w;
    w.transmittance = transmittance;
    w.t = 0.0f;
    for (uint i = 0u; i < media.count; ++i)
        w.walks[i] = majorant_begin(scene, scene.media.at[media.ids[i]], origin, direction, t_max);
    media_walk_bound(scene, media, t_max, w);
    return w;
}

FN void media_walk_advance(const_in(SceneView) scene, const_in(ActiveMedia) media, float t_max, inout(MediaWalk) w) {
    w.t = w.t_next;
    for (uint i = 0u; i < media.count; ++i)
        if (w.walks[i].t_next <= w.t) majorant_advance(scene, scene.media.at[media.ids[i]], t_max, w.walks[i]);
    media_walk_bound(scene, media, t_max, w);
}

// What is at a point: coefficients summed over the overlapping media.
struct MediumPoint {
    vec3 scattering;
    vec3 absorption;
    vec3 emission;
};

FN MediumPoint media_at(const_in(SceneView) scene, const_in(ActiveMedia) media, vec3 p) {
    MediumPoint point = MediumPoint(vec3(0.0f), vec3(0.0f), vec3(0.0f));
    for (uint i = 0u; i < media.count; ++i) {
        RECORD(Medium) m = scene.media.at[media.ids[i]];
        float density = medium_density(scene, m, p);
        if (density == 0.0f) continue;
        vec3 scattering = medium_scattering(scene, m, p);
        point.scattering += density * scattering;
        point.absorption += density * (m.absorption + (m.scattering - scattering));
        point.emission += density * medium_emission(scene, m, p);
    }
    return point;
}

// One of the overlapping media in proportion to its share of the scattering at p: its phase function and its σs then
// stand for all, the σs divided by the chance of the pick.
struct MediumPick {
    uint medium;
    vec3 scattering;
};

FN MediumPick pick_scattering_medium(const_in(SceneView) scene, const_in(ActiveMedia) media, vec3 p, vec3 scattering,
                                     float u) {
    if (media.count == 1u) return MediumPick(media.ids[0], scattering);
    float total = 0.0f;
    for (uint i = 0u; i < media.count; ++i) {
        RECORD(Medium) m = scene.media.at[media.ids[i]];
        total += medium_density(scene, m, p) * average(medium_scattering(scene, m, p));
    }
    float remaining = u * total;
    MediumPick pick = MediumPick(media.ids[0], vec3(0.0f));
    for (uint i = 0u; i < media.count; ++i) {
        RECORD(Medium) m = scene.media.at[media.ids[i]];
        float density = medium_density(scene, m, p);
        vec3 here = medium_scattering(scene, m, p);
        float share = density * average(here);
        if (share > 0.0f) pick = MediumPick(media.ids[i], density * here * (total / share));
        remaining -= share;
        if (remaining < 0.0f) break;
    }
    return pick;
}

// Transmittance through a majorant, relative to that of the hero channel, whose density it cancels against.
FN vec3 relative_transmittance(vec3 majorant, float way, uint hero) {
    vec3 difference = majorant - component(majorant, hero);
    return is_black(difference) ? vec3(1.0f) : exp(-difference * way);
}

// What homogeneous media send along a segment, their own attenuation included: ∫ ε exp(−σt s) ds.
FN vec3 homogeneous_emission(const_in(SceneView) scene, const_in(ActiveMedia) media, float t_max) {
    vec3 emission = vec3(0.0f);
    vec3 extinction = media.absorption;
    for (uint i = 0u; i < media.count; ++i) {
        RECORD(Medium) m = scene.media.at[media.ids[i]];
        emission += m.emission;
        extinction += m.scattering + m.absorption;
    }
    vec3 tau = extinction * t_max;
    vec3 total = vec3(0.0f);
    for (int c = 0; c < 3; ++c)  // (1 − e^−τ) / τ, by its series where the difference would cancel
        total[c] = emission[c] * t_max * (tau[c] < 1.0e-3f ? 1.0f - 0.5f * tau[c] : (1.0f - exp(-tau[c])) / tau[c]);
    return total;
}

// Follows the segment (0, t_max) of a ray with unit direction: the first real collision, or passage. Weights are
// updated for either; a collision multiplies by σs, so that absorption never ends a path by chance. r_light then has
// the density of attenuate() as far as the end or the collision.
FN MediumEvent sample_media(const_in(SceneView) scene, const_in(ActiveMedia) media, vec3 origin, vec3 direction,
                            float t_max, float u, uint transmittance, inout(SpectralWeights) w, inout(Rng) rng) {
    if (media.count == 1u && is_grey(scene.media.at[media.ids[0]]) && is_black(media.absorption))
        return sample_grey_medium(scene, media.ids[0], origin, direction, t_max, u, transmittance, w, rng);
    MediumEvent event = MediumEvent(false, t_max, NONE, vec3(0.0f), false);
    if (media.count == 0u) {
        if (!is_black(media.absorption)) w.throughput *= exp(-media.absorption * t_max);
        return event;
    }
    if (media.emissive && media.homogeneous)
        event.emitted = homogeneous_emission(scene, media, t_max) * w.throughput / average(w.r_path);
    MediaWalk walk = media_walk_begin(scene, media, origin, direction, t_max, transmittance);
    float t = 0.0f;
    uint iteration = 0u;
    for (; iteration < MAX_MEDIUM_STEPS; ++iteration) {
        float bound = component(walk.majorant, w.hero);
        float step = bound > 0.0f ? -log(1.0f - rng_1d(rng)) / bound : INFINITE;
        if (!(t + step < walk.t_next)) {  // no collision up to the end of the cell
            if (walk.t_next > t && !is_black(walk.majorant)) {
                vec3 passed = relative_transmittance(walk.majorant, walk.t_next - t, w.hero);
                w.throughput *= passed;
                w.r_path *= passed;
                w.r_light *=
                    exp(min((walk.control + component(walk.majorant, w.hero) - walk.majorant) * (walk.t_next - t),
                            vec3(MOST_CONTROLLED)));
            }
            t = walk.t_next;
            if (t >= t_max) break;
            media_walk_advance(scene, media, t_max, walk);
            continue;
        }
        t += step;
        vec3 passed = relative_transmittance(walk.majorant, step, w.hero);
        vec3 position = origin + t * direction;
        MediumPoint point = media_at(scene, media, position);
        vec3 extinction = min(point.scattering + point.absorption, walk.majorant);
        if (media.emissive && !media.homogeneous && !is_black(point.emission)) {
            vec3 r = w.r_path * passed * walk.majorant;
            event.emitted += w.throughput * exp(-media.absorption * t) * passed * point.emission / average(r);
        }
        float p_real = component(extinction, w.hero) / bound;
        if (rng_1d(rng) < p_real) {
            float p = bound * p_real;
            MediumPick pick = pick_scattering_medium(scene, media, position, point.scattering, rng_1d(rng));
            w.throughput *= passed * pick.scattering / p;
            w.r_path *= passed * extinction / p;
            w.r_light *= exp(min((walk.control + bound - walk.majorant) * step, vec3(MOST_CONTROLLED))) / p;
            event.scattered = true;
            event.t = t;
            event.medium = pick.medium;
            break;
        }
        vec3 null_collision = walk.majorant - extinction;
        float p = bound - component(extinction, w.hero);
        if (!(p > 0.0f)) {
            w.throughput = vec3(0.0f);
            break;
        }
        w.throughput *= passed * null_collision / p;
        w.r_path *= passed * null_collision / p;
        w.r_light *= passed *
                     (transmittance == TRANSMITTANCE_DELTA
                          ? null_collision
                          : exp(min(walk.control * step, vec3(MOST_CONTROLLED))) * (walk.majorant - walk.control)) /
                     p;
    }
    event.bound_reached = iteration >= MAX_MEDIUM_STEPS;
    if (!is_black(media.absorption)) w.throughput *= exp(-media.absorption * event.t);
    return event;
}

// Transmittance of the segment (0, t_max) for a shadow ray: throughput is multiplied by it, r_path by the density with
// which a free flight would have passed, r_light by that of this very estimate. Begin with all weights 1.
// Returns whether a safety bound was reached.
FN bool attenuate(const_in(SceneView) scene, const_in(ActiveMedia) media, vec3 origin, vec3 direction, float t_max,
                  uint transmittance, inout(SpectralWeights) w, inout(Rng) rng) {
    if (!is_black(media.absorption)) w.throughput *= exp(-media.absorption * t_max);
    if (media.count == 0u) return false;
    if (media.homogeneous) {
        vec3 extinction = vec3(0.0f);
        for (uint i = 0u; i < media.count; ++i) {
            RECORD(Medium) m = scene.media.at[media.ids[i]];
            extinction += m.scattering + m.absorption;
        }
        vec3 transmittance = exp(-extinction * t_max);
        w.throughput *= transmittance;
        w.r_path *= transmittance;
        return false;
    }
    if (media.count == 1u && is_grey(scene.media.at[media.ids[0]]))
        return attenuate_grey_medium(scene, media.ids[0], origin, direction, t_max, transmittance, w, rng);
    MediaWalk walk = media_walk_begin(scene, media, origin, direction, t_max, transmittance);
    float t = 0.0f;
    for (uint iteration = 0u; iteration < MAX_MEDIUM_STEPS; ++iteration) {
        vec3 rates = walk.majorant - walk.control;  // of collisions, in each channel
        float rate = max(component(rates, w.hero), 0.0f);
        float step = rate > 0.0f ? exponential(rng_1d(rng)) / rate : INFINITE;
        bool passes = !(t + step < walk.t_next);
        if (passes) step = walk.t_next - t;
        if (step > 0.0f && !is_black(walk.majorant)) {
            vec3 passed = exp((rate - walk.majorant) * step);
            w.throughput *= passed;
            w.r_path *= passed;
            w.r_light *= exp((rate - rates) * step);
        }
        if (passes) {
            t = walk.t_next;
            if (t >= t_max) return false;
            media_walk_advance(scene, media, t_max, walk);
            continue;
        }
        t += step;
        MediumPoint point = media_at(scene, media, origin + t * direction);
        vec3 null_collision = max(walk.majorant - point.scattering - point.absorption, vec3(0.0f));
        if (transmittance == TRANSMITTANCE_DELTA) {
            float p = component(null_collision, w.hero);
            if (!(rng_1d(rng) * rate < p)) {
                w.throughput = vec3(0.0f);
                return false;
            }
            w.throughput *= null_collision / p;
            w.r_path *= null_collision / p;
            w.r_light *= null_collision / p;
            continue;
        }
        w.throughput *= null_collision / rate;
        w.r_path *= null_collision / rate;
        w.r_light *= rates / rate;
        if (is_black(w.throughput)) return false;
        // Russian roulette on what is left keeps dense clouds cheap.
        float left = max_component(w.throughput) / average(w.r_path + w.r_light);
        if (left < SHADOW_ROULETTE) {
            float survive = left / SHADOW_ROULETTE;
            if (!(rng_1d(rng) < survive)) {
                w.throughput = vec3(0.0f);
                return false;
            }
            w.throughput /= survive;
        }
    }
    w.throughput = vec3(0.0f);
    return true;
}

KERNELS_END
#endif
