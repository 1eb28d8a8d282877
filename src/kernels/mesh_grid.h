#ifndef SPINEL_KERNELS_MESH_GRID_H
#define SPINEL_KERNELS_MESH_GRID_H
// The walk through a uniform or hierarchical grid of cells. Amanatides and Woo, "A Fast Voxel Traversal Algorithm for
// Ray Tracing", Eurographics 1987; a cell may be a grid itself, where much lies close together (Jevans and Wyvill,
// "Adaptive Voxel Subdivision for Ray Tracing", Graphics Interface 1989).
//
// Cells are visited in the order in which the ray passes them. A triangle lies in many cells, so a hit counts only
// where it lies within the current one: what is farther is kept, as something nearer may stand before it. And it is not
// tested twice: a mailbox remembers the last few.
//
// Crossings are computed from the cells' integer coordinates, not accumulated. Cells own what comes within GRID_MARGIN
// of a cell's edge to them, and more than that no rounding moves a ray which begins within GRID_REACH of these cells of
// the mesh. From farther away floats cannot tell one cell from the next: to such a ray a grid within a cell is that
// cell's list, and if the first grid is too fine, it asks every triangle.
#include "mesh_triangles.h"
KERNELS_BEGIN

const float GRID_MARGIN = 1.0f / 16.0f;  // of a cell's edge
const float GRID_REACH = 32768.0f;       // cells
const uint GRID_MAX_LEVELS = 4u;
const int GRID_MAX_CELLS = 1024;  // along an axis
const uint GRID_MAILBOX = 8u;

// A ray in one grid.
struct GridWalk {
    uint grid;  // into SceneView::mesh_grids
    ivec3 size;
    ivec3 cell;
    vec3 origin;   // in cells
    vec3 inverse;  // t for each cell along an axis
    vec3 next;     // t where the ray leaves the cell along each axis
};

struct GridStack {
    uint grid[GRID_MAX_LEVELS];
    ivec3 cell[GRID_MAX_LEVELS];
};

struct Mailbox {
    uint triangle[GRID_MAILBOX];
};

FN float grid_crossing(const_in(GridWalk) walk, vec3 direction, uint axis) {
    float d = component(direction, axis);
    if (abs(d) < TINY_DIRECTION) return INFINITE;
    float plane = component(vec3(walk.cell), axis) + (d > 0.0f ? 1.0f : 0.0f);
    return (plane - component(walk.origin, axis)) * component(walk.inverse, axis);
}

FN void grid_crossings(inout(GridWalk) walk, vec3 direction) {
    float x = grid_crossing(walk, direction, 0u);
    float y = grid_crossing(walk, direction, 1u);
    float z = grid_crossing(walk, direction, 2u);
    walk.next = vec3(x, y, z);
}

FN GridWalk grid_open(const_in(SceneView) scene, uint grid, const_in(MeshRay) ray) {
    GridWalk walk;
    walk.grid = grid;
    walk.size = scene.mesh_grids.at[grid].size;
    walk.origin = (ray.ray.origin - scene.mesh_grids.at[grid].lower) * scene.mesh_grids.at[grid].inverse_cell;
    walk.inverse = scene.mesh_grids.at[grid].cell * ray.slab.inverse;
    walk.cell = ivec3(0);
    walk.next = vec3(0.0f);
    return walk;
}

// At the cell in which the ray is at t.
FN GridWalk grid_enter(const_in(SceneView) scene, uint grid, const_in(MeshRay) ray, float t) {
    GridWalk walk = grid_open(scene, grid, ray);
    vec3 p = walk.origin + t * ray.ray.direction * scene.mesh_grids.at[grid].inverse_cell;
    walk.cell = clamp(ivec3(floor(clamp(p, vec3(0.0f), vec3(walk.size)))), ivec3(0), walk.size - 1);
    grid_crossings(walk, ray.ray.direction);
    return walk;
}

// Goes to the next cell; false if the ray leaves the grid.
FN bool grid_step(inout(GridWalk) walk, vec3 direction) {
    uint axis =
        walk.next.x < walk.next.y ? (walk.next.x < walk.next.z ? 0u : 2u) : (walk.next.y < walk.next.z ? 1u : 2u);
    if (axis == 0u) {
        walk.cell.x += direction.x > 0.0f ? 1 : -1;
        walk.next.x = grid_crossing(walk, direction, 0u);
        return walk.cell.x >= 0 && walk.cell.x < walk.size.x;
    }
    if (axis == 1u) {
        walk.cell.y += direction.y > 0.0f ? 1 : -1;
        walk.next.y = grid_crossing(walk, direction, 1u);
        return walk.cell.y >= 0 && walk.cell.y < walk.size.y;
    }
    walk.cell.z += direction.z > 0.0f ? 1 : -1;
    walk.next.z = grid_crossing(walk, direction, 2u);
    return walk.cell.z >= 0 && walk.cell.z < walk.size.z;
}

FN uint grid_cell(const_in(SceneView) scene, uint reference_first, const_in(GridWalk) walk) {
    uint i = uint(walk.cell.x + walk.size.x * (walk.cell.y + walk.size.y * walk.cell.z));
    return scene.words.at[reference_first + scene.mesh_grids.at[walk.grid].cell_first + i];
}

// Cells of longer edges than these are in reach of a ray that begins there: rounding moves it by less than their
// margin.
FN vec3 grid_shortest(vec3 origin, vec3 lower, vec3 upper) {
    return max(abs(origin - lower), abs(origin - upper)) / GRID_REACH;
}

FN bool grid_in_reach(const_in(SceneView) scene, uint grid, vec3 shortest) {
    vec3 cell = scene.mesh_grids.at[grid].cell;
    return shortest.x < cell.x && shortest.y < cell.y && shortest.z < cell.z;
}

// Tests a cell's triangles; true if one is found and any will do.
FN_ANEW bool grid_list(const_in(SceneView) scene, const_in(MeshRay) ray, uint list, inout(Mailbox) mailbox,
                       inout(MeshNearest) nearest, inout(WalkCount) count) {
    uint end = list + 1u + scene.words.at[list];
    for (uint i = list + 1u; i < end; ++i) {
        uint triangle = scene.words.at[i];
        uint slot = triangle % GRID_MAILBOX;
        if (mailbox.triangle[slot] == triangle) continue;
        mailbox.triangle[slot] = triangle;
        ++count.tests;
        if (mesh_test(scene, ray, ray.triangle_first + triangle, nearest) && ray.any) return true;
    }
    return false;
}

FN_ANEW void mesh_grid_walk(const_in(SceneView) scene, uint mesh, const_in(MeshRay) ray, inout(MeshNearest) nearest,
                            inout(WalkCount) count) {
    vec3 lower = scene.meshes.at[mesh].lower;
    vec3 upper = scene.meshes.at[mesh].upper;
    uint grid_first = scene.meshes.at[mesh].node_first;
    uint reference_first = scene.meshes.at[mesh].reference_first;
    vec2 span = slab_interval(lower, upper, ray.slab, nearest.hit.t);
    ++count.boxes;
    if (span.x > span.y) return;
    vec3 shortest = grid_shortest(ray.ray.origin, lower, upper);
    if (!grid_in_reach(scene, grid_first, shortest)) {
        uint end = ray.triangle_first + scene.meshes.at[mesh].triangle_count;
        for (uint i = ray.triangle_first; i < end; ++i) {
            ++count.tests;
            if (mesh_test(scene, ray, i, nearest) && ray.any) return;
        }
        return;
    }
    Mailbox mailbox;
    for (uint i = 0u; i < GRID_MAILBOX; ++i) mailbox.triangle[i] = NONE;
    GridStack stack;
    uint level = 0u;
    float enter = span.x;
    GridWalk walk = grid_enter(scene, grid_first, ray, enter);
    for (;;) {
        ++count.steps;
        uint content = grid_cell(scene, reference_first, walk);
        float leave = min(walk.next.x, min(walk.next.y, walk.next.z));
        if ((content & GRID_REFINED) != 0u) {
            uint inner = grid_first + (content ^ GRID_REFINED);
            if (grid_in_reach(scene, inner, shortest)) {
                stack.grid[level] = walk.grid;
                stack.cell[level] = walk.cell;
                ++level;
                walk = grid_enter(scene, inner, ray, enter);
                continue;
            }
            content = scene.words.at[reference_first + scene.mesh_grids.at[inner].cell_first - 1u];
        }
        if (content != 0u && grid_list(scene, ray, reference_first + content, mailbox, nearest, count)) return;
        for (;;) {
            if (nearest.hit.t <= leave) return;  // within the cell, or the end of the ray
            enter = max(enter, leave);
            if (grid_step(walk, ray.ray.direction)) break;
            if (level == 0u) return;
            --level;
            walk = grid_open(scene, stack.grid[level], ray);
            walk.cell = stack.cell[level];
            grid_crossings(walk, ray.ray.direction);
            leave = min(walk.next.x, min(walk.next.y, walk.next.z));
        }
    }
}

KERNELS_END
#endif
