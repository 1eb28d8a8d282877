#ifndef SPINEL_KERNELS_GRID_STREAM_H
#define SPINEL_KERNELS_GRID_STREAM_H
// The walk of mesh_grid.h cut into steps, for whole batches of rays that go through a uniform grid together: in every
// pass all rays that walk go on to the next cell that is not empty, and then all that stand in one test its triangles.
// Each of the two is a loop, or a dispatch, over rays that do the same. What a ray does next is its state.
#include "mesh_grid.h"
KERNELS_BEGIN

// 0 and above: waits, in a cell whose list stands there among the references.
const int STREAM_ACTIVE = -10;    // walks
const int STREAM_INACTIVE = -20;  // has found its triangle
const int STREAM_OVERFLOW = -30;  // stands in a cell, but this pass has no more room for rays that wait
const int STREAM_DEAD = -50;      // has left the grid, or ended, with nothing

struct StreamRay {
    int state;
    float enter;
    uint list;  // of the cell that it stands in
    GridWalk walk;
    Mailbox mailbox;
    MeshNearest nearest;
};

FN int stream_end(const_in(MeshNearest) nearest) { return nearest.triangle == NONE ? STREAM_DEAD : STREAM_INACTIVE; }

FN StreamRay stream_begin(const_in(SceneView) scene, uint mesh, const_in(MeshRay) ray, inout(WalkCount) count) {
    StreamRay s;
    s.nearest = MeshNearest(TriangleHit(ray.ray.t_max, 0.0f, 0.0f), NONE);
    s.list = 0u;
    for (uint i = 0u; i < GRID_MAILBOX; ++i) s.mailbox.triangle[i] = NONE;
    vec3 lower = scene.meshes.at[mesh].lower;
    vec3 upper = scene.meshes.at[mesh].upper;
    uint grid = scene.meshes.at[mesh].node_first;
    vec2 span = slab_interval(lower, upper, ray.slab, ray.ray.t_max);
    ++count.boxes;
    s.enter = span.x;
    s.state = STREAM_ACTIVE;
    if (span.x > span.y) {
        s.walk = grid_open(scene, grid, ray);
        s.state = STREAM_DEAD;
        return s;
    }
    if (!grid_in_reach(scene, grid, grid_shortest(ray.ray.origin, lower, upper))) {
        s.walk = grid_open(scene, grid, ray);
        mesh_grid_walk(scene, mesh, ray, s.nearest, count);  // as one: it asks every triangle
        s.state = stream_end(s.nearest);
        return s;
    }
    s.walk = grid_enter(scene, grid, ray, s.enter);
    return s;
}

FN float stream_leave(const_in(StreamRay) s) { return min(s.walk.next.x, min(s.walk.next.y, s.walk.next.z)); }

// On from a cell that is done with.
FN void stream_step(const_in(MeshRay) ray, inout(StreamRay) s) {
    float leave = stream_leave(s);
    if (s.nearest.hit.t <= leave || !grid_step(s.walk, ray.ray.direction)) {
        s.state = stream_end(s.nearest);
        return;
    }
    s.enter = max(s.enter, leave);
    s.state = STREAM_ACTIVE;
}

// Walks to the next cell with triangles: then `list` is not 0, and the ray is to wait; or to the end.
FN void stream_advance(const_in(SceneView) scene, uint mesh, const_in(MeshRay) ray, inout(StreamRay) s,
                       inout(WalkCount) count) {
    uint reference_first = scene.meshes.at[mesh].reference_first;
    while (s.state == STREAM_ACTIVE) {  // no more cells than a line passes
        ++count.steps;
        uint content = grid_cell(scene, reference_first, s.walk);
        if (content != 0u) {
            s.list = reference_first + content;
            return;
        }
        stream_step(ray, s);
    }
}

// Tests the triangles of the cell that the ray waits in.
FN void stream_test(const_in(SceneView) scene, const_in(MeshRay) ray, inout(StreamRay) s, inout(WalkCount) count) {
    if (grid_list(scene, ray, s.list, s.mailbox, s.nearest, count)) {
        s.state = STREAM_INACTIVE;
        return;
    }
    stream_step(ray, s);
}

KERNELS_END
#endif
