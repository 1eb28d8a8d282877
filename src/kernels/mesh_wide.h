#ifndef SPINEL_KERNELS_MESH_WIDE_H
#define SPINEL_KERNELS_MESH_WIDE_H
// The walk over a wide hierarchy of a mesh's triangles (WideUnit), box by box and triangle by triangle: what shaders
// do, and what CPUs do with another test than the watertight one. For that they have a walk of their own
// (devices/cpu/mesh_walk.h), which is the reason for this layout, with the same answer bit for bit.
#include "mesh_triangles.h"
KERNELS_BEGIN

const uint WIDE_STACK_SIZE = 428u;  // a node is left by at most seven other children, on each of at most 60 levels
const uint WIDE_UNIT_MASK = 0x0fffffffu;  // of a reference

FN float wide_inverse_component(float d, float tiny) { return 1.0f / (abs(d) < tiny ? (d < 0.0f ? -tiny : tiny) : d); }

// 1/d, of a finite size: components of the direction that are 10⁸ times smaller than the largest are made as large as
// that, by which a ray moves less than slab_padding() on its way through the mesh.
FN vec3 wide_inverse(vec3 d) {
    float tiny = 1.0e-8f * max(max(abs(d.x), abs(d.y)), abs(d.z));
    return vec3(wide_inverse_component(d.x, tiny), wide_inverse_component(d.y, tiny),
                wide_inverse_component(d.z, tiny));
}

struct WideStack {
    uint reference[WIDE_STACK_SIZE];
    float enter[WIDE_STACK_SIZE];
};

FN_ANEW void mesh_wide_walk(const_in(SceneView) scene, uint mesh, const_in(MeshRay) ray, inout(MeshNearest) nearest,
                            inout(WalkCount) count) {
    uint root = scene.meshes.at[mesh].node_first;
    vec3 inverse = wide_inverse(ray.ray.direction);
    float padding = slab_padding(scene.meshes.at[mesh].lower, scene.meshes.at[mesh].upper, ray.ray.origin);
    vec3 lower_origin = ray.ray.origin + vec3(padding);
    vec3 upper_origin = ray.ray.origin - vec3(padding);
    WideStack stack;
    uint size = 1u;
    stack.reference[0] = 0u;
    stack.enter[0] = ray.ray.t_min;
    while (size > 0u) {
        --size;
        if (!(stack.enter[size] <= nearest.hit.t)) continue;
        uint unit = root + (stack.reference[size] & WIDE_UNIT_MASK);
        uint blocks = stack.reference[size] >> 28u;
        ++count.steps;
        if (blocks > 0u) {
            count.tests += 4u * blocks;
            for (uint i = 0u; i < 4u * blocks; ++i) {
                uint block = unit + (i >> 2u) * WIDE_BLOCK_UNITS;
                uint triangle = float_bits(scene.wide_units.at[block + 4u].lanes[4u + (i & 3u)]);
                if (mesh_test(scene, ray, ray.triangle_first + triangle, nearest) && ray.any) return;
            }
            continue;
        }
        count.boxes += 8u;
        uint first = size;
        for (uint i = 0u; i < 8u; ++i) {
            vec3 lower = vec3(scene.wide_units.at[unit].lanes[i], scene.wide_units.at[unit + 2u].lanes[i],
                              scene.wide_units.at[unit + 4u].lanes[i]);
            vec3 upper = vec3(scene.wide_units.at[unit + 1u].lanes[i], scene.wide_units.at[unit + 3u].lanes[i],
                              scene.wide_units.at[unit + 5u].lanes[i]);
            if (lower.x > upper.x) continue;
            vec3 t0 = (lower - lower_origin) * inverse;
            vec3 t1 = (upper - upper_origin) * inverse;
            vec3 from = min(t0, t1);
            vec3 to = max(t0, t1);
            float enter = max(max(from.x, from.y), max(from.z, ray.ray.t_min));
            float leave = min(min(to.x, to.y), min(to.z, nearest.hit.t));
            if (!(enter <= leave)) continue;
            // The nearest comes on top.
            uint at = size;
            while (at > first && stack.enter[at - 1u] < enter) {
                stack.reference[at] = stack.reference[at - 1u];
                stack.enter[at] = stack.enter[at - 1u];
                --at;
            }
            stack.reference[at] = float_bits(scene.wide_units.at[unit + 6u].lanes[i]);
            stack.enter[at] = enter;
            ++size;
        }
    }
}

#ifdef __cplusplus
// A triangle and its normal, cross(b - a, c - a): a walk has its vertices at hand, elsewhere they would have to be
// fetched from far away (measured: a third of the time that the walk takes).
struct WideNearest {
    MeshNearest nearest;
    vec3 normal;  // 0 if there is no triangle
};

// The CPU's own walks of this layout and the compact one (devices/cpu/mesh_walk.cpp), with the watertight test; for any
// hit, what is told of it beside that there is one means nothing.
WideNearest device_mesh_wide(const_in(SceneView) scene, uint mesh, Ray ray, bool any);

FN bool mesh_is_devices(const_in(SceneView) scene, uint mesh) {
    uint walk = scene.meshes.at[mesh].walk;
    return (walk == MESH_WALK_WIDE || walk == MESH_WALK_COMPACT) &&
           scene.meshes.at[mesh].triangle_test == TRIANGLE_WATERTIGHT;
}
#endif

KERNELS_END
#endif
