#ifndef SPINEL_KERNELS_MESH_BVH2_H
#define SPINEL_KERNELS_MESH_BVH2_H
// The two walks over a binary BVH of a mesh's triangles: with a stack, nearer child first (bvh.h), and without.
#include "bvh.h"
#include "mesh_triangles.h"
KERNELS_BEGIN

FN_ANEW void mesh_bvh2_walk(const_in(SceneView) scene, uint mesh, const_in(MeshRay) ray, inout(MeshNearest) nearest,
                            inout(WalkCount) count) {
    uint node_first = scene.meshes.at[mesh].node_first;
    BvhStack stack;
    uint stack_size = 0u;
    uint entry = bvh_entry(scene.nodes.at[node_first]);
    for (;;) {
        uint first = bvh_entry_first(entry);
        uint leaf = bvh_entry_count(entry);
        ++count.steps;
        if (leaf == 0u) {
            BvhSiblings siblings = bvh_siblings(scene.nodes, node_first + first, ray.slab, nearest.hit.t);
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
        } else {
            count.tests += leaf;
            for (uint i = ray.triangle_first + first; i < ray.triangle_first + first + leaf; ++i) {
                if (mesh_test(scene, ray, i, nearest) && ray.any) return;
            }
        }
        bool found = false;
        while (stack_size > 0u && !found) {
            --stack_size;
            found = stack.enter[stack_size] <= nearest.hit.t;
            entry = stack.entry[stack_size];
        }
        if (!found) return;
    }
}

// Nodes stand in depth-first order, and `count` is where to go on if a box is missed or done with: behind its subtree
// (Smits, "Efficiency Issues for Ray Tracing", JGT 3(2), 1998). `first` is 0 in interior nodes, whose first child is
// the next; in leaves first / 16 and first % 16 are the range. No stack, two words of state; but children are visited
// in the order in which they stand, the farther one often first, when nothing yet shortens the ray.
FN_ANEW void mesh_stackless_walk(const_in(SceneView) scene, uint mesh, const_in(MeshRay) ray,
                                 inout(MeshNearest) nearest, inout(WalkCount) count) {
    uint node_first = scene.meshes.at[mesh].node_first;
    uint end = scene.nodes.at[node_first].count;  // of the root: behind all
    uint node = 0u;
    while (node < end) {
        RECORD(BvhNode) n = scene.nodes.at[node_first + node];
        ++count.steps;
        ++count.boxes;
        if (!(slab_entry(n.lower, n.upper, ray.slab, nearest.hit.t) < INFINITE)) {
            node = n.count;
            continue;
        }
        uint first = bvh_entry_first(n.first);
        uint leaf = bvh_entry_count(n.first);
        count.tests += leaf;
        for (uint i = ray.triangle_first + first; i < ray.triangle_first + first + leaf; ++i) {
            if (mesh_test(scene, ray, i, nearest) && ray.any) return;
        }
        ++node;
    }
}

KERNELS_END
#endif
