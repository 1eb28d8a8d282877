#ifndef SPINEL_KERNELS_MESH_H
#define SPINEL_KERNELS_MESH_H
// Rays against a triangle mesh, by whichever structure it was built into (geometry/mesh/mesh_structures.h). All of them
// test triangles by the same functions, so they agree about t to the last bit.
#include "mesh_bvh2.h"
#include "mesh_compact.h"
#include "mesh_grid.h"
#include "mesh_kd.h"
#include "mesh_spheres.h"
#include "mesh_wide.h"
KERNELS_BEGIN

FN_ANEW MeshNearest mesh_walk(const_in(SceneView) scene, uint mesh, Ray ray, bool any, uint test,
                              inout(WalkCount) count) {
    MeshRay r = mesh_ray(scene, mesh, ray, any, test);
    MeshNearest nearest = MeshNearest(TriangleHit(ray.t_max, 0.0f, 0.0f), NONE);
    switch (scene.meshes.at[mesh].walk) {
        case MESH_WALK_BVH2: mesh_bvh2_walk(scene, mesh, r, nearest, count); break;
        case MESH_WALK_STACKLESS: mesh_stackless_walk(scene, mesh, r, nearest, count); break;
        case MESH_WALK_KD: mesh_kd_walk(scene, mesh, r, nearest, count); break;
        case MESH_WALK_GRID: mesh_grid_walk(scene, mesh, r, nearest, count); break;
        case MESH_WALK_SPHERES: mesh_sphere_walk(scene, mesh, r, nearest, count); break;
        case MESH_WALK_WIDE: mesh_wide_walk(scene, mesh, r, nearest, count); break;
        case MESH_WALK_COMPACT: mesh_compact_walk(scene, mesh, r, nearest, count); break;
    }
    return nearest;
}

// The same without counters, where the device has no walk of its own.
FN MeshNearest mesh_nearest(const_in(SceneView) scene, uint mesh, Ray ray, bool any) {
    uint test = scene.meshes.at[mesh].triangle_test;
    WalkCount unread = no_count();
#ifdef __cplusplus  // the default test is known to the compiler; shaders would be three times as long for it
    if (test == TRIANGLE_WATERTIGHT)
        return any ? mesh_walk(scene, mesh, ray, true, TRIANGLE_WATERTIGHT, unread)
                   : mesh_walk(scene, mesh, ray, false, TRIANGLE_WATERTIGHT, unread);
#endif
    return mesh_walk(scene, mesh, ray, any, test, unread);
}

// What is known of the triangle that was found; `normal` as Hit::normal.
FN void mesh_report_normal(const_in(SceneView) scene, uint mesh, const_in(MeshNearest) nearest, vec3 normal,
                           inout(Hit) hit) {
    if (nearest.triangle == NONE) return;
    hit.t = nearest.hit.t;
    hit.primitive = nearest.triangle - scene.meshes.at[mesh].triangle_first;
    hit.face = 0u;
    hit.cell = ivec3(0);
    hit.uv = vec2(nearest.hit.u, nearest.hit.v);
    hit.normal = normal;
}

FN void mesh_report(const_in(SceneView) scene, uint mesh, const_in(MeshNearest) nearest, inout(Hit) hit) {
    if (nearest.triangle == NONE) return;
    Triangle triangle = scene.triangles.at[nearest.triangle];
    mesh_report_normal(scene, mesh, nearest, cross(triangle.b - triangle.a, triangle.c - triangle.a), hit);
}

// The nearest triangle in (ray.t_min, hit.t), in the mesh's local space. Sets t, primitive (in the structure's order),
// uv and normal; leaves `hit` alone if there is none.
FN void mesh_closest(const_in(SceneView) scene, uint mesh, Ray ray, inout(Hit) hit) {
    if (scene.meshes.at[mesh].triangle_count == 0u) return;
    Ray limited = Ray(ray.origin, ray.t_min, ray.direction, hit.t);
#ifdef __cplusplus
    if (mesh_is_devices(scene, mesh)) {
        WideNearest found = device_mesh_wide(scene, mesh, limited, false);
        mesh_report_normal(scene, mesh, found.nearest, found.normal, hit);
        return;
    }
#endif
    mesh_report(scene, mesh, mesh_nearest(scene, mesh, limited, false), hit);
}

// Whether any triangle lies in (ray.t_min, ray.t_max).
FN bool mesh_any(const_in(SceneView) scene, uint mesh, Ray ray) {
    if (scene.meshes.at[mesh].triangle_count == 0u) return false;
#ifdef __cplusplus
    if (mesh_is_devices(scene, mesh)) return device_mesh_wide(scene, mesh, ray, true).nearest.triangle != NONE;
#endif
    return mesh_nearest(scene, mesh, ray, true).triangle != NONE;
}

// The same with what it cost added to `count`.
FN void mesh_closest_counted(const_in(SceneView) scene, uint mesh, Ray ray, inout(Hit) hit, inout(WalkCount) count) {
    if (scene.meshes.at[mesh].triangle_count == 0u) return;
    Ray limited = Ray(ray.origin, ray.t_min, ray.direction, hit.t);
    MeshNearest nearest = mesh_walk(scene, mesh, limited, false, scene.meshes.at[mesh].triangle_test, count);
    mesh_report(scene, mesh, nearest, hit);
}

FN bool mesh_any_counted(const_in(SceneView) scene, uint mesh, Ray ray, inout(WalkCount) count) {
    if (scene.meshes.at[mesh].triangle_count == 0u) return false;
    return mesh_walk(scene, mesh, ray, true, scene.meshes.at[mesh].triangle_test, count).triangle != NONE;
}

KERNELS_END
#endif
