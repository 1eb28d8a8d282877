#ifndef SPINEL_KERNELS_COUNTED_H
#define SPINEL_KERNELS_COUNTED_H
// Rays through the scene with what they cost: the walks of traverse.h with counters. Meshes count by their structure;
// whatever else is asked of a ray counts as one test, however long it walks or marches inside of itself.
#include "traverse.h"
KERNELS_BEGIN

FN void instance_closest_counted(const_in(SceneView) scene, uint instance, Ray ray, inout(Hit) hit,
                                 inout(WalkCount) count) {
    if (scene.instances.at[instance].geometry_kind != GEOMETRY_MESH) {
        ++count.tests;
        instance_closest(scene, instance, ray, hit);
        return;
    }
    Ray local = ray_to_local(scene.instances.at[instance], ray);
    Hit before = hit;
    float limit = instance_limit(instance, hit);
    hit.t = limit;
    mesh_closest_counted(scene, walked_geometry(scene.instances.at[instance]), local, hit, count);
    settle_hit(scene, instance, limit, before, hit);
}

FN Hit trace_closest_counted(const_in(SceneView) scene, Ray ray, uint mask, inout(WalkCount) count) {
    Hit hit = no_hit(ray.t_max);
    SlabRay slab = instance_slab_ray(ray);
    BvhStack stack;
    uint stack_size = 0u;
    bool found = scene.bounded_count > 0u;
    uint entry = found ? bvh_entry(scene.instance_nodes.at[0]) : 0u;
    while (found) {
        uint first = bvh_entry_first(entry);
        uint leaf = bvh_entry_count(entry);
        ++count.steps;
        if (leaf == 0u) {
            BvhSiblings siblings = bvh_siblings(scene.instance_nodes, first, slab, hit.t);
            count.boxes += 2u;
            if (siblings.enter_nearer < INFINITE) {
                if (siblings.enter_farther < INFINITE) {
                    stack.entry[stack_size] = siblings.farther;
                    stack.enter[stack_size] = siblings.enter_farther;
                    ++stack_size;
                }
                entry = siblings.nearer;
                continue;
            }
        }
        for (uint i = first; i < first + leaf; ++i) {
            uint instance = scene.instance_order.at[i];
            if (instance_admitted(scene.instances.at[instance].flags, mask))
                instance_closest_counted(scene, instance, ray, hit, count);
        }
        found = false;
        while (stack_size > 0u && !found) {
            --stack_size;
            found = stack.enter[stack_size] <= hit.t;
            entry = stack.entry[stack_size];
        }
    }
    for (uint i = scene.bounded_count; i < scene.bounded_count + scene.unbounded_count; ++i) {
        uint instance = scene.instance_order.at[i];
        if (instance_admitted(scene.instances.at[instance].flags, mask))
            instance_closest_counted(scene, instance, ray, hit, count);
    }
    return hit;
}

// Instances are asked in another order than trace_any() takes where several lie along the ray.
FN bool trace_any_counted(const_in(SceneView) scene, Ray ray, uint mask, inout(WalkCount) count) {
    InstanceWalk walk = walk_instances(scene, ray);
    for (uint i = 0u; i < scene.instance_count; ++i) {
        uint instance = next_instance(scene, walk);
        if (instance == NONE) return false;
        count.boxes += 2u;
        if (!instance_admitted(scene.instances.at[instance].flags, mask)) continue;
        if (scene.instances.at[instance].geometry_kind == GEOMETRY_MESH) {
            Ray local = ray_to_local(scene.instances.at[instance], ray);
            if (mesh_any_counted(scene, walked_geometry(scene.instances.at[instance]), local, count)) return true;
        } else {
            ++count.tests;
            if (instance_any(scene, instance, ray)) return true;
        }
    }
    return false;
}

KERNELS_END
#endif
