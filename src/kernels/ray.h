#ifndef SPINEL_KERNELS_RAY_H
#define SPINEL_KERNELS_RAY_H
#include "constants.h"
KERNELS_BEGIN

// A segment origin + t·direction with t in the open interval (t_min, t_max), in units of |direction|, which need not be
// one: rays are carried into local spaces by transforming both members, so that t means the same in every space.
struct Ray {
    vec3 origin;
    float t_min;
    vec3 direction;
    float t_max;
};

// What a traversal knows of the nearest surface: enough to rebuild the rest (see surface.h), and no more.
struct Hit {
    float t;         // INFINITE: nothing was hit
    uint instance;   // index into SceneView::instances
    uint primitive;  // mesh: triangle, in the order of the acceleration structure; voxels: palette index
                     // of the cell that was entered (or left, into air); sphere, plane, rectangle, SDF: 0; box: face 0
                     // … 5
    uint face;       // voxels: 2·axis + (1 if the outward normal points to +axis), VOXEL_FACE_… added; otherwise 0
    vec2 uv;  // mesh: barycentric weights of vertices 1 and 2; voxels, box, rectangle: position on the face in [0,1]²
    ivec3 cell;   // voxels: the voxel that was hit, else 0
    vec3 normal;  // geometric normal in local space, pointing out of the solid, not normalised
};

// Of voxels that do not fill their cells (voxel_shapes.h).
const uint VOXEL_FACE_INNER = 8u;    // the surface lies inside of the cell, `normal` is its own; air is outside of it
const uint VOXEL_FACE_TO_AIR = 16u;  // air lies across the face, whatever voxel stands in the next cell

FN Hit no_hit(float t_max) { return Hit(t_max, NONE, 0u, 0u, vec2(0.0f), ivec3(0), vec3(0.0f)); }
FN bool is_hit(const_in(Hit) hit) { return hit.instance != NONE; }

// The next number above t, which is finite.
FN float next_above(float t) {
    if (t == 0.0f) return bits_float(1u);
    return t > 0.0f ? bits_float(float_bits(t) + 1u) : bits_float(float_bits(t) - 1u);
}

FN vec3 ray_at(Ray ray, float t) { return ray.origin + t * ray.direction; }

KERNELS_END
#endif
