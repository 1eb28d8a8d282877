#ifndef SPINEL_KERNELS_MESH_H
#define SPINEL_KERNELS_MESH_H
// Rays against a triangle mesh, by a stack walk over its BVH (bvh.h) with the watertight triangle test.
#include "bvh.h"
#include "triangle.h"
KERNELS_BEGIN

// The nearest triangle in (ray.t_min, hit.t), in the mesh's local space. Sets t, primitive (in leaf order),
// uv and normal; leaves `hit` alone if there is none.
FN void mesh_closest(const_in(SceneView) scene, uint mesh, Ray ray, inout(Hit) hit) {
    if (scene.meshes.at[mesh].triangle_count == 0u) return;
    uint node_first = scene.meshes.at[mesh].node_first;
    uint triangle_first = scene.meshes.at[mesh].triangle_first;
    SlabRay slab = slab_ray(ray);
    TriangleRay sheared = triangle_ray(ray);
    TriangleHit best = TriangleHit(hit.t, 0.0f, 0.0f);
    uint nearest = NONE;
    BvhStack stack;
    uint stack_size = 0u;
    uint entry = bvh_entry(scene.nodes.at[node_first]);
    for (;;) {
        uint first = bvh_entry_first(entry);
        uint count = bvh_entry_count(entry);
        if (count == 0u) {
            BvhSiblings siblings = bvh_siblings(scene.nodes, node_first + first, slab, best.t);
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
            for (uint i = triangle_first + first; i < triangle_first + first + count; ++i) {
                if (triangle_watertight(sheared, scene.triangles.at[i], ray.t_min, best.t, best)) nearest = i;
            }
        }
        bool found = false;
        while (stack_size > 0u && !found) {
            --stack_size;
            found = bvh_still_entered(stack.enter[stack_size], best.t);
            entry = stack.entry[stack_size];
        }
        if (!found) break;
    }
    if (nearest == NONE) return;
    Triangle triangle = scene.triangles.at[nearest];
    hit.t = best.t;
    hit.primitive = nearest - triangle_first;
    hit.face = 0u;
    hit.cell = ivec3(0);
    hit.uv = vec2(best.u, best.v);
    hit.normal = cross(triangle.b - triangle.a, triangle.c - triangle.a);
}

// Whether any triangle lies in (ray.t_min, ray.t_max).
FN bool mesh_any(const_in(SceneView) scene, uint mesh, Ray ray) {
    if (scene.meshes.at[mesh].triangle_count == 0u) return false;
    uint node_first = scene.meshes.at[mesh].node_first;
    uint triangle_first = scene.meshes.at[mesh].triangle_first;
    SlabRay slab = slab_ray(ray);
    TriangleRay sheared = triangle_ray(ray);
    TriangleHit ignored = TriangleHit(0.0f, 0.0f, 0.0f);
    BvhStack stack;
    uint stack_size = 0u;
    uint entry = bvh_entry(scene.nodes.at[node_first]);
    for (;;) {
        uint first = bvh_entry_first(entry);
        uint count = bvh_entry_count(entry);
        if (count == 0u) {
            BvhSiblings siblings = bvh_siblings(scene.nodes, node_first + first, slab, ray.t_max);
            if (siblings.enter_nearer < INFINITE) {
                if (siblings.enter_farther < INFINITE) {
                    stack.entry[stack_size] = siblings.farther;
                    ++stack_size;
                }
                entry = siblings.nearer;
                continue;
            }
        } else {
            for (uint i = triangle_first + first; i < triangle_first + first + count; ++i) {
                if (triangle_watertight(sheared, scene.triangles.at[i], ray.t_min, ray.t_max, ignored)) return true;
            }
        }
        if (stack_size == 0u) return false;
        --stack_size;
        entry = stack.entry[stack_size];
    }
    return false;
}

KERNELS_END
#endif
