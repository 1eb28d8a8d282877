#ifndef SPINEL_KERNELS_MESH_KD_H
#define SPINEL_KERNELS_MESH_KD_H
// The walk over a kd-tree: space is cut in two again and again, and with it the ray's interval, so leaves are visited
// in the order in which the ray meets them, and the first hit within a leaf's interval ends the walk. Havran,
// "Heuristic Ray Shooting Algorithms", 2000, appendix C.
//
// A crossing is known to a few roundings only, and triangles are tested with roundings of their own. So intervals
// overlap by as much as slab tests are widened (box.h), and a triangle that counts is never on a side that is not
// visited.
#include "bvh.h"
#include "mesh_triangles.h"
KERNELS_BEGIN

const uint KD_MAX_DEPTH = 60u;

struct KdStack {
    uint node[KD_MAX_DEPTH + 1u];
    float enter[KD_MAX_DEPTH + 1u];
    float leave[KD_MAX_DEPTH + 1u];
};

FN_ANEW void mesh_kd_walk(const_in(SceneView) scene, uint mesh, const_in(MeshRay) ray, inout(MeshNearest) nearest,
                          inout(WalkCount) count) {
    uint node_first = scene.meshes.at[mesh].node_first;
    uint reference_first = scene.meshes.at[mesh].reference_first;
    vec2 span = slab_interval(scene.meshes.at[mesh].lower, scene.meshes.at[mesh].upper, ray.slab, nearest.hit.t);
    ++count.boxes;
    if (span.x > span.y) return;
    float enter = span.x;
    float leave = span.y;
    KdStack stack;
    uint stack_size = 0u;
    uint node = 0u;
    for (;;) {
        RECORD(KdNode) n = scene.kd_nodes.at[node_first + node];
        ++count.steps;
        if ((n.link & 1u) == 0u) {
            ++count.boxes;
            uint axis = (n.link >> 1u) & 3u;
            uint left = n.link >> 3u;
            float origin = component(ray.ray.origin, axis);
            float along = component(ray.ray.direction, axis);
            float t = (n.split - origin) * component(ray.slab.inverse, axis);
            bool below = origin < n.split || (origin == n.split && along < 0.0f);
            uint near = below ? left : left + 1u;
            uint far = below ? left + 1u : left;
            if (origin == n.split) {  // both sides, as what touches the plane may be on either
                stack.node[stack_size] = far;
                stack.enter[stack_size] = enter;
                stack.leave[stack_size] = leave;
                ++stack_size;
                node = near;
            } else if (t < 0.0f || t > leave * SLAB_WIDENING) {
                node = near;
            } else if (t * SLAB_WIDENING < enter) {
                node = far;
            } else {
                stack.node[stack_size] = far;
                stack.enter[stack_size] = max(enter, t * (2.0f - SLAB_WIDENING));
                stack.leave[stack_size] = leave;
                ++stack_size;
                node = near;
                leave = min(leave, t * SLAB_WIDENING);
            }
            continue;
        }
        uint first = reference_first + (n.link >> 3u);
        uint leaf = float_bits(n.split);
        count.tests += leaf;
        for (uint i = first; i < first + leaf; ++i) {
            if (mesh_test(scene, ray, ray.triangle_first + scene.words.at[i], nearest) && ray.any) return;
        }
        // What was hit beyond this leaf may be hidden by what lies in the next ones; they know where they begin.
        bool found = false;
        while (stack_size > 0u && !found) {
            --stack_size;
            node = stack.node[stack_size];
            enter = stack.enter[stack_size];
            leave = stack.leave[stack_size];
            found = bvh_still_entered(enter, nearest.hit.t);
        }
        if (!found) return;
    }
}

KERNELS_END
#endif
