#ifndef SPINEL_KERNELS_MESH_TRIANGLES_H
#define SPINEL_KERNELS_MESH_TRIANGLES_H
// What all walks through the structures of meshes share: the ray as the triangle tests want it, the nearest triangle so
// far, and what was counted on the way.
//
// A walk is written once and compiled anew (FN_ANEW) for the nearest hit and for any, for the usual test and for one
// that is told at run time, with counters and, where nobody reads them, without.
#include "box.h"
#include "triangle.h"
#include "triangle_plane.h"
#include "triangle_unit.h"
KERNELS_BEGIN

// What a ray cost.
struct WalkCount {
    uint steps;  // interior nodes and leaves, or cells, that were visited
    uint boxes;  // tests against boxes, split planes or spheres
    uint tests;  // against triangles, or other primitives
};

FN WalkCount no_count() { return WalkCount(0u, 0u, 0u); }

struct MeshRay {
    Ray ray;
    SlabRay slab;
    TriangleRay sheared;
    bool any;   // the first triangle that is found will do
    uint test;  // TRIANGLE_…
    uint triangle_first;
    uint test_first;
};

struct MeshNearest {
    TriangleHit hit;  // hit.t: the limit, as long as there is none
    uint triangle;    // in SceneView::triangles; NONE: none yet
};

FN_ANEW MeshRay mesh_ray(const_in(SceneView) scene, uint mesh, Ray ray, bool any, uint test) {
    MeshRay r;
    r.ray = ray;
    float padding = slab_padding(scene.meshes.at[mesh].lower, scene.meshes.at[mesh].upper, ray.origin);
    r.slab = slab_ray(ray, padding);
    r.sheared = triangle_ray(ray);
    r.any = any;
    r.test = test;
    r.triangle_first = scene.meshes.at[mesh].triangle_first;
    r.test_first = scene.meshes.at[mesh].test_first;
    return r;
}

FN bool mesh_other_test(const_in(SceneView) scene, const_in(MeshRay) ray, uint i, float t_max, inout(TriangleHit) hit) {
    switch (ray.test) {
        case TRIANGLE_MOLLER_TRUMBORE:
            return triangle_moller_trumbore(ray.ray, scene.triangles.at[i], ray.ray.t_min, t_max, hit);
        case TRIANGLE_PLANE: return triangle_plane(ray.ray, scene.triangles.at[i], ray.ray.t_min, t_max, hit);
        case TRIANGLE_UNIT:
            return triangle_unit(ray.ray, scene.unit_triangles.at[ray.test_first + i - ray.triangle_first],
                                 ray.ray.t_min, t_max, hit);
        case TRIANGLE_INDEXED: {
            uvec3 v = scene.triangle_infos.at[i].vertices;
            Triangle triangle =
                Triangle(scene.positions.at[ray.test_first + v.x], scene.positions.at[ray.test_first + v.y],
                         scene.positions.at[ray.test_first + v.z]);
            return triangle_watertight(ray.sheared, triangle, ray.ray.t_min, t_max, hit);
        }
    }
    return false;
}

// Tests triangle i of SceneView::triangles; true if it is nearer than what was found before, or as near and stands
// before it, so that the answer does not depend on the order in which a walk comes by.
FN_ANEW bool mesh_test(const_in(SceneView) scene, const_in(MeshRay) ray, uint i, inout(MeshNearest) nearest) {
    float t_max = nearest.triangle != NONE && i < nearest.triangle ? next_above(nearest.hit.t) : nearest.hit.t;
    bool nearer = ray.test == TRIANGLE_WATERTIGHT
                      ? triangle_watertight(ray.sheared, scene.triangles.at[i], ray.ray.t_min, t_max, nearest.hit)
                      : mesh_other_test(scene, ray, i, t_max, nearest.hit);
    if (nearer) nearest.triangle = i;
    return nearer;
}

KERNELS_END
#endif
