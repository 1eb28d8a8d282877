#ifndef SPINEL_KERNELS_LOCATE_H
#define SPINEL_KERNELS_LOCATE_H
// Which closed objects a point lies in. A voxel set is asked for the cell; any other object by a ray to far away, which
// leaves it once more than it enters it if it holds the point. Each object is asked by itself, so that surfaces in the
// same place cannot hide one another.
#include "surface.h"
#include "traverse.h"
KERNELS_BEGIN

const uint MAX_LOCATE_CROSSINGS = 4096u;  // of one object

// Interiors by where the ray leaves them, the farthest first: the order in which a path from outside enters what is
// nested.
struct Located {
    Inside inside;
    float exits[8];  // MAX_INSIDE
};

FN void locate_exit(inout(Located) found, uint interior, float t) {
    uint i = found.inside.count;
    inside_enter(found.inside, interior);
    if (i == found.inside.count) return;
    for (; i > 0u && found.exits[i - 1u] < t; --i) {
        found.inside.entries[i] = found.inside.entries[i - 1u];
        found.exits[i] = found.exits[i - 1u];
    }
    found.inside.entries[i] = interior;
    found.exits[i] = t;
}

FN void locate_in_object(const_in(SceneView) scene, uint instance, Ray ray, inout(Located) found) {
    Inside entered = inside_nothing();
    Ray onward = ray;
    for (uint i = 0u; i < MAX_LOCATE_CROSSINGS; ++i) {
        Hit hit = no_hit(onward.t_max);
        instance_closest(scene, instance, onward, hit);
        if (!is_hit(hit)) {
            found.inside.dropped += entered.dropped;
            return;
        }
        Surface s = surface_at(scene, ray, hit);
        if (s.leaves != NONE) {
            if (inside_contains(entered, s.leaves)) inside_leave(entered, s.leaves);
            else locate_exit(found, s.leaves, hit.t);
        }
        inside_enter(entered, s.enters);
        onward.t_min = hit.t;
    }
    found.inside.dropped += 1u;
}

// Interiors at p. A bound that was reached shows as Inside::dropped.
FN Inside interiors_at(const_in(SceneView) scene, vec3 p) {
    Located found;
    found.inside = inside_nothing();
    for (uint i = 0u; i < MAX_INSIDE; ++i) found.exits[i] = INFINITE;
    for (uint i = 0u; i < scene.instance_count; ++i) {
        RECORD(Instance) instance = scene.instances.at[i];
        if (instance.geometry_kind != GEOMETRY_VOXELS) continue;
        RECORD(VoxelGrid) grid = scene.voxel_grids.at[instance.geometry];
        vec3 local = instance.world_to_object * vec4(p, 1.0f);
        if (!(max_component(abs(local)) < 1.0e9f)) continue;
        uint palette = voxel_at_point(scene, grid, instance.slot_first, local);
        if (palette != 0u) inside_enter(found.inside, scene.slots.at[instance.slot_first + palette - 1u].interior);
    }
    // A direction without symmetry, so that edges and corners of things people build are not met.
    Ray ray = Ray(p, 0.0f, normalize(vec3(0.3713907f, 0.7427814f, 0.5570860f)), INFINITE);
    InstanceWalk walk = walk_instances(scene, ray);
    for (uint i = next_instance(scene, walk); i != NONE; i = next_instance(scene, walk))
        if ((scene.instances.at[i].flags & INSTANCE_ENCLOSES) != 0u) locate_in_object(scene, i, ray, found);
    return found.inside;
}

KERNELS_END
#endif
