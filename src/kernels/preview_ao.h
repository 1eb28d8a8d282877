#ifndef SPINEL_KERNELS_PREVIEW_AO_H
#define SPINEL_KERNELS_PREVIEW_AO_H
// `ao`: sun and sky without shadows, darkened where things meet.
//
// On voxels ambient occlusion is that of block games: each corner of a face has a value by which of the eight cells
// around the one in front of the face are occupied, and values are interpolated over the face. Free of noise, and as
// wide as a voxel. On everything else rays look for what hides the sky within `ao_radius`, cosine-weighted: they see
// voxels too, but voxels do not see other geometry.
#include "preview_glow.h"
#include "preview_shade.h"
#include "warp.h"
KERNELS_BEGIN

// Light that is left in a corner of a face between two neighbours along the edges and one across, 0 … 1: where both
// sides are occupied the third cannot be seen, and the corner is as dark as it gets.
FN float voxel_corner_light(bool side_a, bool side_b, bool across) {
    if (side_a && side_b) return 0.0f;
    uint occupied = (side_a ? 1u : 0u) + (side_b ? 1u : 0u) + (across ? 1u : 0u);
    return float(3u - occupied) / 3.0f;
}

// Whether a cell hides light: what is neither air, nor glass, nor a mere boundary.
FN bool voxel_hides_light(const_in(SceneView) scene, const_in(VoxelGrid) grid, uint slot_first, ivec3 cell) {
    return voxel_class(scene, slot_first, voxel_at(scene, grid, cell)) == VOXEL_OPAQUE;
}

// Light that is left at a hit of a voxel's face, 0 … 1, linear between the corners. Hit.uv runs along the axes a + 1
// and a + 2 of the face's axis a.
FN float voxel_neighbour_light(const_in(SceneView) scene, const_in(Hit) hit) {
    RECORD(Instance) instance = scene.instances.at[hit.instance];
    RECORD(VoxelGrid) grid = scene.voxel_grids.at[instance.geometry];
    uint slots = instance.slot_first;
    int axis = int((hit.face >> 1u) & 3u);
    ivec3 front = hit.cell;
    front[axis] += (hit.face & 1u) != 0u ? 1 : -1;
    ivec3 u = ivec3(0);
    ivec3 v = ivec3(0);
    u[(axis + 1) % 3] = 1;
    v[(axis + 2) % 3] = 1;
    bool left = voxel_hides_light(scene, grid, slots, front - u);
    bool right = voxel_hides_light(scene, grid, slots, front + u);
    bool below = voxel_hides_light(scene, grid, slots, front - v);
    bool above = voxel_hides_light(scene, grid, slots, front + v);
    float light_00 = voxel_corner_light(left, below, voxel_hides_light(scene, grid, slots, front - u - v));
    float light_10 = voxel_corner_light(right, below, voxel_hides_light(scene, grid, slots, front + u - v));
    float light_01 = voxel_corner_light(left, above, voxel_hides_light(scene, grid, slots, front - u + v));
    float light_11 = voxel_corner_light(right, above, voxel_hides_light(scene, grid, slots, front + u + v));
    return mix(mix(light_00, light_10, hit.uv.x), mix(light_01, light_11, hit.uv.x), hit.uv.y);
}

// 1 or 0 by one ray: the mean over samples is the part of the cosine-weighted hemisphere that is open up to the radius.
FN float ray_sky_light(const_in(SceneView) scene, const_in(PreviewView) view, float radius, vec2 u) {
    vec3 direction = normalize(to_world(view.frame, square_to_cosine_hemisphere(u)));
    vec3 n = view.surface.entering ? view.surface.geometric_normal : -view.surface.geometric_normal;
    if (!(dot(direction, n) > 0.0f))
        return 1.0f;  // below a shading normal's horizon: the surface hides itself from none
    return trace_occluded(scene, Ray(preview_origin(scene, view), 0.0f, direction, radius)) ? 0.0f : 1.0f;
}

FN PixelSample preview_ao(const_in(SceneView) scene, const_in(PreviewSettings) settings, Ray ray, const_in(Hit) first,
                          Sampler numbers) {
    PreviewView view = preview_view(scene, ray, first);
    vec3 shaded = vec3(0.0f);
    if (view.found) {
        vec2 u = sampler_2d(numbers);
        float open = scene.instances.at[view.surface.instance].geometry_kind == GEOMETRY_VOXELS
                         ? voxel_neighbour_light(scene, view.hit)
                         : ray_sky_light(scene, view, settings.ao_radius, u);
        vec3 n = view.frame.z;
        float left = 1.0f - settings.ao_strength * (1.0f - open);
        shaded = view.albedo * (left * (preview_sky(scene, n) + preview_sun(scene, n)));
    }
    return preview_with_glow(scene, settings, view, preview_sample(scene, view, shaded));
}

KERNELS_END
#endif
