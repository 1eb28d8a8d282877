#ifndef SPINEL_KERNELS_MESH_KD_H
#define SPINEL_KERNELS_MESH_KD_H
// The walk over a kd-tree: space is cut in two again and again, and with it the ray's interval, so leaves are visited
// in the order in which the ray meets them, and the first hit within a leaf's interval ends the walk. Havran,
// "Heuristic Ray Shooting Algorithms", 2000, appendix C.
//
// A crossing is known to a few roundings only, and triangles are tested with roundings of their own. So each side
// reaches beyond the plane by as much as boxes are widened (box.h), and a triangle that counts is never on a side that
// is not visited.
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
            float inverse = component(ray.slab.inverse, axis);
            bool upward = inverse > 0.0f;
            uint near = upward ? left : left + 1u;  // the side that the ray comes from
            uint far = upward ? left + 1u : left;
            float from_lower = (n.split - component(ray.slab.lower_origin, axis)) * inverse;  // of the right side
            float to_upper = (n.split - component(ray.slab.upper_origin, axis)) * inverse;    // of the left one
            float leave_near = upward ? to_upper : from_lower;
            float enter_far = upward ? from_lower : to_upper;
            if (enter_far > leave) {
                node = near;
            } else if (leave_near < enter) {
                node = far;
            } else {
                stack.node[stack_size] = far;
                stack.enter[stack_size] = max(enter, enter_far);
                stack.leave[stack_size] = leave;
                ++stack_size;
                node = near;
                leave = min(leave, leave_near);
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
            found = enter <= nearest.hit.t;
        }
        if (!found) return;
    }
}

KERNELS_END
#endif
