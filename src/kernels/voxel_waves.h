#ifndef SPINEL_KERNELS_VOXEL_WAVES_H
#define SPINEL_KERNELS_VOXEL_WAVES_H
// The surface of water in voxels: a sum of plane waves over x and z, in cells. A true surface and no bent normal: where
// it lies is where rays meet it. In SceneView::floats at VoxelGrid::wave_first stand the mean height above the cell's
// floor, the height of the crests if all meet, the steepest slope if all meet, and for each wave its wave vector (x,
// z), phase and amplitude.
#include "box.h"
#include "scene_view.h"
KERNELS_BEGIN

const uint WAVE_HEADER = 3u;
const uint MAX_WAVE_STEPS = 128u;
const uint MAX_WAVE_REFINEMENTS = 32u;

// Above the floor of the cells.
FN float wave_height(const_in(SceneView) scene, const_in(VoxelGrid) grid, float x, float z) {
    float h = scene.floats.at[grid.wave_first];
    for (uint i = 0u; i < grid.wave_count; ++i) {
        uint at = grid.wave_first + WAVE_HEADER + 4u * i;
        float angle = scene.floats.at[at] * x + scene.floats.at[at + 1u] * z + scene.floats.at[at + 2u];
        h += scene.floats.at[at + 3u] * sin(angle);
    }
    return h;
}

// Out of the water, not normalised.
FN vec3 wave_normal(const_in(SceneView) scene, const_in(VoxelGrid) grid, float x, float z) {
    vec3 n = vec3(0.0f, 1.0f, 0.0f);
    for (uint i = 0u; i < grid.wave_count; ++i) {
        uint at = grid.wave_first + WAVE_HEADER + 4u * i;
        float kx = scene.floats.at[at];
        float kz = scene.floats.at[at + 1u];
        float slope = scene.floats.at[at + 3u] * cos(kx * x + kz * z + scene.floats.at[at + 2u]);
        n.x -= slope * kx;
        n.z -= slope * kz;
    }
    return n;
}

// How far a point lies above the water of the cells with this floor.
FN float wave_above(const_in(SceneView) scene, const_in(VoxelGrid) grid, int floor_y, vec3 p) {
    return p.y - float(floor_y) - wave_height(scene, grid, p.x, p.z);
}

// The first t in (t0, t1) at which the ray has passed the surface; INFINITE: it does not. `below`: it begins in the
// water. A change that is undone within a hundredth of the way may be passed over, both at once, so that what a ray is
// in stays known.
FN float wave_crossing(const_in(SceneView) scene, const_in(VoxelGrid) grid, int floor_y, Ray ray, float t0, float t1,
                       bool below) {
    float y0 = ray.origin.y + t0 * ray.direction.y - float(floor_y);
    float y1 = ray.origin.y + t1 * ray.direction.y - float(floor_y);
    float crest = scene.floats.at[grid.wave_first + 1u];
    float trough = 2.0f * scene.floats.at[grid.wave_first] - crest;
    if (below ? max(y0, y1) < trough : min(y0, y1) > crest) return INFINITE;
    float flat_speed = length(vec2(ray.direction.x, ray.direction.z));
    float rate = abs(ray.direction.y) + scene.floats.at[grid.wave_first + 2u] * flat_speed;
    float shortest = (t1 - t0) * 0.01f;
    if (!(rate > 0.0f) || !(shortest > 0.0f)) return INFINITE;

    float near = t0;
    float near_f = wave_above(scene, grid, floor_y, ray_at(ray, t0));
    float far = t0;
    float far_f = near_f;
    bool found = false;
    for (uint i = 0u; i < MAX_WAVE_STEPS && near < t1; ++i) {
        far = min(near + max(abs(near_f) / rate, shortest), t1);
        far_f = wave_above(scene, grid, floor_y, ray_at(ray, far));
        found = (far_f <= 0.0f) != below;
        if (found) break;
        near = far;
        near_f = far_f;
    }
    if (!found) return INFINITE;
    // Regula falsi, every third step a bisection; `far` stays behind the surface.
    for (uint i = 0u; i < MAX_WAVE_REFINEMENTS; ++i) {
        float middle = 0.5f * (near + far);
        float m = i % 3u == 2u ? middle : near - near_f * ((far - near) / (far_f - near_f));
        if (!(m > near && m < far)) m = middle;
        if (!(m > near && m < far)) break;  // neighbouring floats
        float f = wave_above(scene, grid, floor_y, ray_at(ray, m));
        if ((f <= 0.0f) == below) {
            near = m;
            near_f = f;
        } else {
            far = m;
            far_f = f;
        }
    }
    return far;
}

KERNELS_END
#endif
