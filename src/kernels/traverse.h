#ifndef SPINEL_KERNELS_TRAVERSE_H
#define SPINEL_KERNELS_TRAVERSE_H
// The walk over the scene: a top-level BVH over the bounded instances, then the unbounded ones one by one. A ray is
// carried into an instance's local space without normalising its direction, so t keeps its meaning.
//
// Of surfaces at the same t, that of the instance with the lowest number is the hit, so that the answer does not depend
// on the order in which a walk comes by: devices, and rays alone or in packets, agree.
#include "box.h"
#include "bvh.h"
#include "device.h"
#include "mesh.h"
#include "plane.h"
#include "sdf.h"
#include "sdf_voxels.h"
#include "sphere.h"
#include "voxel_shapes.h"
#include "voxels.h"
KERNELS_BEGIN

FN bool instance_admitted(uint flags, uint mask) {
    uint kind = (flags & INSTANCE_PASS_THROUGH) != 0u ? TRACE_PASS_THROUGH : TRACE_SOLID;
    return (kind & mask) != 0u;
}

// For the boxes of instances, which are widened already by what slab_padding() tells for themselves at the origin: what
// is left is the ray's own part, so that a large instance does not widen the boxes of small ones.
FN SlabRay instance_slab_ray(Ray ray) { return slab_ray(ray, slab_padding(vec3(0.0f), vec3(0.0f), ray.origin)); }

FN Ray ray_to_local(const_in(Instance) instance, Ray ray) {
    return Ray(instance.world_to_object * vec4(ray.origin, 1.0f), ray.t_min,
               instance.world_to_object * vec4(ray.direction, 0.0f), ray.t_max);
}

// Up to where an instance is asked for a nearer hit than the one found: that one itself counts as farther if it is of
// an instance with a higher number.
FN float instance_limit(uint instance, const_in(Hit) hit) {
    return is_hit(hit) && instance < hit.instance ? next_above(hit.t) : hit.t;
}

// The nearest interface of any set of voxels in (ray.t_min, hit.t).
FN void voxel_set_closest(const_in(SceneView) scene, uint grid, uint slot_first, Ray ray, inout(Hit) hit) {
    switch (scene.voxel_grids.at[grid].walk) {
        case VOXEL_WALK_TREE: device_voxels_closest(scene, grid, slot_first, ray, hit); break;
        case VOXEL_WALK_SHAPES: shaped_voxels_closest(scene, grid, slot_first, ray, hit); break;
        case VOXEL_WALK_SDF: sdf_voxels_closest(scene, grid, slot_first, ray, hit); break;
    }
}

// What rays walk for an instance: its own geometry, or that of all that it leads.
FN uint walked_geometry(const_in(Instance) instance) {
    return instance.member_count > 0u ? instance.joined_mesh : instance.geometry;
}

// A hit of the mesh that instances are joined into, told as one of the instance whose triangle it is.
FN void name_member(const_in(SceneView) scene, uint leader, inout(Hit) hit) {
    uint triangle = scene.meshes.at[scene.instances.at[leader].joined_mesh].triangle_first + hit.primitive;
    uint low = scene.instances.at[leader].member_first;
    uint high = low + scene.instances.at[leader].member_count;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        uint member = scene.words.at[middle];
        if (scene.meshes.at[scene.instances.at[member].geometry].triangle_first <= triangle) low = middle;
        else high = middle;
    }
    hit.instance = scene.words.at[low];
    hit.primitive = triangle - scene.meshes.at[scene.instances.at[hit.instance].geometry].triangle_first;
}

// After an instance was asked for what is nearer than `limit`: whose hit it is. `before` is what was known.
FN void settle_hit(const_in(SceneView) scene, uint instance, float limit, const_in(Hit) before, inout(Hit) hit) {
    if (!(hit.t < limit)) {
        hit.t = before.t;
        return;
    }
    hit.instance = instance;
    if (scene.instances.at[instance].member_count == 0u) return;
    name_member(scene, instance, hit);
    if (hit.t == before.t && before.instance < hit.instance) hit = before;
}

// The nearest hit of one instance, or of all that it leads, in (ray.t_min, hit.t).
FN void instance_closest(const_in(SceneView) scene, uint instance, Ray ray, inout(Hit) hit) {
    Ray local = ray_to_local(scene.instances.at[instance], ray);
    uint geometry = walked_geometry(scene.instances.at[instance]);
    Hit before = hit;
    float limit = instance_limit(instance, hit);
    local.t_max = limit;
    hit.t = limit;
    switch (scene.instances.at[instance].geometry_kind) {
        case GEOMETRY_MESH: mesh_closest(scene, geometry, local, hit); break;
        case GEOMETRY_VOXELS:
            voxel_set_closest(scene, geometry, scene.instances.at[instance].slot_first, local, hit);
            break;
        case GEOMETRY_SDF: sdf_closest(scene, geometry, local, hit); break;
        case GEOMETRY_SPHERE: sphere_closest(local, hit); break;
        case GEOMETRY_BOX: box_closest(local, hit); break;
        case GEOMETRY_PLANE: plane_closest(local, hit); break;
        case GEOMETRY_RECTANGLE: rectangle_closest(local, hit); break;
    }
    settle_hit(scene, instance, limit, before, hit);
}

// Whether one instance, or any that it leads, is hit in (ray.t_min, ray.t_max).
FN bool instance_any(const_in(SceneView) scene, uint instance, Ray ray) {
    Ray local = ray_to_local(scene.instances.at[instance], ray);
    uint geometry = walked_geometry(scene.instances.at[instance]);
    Hit hit = no_hit(ray.t_max);
    switch (scene.instances.at[instance].geometry_kind) {
        case GEOMETRY_MESH: return mesh_any(scene, geometry, local);
        case GEOMETRY_VOXELS:
            voxel_set_closest(scene, geometry, scene.instances.at[instance].slot_first, local, hit);
            break;
        case GEOMETRY_SDF: return sdf_any(scene, geometry, local);
        case GEOMETRY_SPHERE: sphere_closest(local, hit); break;
        case GEOMETRY_BOX: box_closest(local, hit); break;
        case GEOMETRY_PLANE: plane_closest(local, hit); break;
        case GEOMETRY_RECTANGLE: rectangle_closest(local, hit); break;
    }
    return hit.t < ray.t_max;
}

// In walks over the scene: what stands for the unbounded instances among the entries of the tree. So that an instance
// is asked in one place: shaders hold a copy of all geometries' walks for each.
const uint BVH_ENTRY_UNBOUNDED = NONE;

FN Hit trace_closest(const_in(SceneView) scene, Ray ray, uint mask) {
    Hit hit = no_hit(ray.t_max);
    SlabRay slab = instance_slab_ray(ray);
    BvhStack stack;
    stack.entry[0] = BVH_ENTRY_UNBOUNDED;
    stack.enter[0] = -INFINITE;
    uint stack_size = scene.bounded_count > 0u ? 1u : 0u;
    uint entry = scene.bounded_count > 0u ? bvh_entry(scene.instance_nodes.at[0]) : BVH_ENTRY_UNBOUNDED;
    for (;;) {
        uint first = bvh_entry_first(entry);
        uint count = bvh_entry_count(entry);
        if (count == 0u) {
            BvhSiblings siblings = bvh_siblings(scene.instance_nodes, first, slab, hit.t);
            if (siblings.enter_nearer < INFINITE) {
                if (siblings.enter_farther < INFINITE) {
                    stack.entry[stack_size] = siblings.farther;
                    stack.enter[stack_size] = siblings.enter_farther;
                    ++stack_size;
                }
                entry = siblings.nearer;
                continue;
            }
        } else {
            if (entry == BVH_ENTRY_UNBOUNDED) {
                first = scene.bounded_count;
                count = scene.unbounded_count;
            }
            for (uint i = first; i < first + count; ++i) {
                uint instance = scene.instance_order.at[i];
                if (instance_admitted(scene.instances.at[instance].flags, mask)) {
                    instance_closest(scene, instance, ray, hit);
                }
            }
        }
        bool found = false;
        while (stack_size > 0u && !found) {
            --stack_size;
            found = stack.enter[stack_size] <= hit.t;
            entry = stack.entry[stack_size];
        }
        if (!found) break;
    }
    return hit;
}

FN bool trace_any(const_in(SceneView) scene, Ray ray, uint mask) {
    SlabRay slab = instance_slab_ray(ray);
    BvhStack stack;
    uint stack_size = 0u;
    if (scene.bounded_count > 0u) {
        stack.entry[0] = bvh_entry(scene.instance_nodes.at[0]);
        stack_size = 1u;
    }
    uint entry = BVH_ENTRY_UNBOUNDED;
    for (;;) {
        uint first = bvh_entry_first(entry);
        uint count = bvh_entry_count(entry);
        if (count == 0u) {
            BvhSiblings siblings = bvh_siblings(scene.instance_nodes, first, slab, ray.t_max);
            if (siblings.enter_nearer < INFINITE) {
                if (siblings.enter_farther < INFINITE) {
                    stack.entry[stack_size] = siblings.farther;
                    ++stack_size;
                }
                entry = siblings.nearer;
                continue;
            }
        } else {
            if (entry == BVH_ENTRY_UNBOUNDED) {
                first = scene.bounded_count;
                count = scene.unbounded_count;
            }
            for (uint i = first; i < first + count; ++i) {
                uint instance = scene.instance_order.at[i];
                if (instance_admitted(scene.instances.at[instance].flags, mask) && instance_any(scene, instance, ray)) {
                    return true;
                }
            }
        }
        if (stack_size == 0u) return false;
        --stack_size;
        entry = stack.entry[stack_size];
    }
    return false;
}

// The instances whose bounds a ray meets, one after the other, in no order that means anything: for questions that
// every one of them has to answer, where the nearest would hide the others.
struct InstanceWalk {
    SlabRay slab;
    float t_max;
    BvhStack stack;
    uint stack_size;
    uint next;  // into instance_order …
    uint end;   // … up to here before the stack is asked again
    bool bounded_done;
};

FN InstanceWalk walk_instances(const_in(SceneView) scene, Ray ray) {
    InstanceWalk walk;
    walk.slab = instance_slab_ray(ray);
    walk.t_max = ray.t_max;
    walk.stack_size = 0u;
    walk.next = 0u;
    walk.end = 0u;
    walk.bounded_done = false;
    if (scene.bounded_count > 0u) {
        walk.stack.entry[0] = bvh_entry(scene.instance_nodes.at[0]);
        walk.stack_size = 1u;
    }
    return walk;
}

// NONE: that was the last.
FN uint next_instance(const_in(SceneView) scene, inout(InstanceWalk) walk) {
    while (walk.next >= walk.end && walk.stack_size > 0u) {
        --walk.stack_size;
        uint entry = walk.stack.entry[walk.stack_size];
        uint first = bvh_entry_first(entry);
        uint count = bvh_entry_count(entry);
        if (count > 0u) {
            walk.next = first;
            walk.end = first + count;
            continue;
        }
        BvhSiblings siblings = bvh_siblings(scene.instance_nodes, first, walk.slab, walk.t_max);
        if (siblings.enter_farther < INFINITE) {
            walk.stack.entry[walk.stack_size] = siblings.farther;
            ++walk.stack_size;
        }
        if (siblings.enter_nearer < INFINITE) {
            walk.stack.entry[walk.stack_size] = siblings.nearer;
            ++walk.stack_size;
        }
    }
    if (walk.next >= walk.end && !walk.bounded_done) {
        walk.bounded_done = true;
        walk.next = scene.bounded_count;
        walk.end = scene.bounded_count + scene.unbounded_count;
    }
    if (walk.next >= walk.end) return NONE;
    uint instance = scene.instance_order.at[walk.next];
    ++walk.next;
    return instance;
}

FN bool trace_occluded(const_in(SceneView) scene, Ray ray) { return trace_any(scene, ray, TRACE_SOLID); }

#ifndef __cplusplus
void device_voxels_closest(const_in(SceneView) scene, uint grid, uint slot_first, Ray ray, inout(Hit) hit) {
    voxels_closest(scene, grid, slot_first, ray, hit);
}
#endif

KERNELS_END
#endif
