#ifndef SPINEL_KERNELS_LOCATE_H
#define SPINEL_KERNELS_LOCATE_H
// Which closed objects a point lies in. A voxel set is asked for the cell; of all else a ray to far away leaves each
// object that holds the point once more than it enters it.
#include "device.h"
#include "surface.h"
KERNELS_BEGIN

const uint MAX_LOCATE_CROSSINGS = 4096u;

// Interiors at p. A bound that was reached shows as Inside::dropped.
FN Inside interiors_at(const_in(SceneView) scene, vec3 p) {
    Inside found = inside_nothing();
    for (uint i = 0u; i < scene.instance_count; ++i) {
        RECORD(Instance) instance = scene.instances.at[i];
        if (instance.geometry_kind != GEOMETRY_VOXELS) continue;
        RECORD(VoxelGrid) grid = scene.voxel_grids.at[instance.geometry];
        vec3 local = instance.world_to_object * vec4(p, 1.0f);
        if (!(max_component(abs(local)) < 1.0e9f)) continue;
        uint palette = voxel_at(scene, grid, ivec3(floor(local)));
        if (palette != 0u) inside_enter(found, scene.slots.at[instance.slot_first + palette - 1u].interior);
    }
    Inside entered = inside_nothing();
    // A direction without symmetry, so that edges and corners of things people build are not met.
    Ray ray = Ray(p, 0.0f, normalize(vec3(0.3713907f, 0.7427814f, 0.5570860f)), INFINITE);
    for (uint i = 0u; i < MAX_LOCATE_CROSSINGS; ++i) {
        Hit hit = trace_closest(scene, ray, TRACE_ENCLOSING);
        if (!is_hit(hit)) {
            found.dropped += entered.dropped;
            return found;
        }
        Surface s = surface_at(scene, ray, hit);
        if (s.leaves != NONE) {
            if (inside_contains(entered, s.leaves)) inside_leave(entered, s.leaves);
            else inside_enter(found, s.leaves);
        }
        inside_enter(entered, s.enters);
        ray.t_min = hit.t;
    }
    found.dropped += 1u;
    return found;
}

KERNELS_END
#endif
