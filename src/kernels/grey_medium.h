#ifndef SPINEL_KERNELS_GREY_MEDIUM_H
#define SPINEL_KERNELS_GREY_MEDIUM_H
// The walks of medium.h for what most clouds and smokes are: one medium on a grid, its extinction the same in all three
// channels. Then every channel has the density of the hero, so distances and densities are plain numbers. The ray is
// carried into the grid's space once, and one exponentially distributed optical depth is used up cell by cell until a
// collision, however many cells lie between.
#include "density.h"
#include "path_settings.h"
#include "random.h"
#include "spectral_weights.h"
KERNELS_BEGIN

// The coarse cells along a ray (Amanatides and Woo 1987), in the space of the grid; t in world units.
struct CellWalk {
    vec3 origin;
    vec3 direction;
    float t;        // the cell begins here …
    float t_next;   // … and ends here
    float t_leave;  // end of the grid, or of the segment
    vec3 t_cross;   // where the next boundary lies on each axis
    vec3 t_delta;
    ivec3 left;    // cells still to come on each axis
    ivec3 stride;  // from one cell to the next in the array
    int index;
};

FN CellWalk cell_walk_begin(const_in(Medium) m, const_in(DensityGrid) grid, vec3 origin, vec3 direction, float t_max) {
    CellWalk w;
    w.origin = m.world_to_grid * vec4(origin, 1.0f);
    w.direction = m.world_to_grid * vec4(direction, 0.0f);
    w.t = 0.0f;
    w.t_next = -1.0f;
    w.t_leave = t_max;
    w.index = 0;
    w.t_cross = vec3(INFINITE);
    w.t_delta = vec3(0.0f);
    w.left = ivec3(0);
    w.stride = ivec3(0);
    for (int a = 0; a < 3; ++a) {
        float extent = float(grid.size[a]);
        if (w.direction[a] == 0.0f) {
            if (w.origin[a] < 0.0f || w.origin[a] >= extent) w.t_leave = -1.0f;
        } else {
            float near_t = (0.0f - w.origin[a]) / w.direction[a];
            float far_t = (extent - w.origin[a]) / w.direction[a];
            w.t = max(w.t, min(near_t, far_t));
            w.t_leave = min(w.t_leave, max(near_t, far_t));
        }
    }
    if (!(w.t < w.t_leave)) return w;
    float edge = m.majorant_cell;
    ivec3 size = m.majorant_size;
    ivec3 row = ivec3(1, size.x, size.x * size.y);
    vec3 p = w.origin + w.t * w.direction;
    for (int a = 0; a < 3; ++a) {
        int cell = clamp(int(floor(p[a] / edge)), 0, size[a] - 1);
        w.index += cell * row[a];
        float d = w.direction[a];
        if (d == 0.0f) continue;
        bool up = d > 0.0f;
        w.t_cross[a] = (float(up ? cell + 1 : cell) * edge - w.origin[a]) / d;
        w.t_delta[a] = edge / abs(d);
        w.left[a] = up ? size[a] - 1 - cell : cell;
        w.stride[a] = up ? row[a] : -row[a];
    }
    w.t_next = min(min(w.t_cross.x, min(w.t_cross.y, w.t_cross.z)), w.t_leave);
    return w;
}

// Goes on to the next cell. False: there is none.
FN bool cell_walk_advance(inout(CellWalk) w) {
    w.t = w.t_next;
    if (w.t >= w.t_leave) return false;
    int left;
    if (w.t_cross.x <= w.t_cross.y && w.t_cross.x <= w.t_cross.z) {
        left = w.left.x -= 1;
        w.index += w.stride.x;
        w.t_cross.x += w.t_delta.x;
    } else if (w.t_cross.y <= w.t_cross.z) {
        left = w.left.y -= 1;
        w.index += w.stride.y;
        w.t_cross.y += w.t_delta.y;
    } else {
        left = w.left.z -= 1;
        w.index += w.stride.z;
        w.t_cross.z += w.t_delta.z;
    }
    w.t_next = min(min(w.t_cross.x, min(w.t_cross.y, w.t_cross.z)), w.t_leave);
    return left >= 0;
}

FN bool is_grey(const_in(Medium) m) {
    vec3 extinction = m.scattering + m.absorption;
    return m.grid != NONE && extinction.x == extinction.y && extinction.x == extinction.z;
}

FN float exponential(float u) { return -log(1.0f - u); }

// Density of the cell that residual tracking takes in closed form.
FN float cell_control(const_in(SceneView) scene, const_in(Medium) m, const_in(CellWalk) w, uint transmittance) {
    return transmittance == TRANSMITTANCE_RESIDUAL ? scene.floats.at[m.minorant_first + uint(w.index)] : 0.0f;
}

// As sample_media() of medium.h. `u` is uniform and well distributed: it places the first collision.
FN MediumEvent sample_grey_medium(const_in(SceneView) scene, uint id, vec3 origin, vec3 direction, float t_max, float u,
                                  uint transmittance, inout(SpectralWeights) w, inout(Rng) rng) {
    MediumEvent event = MediumEvent(false, t_max, NONE, vec3(0.0f), false);
    RECORD(Medium) m = scene.media.at[id];
    RECORD(DensityGrid) grid = scene.grids.at[m.grid];
    float extinction = m.scattering.x + m.absorption.x;
    float rate = max(extinction, m.emission_rate);
    bool emissive = !is_black(m.emission);
    CellWalk walk = cell_walk_begin(m, grid, origin, direction, t_max);
    if (!(walk.t_next > walk.t)) return event;
    float depth = exponential(u);
    float light = 1.0f;       // what r_light is multiplied by, …
    float controlled = 0.0f;  // … but for this optical depth, which attenuate_grey_medium() takes in closed form
    uint iteration = 0u;
    for (; iteration < MAX_MEDIUM_STEPS; ++iteration) {
        float bound = rate * scene.floats.at[m.majorant_first + uint(walk.index)];
        float cell_depth = bound * (walk.t_next - walk.t);
        if (depth >= cell_depth) {
            depth -= cell_depth;
            controlled += cell_control(scene, m, walk, transmittance) * (walk.t_next - walk.t);
            if (!cell_walk_advance(walk)) break;
            continue;
        }
        walk.t += depth / bound;
        float control = cell_control(scene, m, walk, transmittance);
        controlled += control * (depth / bound);
        float density = medium_density_in_grid(scene, m, grid, walk.origin + walk.t * walk.direction);
        float real = min(density * extinction, bound);
        if (emissive && density > 0.0f)
            event.emitted += w.throughput * (density * medium_emission(scene, m, origin + walk.t * direction)) /
                             (average(w.r_path) * bound);
        float left = bound - real;
        if (rng_1d(rng) * bound >= left) {
            w.throughput *= medium_scattering(scene, m, origin + walk.t * direction) / extinction;
            event.scattered = true;
            event.t = walk.t;
            event.medium = id;
            light /= real;
            break;
        }
        if (transmittance != TRANSMITTANCE_DELTA) light *= (bound - control * extinction) / left;
        depth = exponential(rng_1d(rng));
    }
    w.r_light *= light * exp(min(controlled * extinction, MOST_CONTROLLED));
    event.bound_reached = iteration >= MAX_MEDIUM_STEPS;
    return event;
}

// As attenuate() of medium.h.
FN bool attenuate_grey_medium(const_in(SceneView) scene, uint id, vec3 origin, vec3 direction, float t_max,
                              uint transmittance, inout(SpectralWeights) w, inout(Rng) rng) {
    RECORD(Medium) m = scene.media.at[id];
    RECORD(DensityGrid) grid = scene.grids.at[m.grid];
    float extinction = m.scattering.x + m.absorption.x;
    float rate = max(extinction, m.emission_rate);  // as above: the same chances of collisions
    CellWalk walk = cell_walk_begin(m, grid, origin, direction, t_max);
    if (!(walk.t_next > walk.t)) return false;
    float depth = exponential(rng_1d(rng));
    float clear = 1.0f;       // transmittance, and the density of a free flight relative to this one, …
    float controlled = 0.0f;  // … but for this optical depth
    float survival = 1.0f;
    uint iteration = 0u;
    for (; iteration < MAX_MEDIUM_STEPS; ++iteration) {
        float control = extinction * cell_control(scene, m, walk, transmittance);
        float bound = rate * scene.floats.at[m.majorant_first + uint(walk.index)] - control;
        float cell_depth = bound * (walk.t_next - walk.t);
        if (depth >= cell_depth) {
            depth -= cell_depth;
            controlled += control * (walk.t_next - walk.t);
            if (!cell_walk_advance(walk)) break;
            continue;
        }
        walk.t += depth / bound;
        controlled += control * (depth / bound);
        float density = medium_density_in_grid(scene, m, grid, walk.origin + walk.t * walk.direction);
        float pass = clamp(1.0f - (density * extinction - control) / bound, 0.0f, 1.0f);
        if (transmittance == TRANSMITTANCE_DELTA) {
            if (!(rng_1d(rng) < pass)) {
                w.throughput = vec3(0.0f);
                return false;
            }
            depth = exponential(rng_1d(rng));
            continue;
        }
        clear *= pass;
        // Russian roulette on what is left keeps dense clouds cheap.
        float left = (transmittance == TRANSMITTANCE_RESIDUAL ? clear * exp(-controlled) : clear) / survival;
        if (left < SHADOW_ROULETTE) {
            float survive = left / SHADOW_ROULETTE;
            if (!(rng_1d(rng) < survive)) {
                w.throughput = vec3(0.0f);
                return false;
            }
            survival *= survive;
        }
        depth = exponential(rng_1d(rng));
    }
    if (iteration >= MAX_MEDIUM_STEPS) {
        w.throughput = vec3(0.0f);
        return true;
    }
    if (transmittance == TRANSMITTANCE_RESIDUAL) clear *= exp(-controlled);
    w.throughput *= clear / survival;
    w.r_path *= clear;
    return false;
}

KERNELS_END
#endif
