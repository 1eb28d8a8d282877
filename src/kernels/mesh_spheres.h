#ifndef SPINEL_KERNELS_MESH_SPHERES_H
#define SPINEL_KERNELS_MESH_SPHERES_H
// An experiment: the binary hierarchy of bvh.h with spheres in place of boxes (Rubin and Whitted, "A 3-Dimensional
// Representation for Fast Rendering of Complex Scenes", SIGGRAPH 1980, leave the shape open). A sphere takes four
// numbers and turns with the object; around a flat triangle it holds mostly air.
#include "bvh.h"
#include "mesh_triangles.h"
KERNELS_BEGIN

// Where the ray enters the ball, at least t_min; INFINITE if it misses within (t_min, t_max). The radius is widened by
// what the distance of the line to the centre may be off and a test may move triangles in the ball by: slab_padding()'s
// figures along all three axes, as balls do not know of axes. Balls hold whole triangles, so their own size counts.
FN float ball_entry(const_in(SphereNode) node, Ray ray, float inverse_square, float t_max) {
    vec3 to_center = node.center - ray.origin;
    float t = dot(to_center, ray.direction) * inverse_square;  // of the foot of the perpendicular
    vec3 foot = to_center - t * ray.direction;
    vec3 o = abs(ray.origin);
    float padding = 3.3e-6f * (length(to_center) + node.radius) + 4.2e-7f * max(max(o.x, o.y), o.z);
    float radius = node.radius + padding;
    float square = radius * radius - dot(foot, foot);
    if (square < 0.0f) return INFINITE;
    float half_chord = (sqrt(square) + padding) * sqrt(inverse_square);
    float enter = max(t - half_chord, ray.t_min);
    return enter <= min(t + half_chord, t_max) ? enter : INFINITE;
}

FN_ANEW void mesh_sphere_walk(const_in(SceneView) scene, uint mesh, const_in(MeshRay) ray, inout(MeshNearest) nearest,
                              inout(WalkCount) count) {
    uint node_first = scene.meshes.at[mesh].node_first;
    float inverse_square = 1.0f / dot(ray.ray.direction, ray.ray.direction);
    BvhStack stack;
    uint stack_size = 0u;
    uint node = 0u;
    for (;;) {
        RECORD(SphereNode) n = scene.sphere_nodes.at[node_first + node];
        ++count.steps;
        if (n.count == 0u) {
            float enter_left =
                ball_entry(scene.sphere_nodes.at[node_first + n.first], ray.ray, inverse_square, nearest.hit.t);
            float enter_right =
                ball_entry(scene.sphere_nodes.at[node_first + n.first + 1u], ray.ray, inverse_square, nearest.hit.t);
            count.boxes += 2u;
            bool right_nearer = enter_right < enter_left;
            if (min(enter_left, enter_right) < INFINITE) {
                if (max(enter_left, enter_right) < INFINITE) {
                    stack.entry[stack_size] = right_nearer ? n.first : n.first + 1u;
                    stack.enter[stack_size] = max(enter_left, enter_right);
                    ++stack_size;
                }
                node = right_nearer ? n.first + 1u : n.first;
                continue;
            }
        } else {
            count.tests += n.count;
            for (uint i = ray.triangle_first + n.first; i < ray.triangle_first + n.first + n.count; ++i) {
                if (mesh_test(scene, ray, i, nearest) && ray.any) return;
            }
        }
        bool found = false;
        while (stack_size > 0u && !found) {
            --stack_size;
            found = stack.enter[stack_size] <= nearest.hit.t;
            node = stack.entry[stack_size];
        }
        if (!found) return;
    }
}

KERNELS_END
#endif
