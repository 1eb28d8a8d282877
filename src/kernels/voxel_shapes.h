#ifndef SPINEL_KERNELS_VOXEL_SHAPES_H
#define SPINEL_KERNELS_VOXEL_SHAPES_H
// Voxels that fill a part of their cells only, by palette index: rounded ones (voxel_rounding.h) and water with waves
// (voxel_waves.h). The rest of their cells is air. The walk is that of voxels.h, cell by cell where a voxel may have a
// shape; a surface is where the medium changes, be it at a face or inside of a cell, so what a ray is in is known at
// every step and nothing leaks.
//
// VoxelGrid::shape_first has a number for each palette index: 0: fills its cell; above 0: radius of its edges in cells;
// below: waves, where air lies above.
#include "voxel_rounding.h"
#include "voxel_waves.h"
#include "voxels.h"
KERNELS_BEGIN

FN float voxel_shape(const_in(SceneView) scene, const_in(VoxelGrid) grid, uint palette) {
    return palette == 0u ? 0.0f : scene.floats.at[grid.shape_first + palette - 1u];
}

// A cell with its shape worked out.
struct VoxelPart {
    float shape;  // 0: the voxel fills the cell, or it is empty
    RoundedVoxel rounded;
};

FN bool voxel_is_air(const_in(SceneView) scene, const_in(VoxelGrid) grid, uint slot_first, ivec3 cell) {
    return voxel_class(scene, slot_first, voxel_in_tree(scene, grid, cell)) == VOXEL_AIR;
}

FN VoxelPart voxel_part(const_in(SceneView) scene, const_in(VoxelGrid) grid, uint slot_first, ivec3 cell,
                        uint palette) {
    VoxelPart part = VoxelPart(voxel_shape(scene, grid, palette), rounded_voxel(0.0f, 0u));
    if (part.shape == 0.0f) return part;
    // What is round asks across all faces, waves ask above.
    bool round = part.shape > 0.0f;
    uint exposed = 0u;
    for (uint face = round ? 0u : 3u; face < (round ? 6u : 4u); ++face) {
        ivec3 neighbour = cell;
        neighbour[face >> 1u] += (face & 1u) != 0u ? 1 : -1;
        if (voxel_is_air(scene, grid, slot_first, neighbour)) exposed |= 1u << face;
    }
    if (round) part.rounded = rounded_voxel(part.shape, exposed);
    else if (exposed == 0u) part.shape = 0.0f;
    return part;
}

// Whether the voxel is there at a point of its cell.
FN bool voxel_holds(const_in(SceneView) scene, const_in(VoxelGrid) grid, const_in(VoxelPart) part, ivec3 cell, vec3 p) {
    if (part.shape > 0.0f) return rounded_holds(part.rounded, clamp(p - vec3(cell), vec3(0.0f), vec3(1.0f)));
    if (part.shape < 0.0f) return wave_above(scene, grid, cell.y, p) <= 0.0f;
    return true;
}

// Palette index at a point, 0 in the air: beside a shape, or where a slot holds nothing.
FN uint voxel_at_point(const_in(SceneView) scene, const_in(VoxelGrid) grid, uint slot_first, vec3 p) {
    ivec3 cell = ivec3(floor(p));
    uint palette = voxel_at(scene, grid, cell);
    if (voxel_class(scene, slot_first, palette) == VOXEL_AIR) return 0u;
    if (grid.walk != VOXEL_WALK_SHAPES) return palette;
    VoxelPart part = voxel_part(scene, grid, slot_first, cell, palette);
    return voxel_holds(scene, grid, part, cell, p) ? palette : 0u;
}

// The surface inside of a cell that the ray passes between t0 and t1, having begun on one side of it.
FN void voxel_inner_hit(const_in(SceneView) scene, const_in(VoxelGrid) grid, const_in(VoxelPart) part, ivec3 cell,
                        uint palette, Ray ray, float t0, float t1, bool begins_in, inout(Hit) hit) {
    float t = INFINITE;
    vec3 normal = vec3(0.0f);
    if (part.shape > 0.0f) {
        if (begins_in) return;  // what is round is opaque
        vec3 p = clamp(ray_at(ray, t0) - vec3(cell), vec3(0.0f), vec3(1.0f));
        float s = rounded_entry(part.rounded, p, ray.direction, t1 - t0);
        if (s >= INFINITE) return;
        t = t0 + s;
        normal = rounded_from_core(part.rounded, p + s * ray.direction);
    } else {
        t = wave_crossing(scene, grid, cell.y, ray, t0, t1, begins_in);
        if (t >= INFINITE) return;
        vec3 p = ray_at(ray, t);
        normal = wave_normal(scene, grid, p.x, p.z);
        // At grazing incidence the normal may disagree with the crossing; mirrored, it agrees.
        float cosine = dot(normal, ray.direction);
        if ((cosine > 0.0f) != begins_in)
            normal = normal - (2.0f * cosine / dot(ray.direction, ray.direction)) * ray.direction;
    }
    t = max(t, ray.t_min + max(abs(ray.t_min) * 2.4e-7f, TINY_DIRECTION));
    if (t >= hit.t) return;
    vec3 m = abs(normal);
    uint axis = m.x >= m.y && m.x >= m.z ? 0u : (m.y >= m.z ? 1u : 2u);
    voxel_hit(ray, t, cell, palette, axis, component(normal, axis) > 0.0f, hit);
    hit.face |= VOXEL_FACE_INNER;
    hit.normal = is_black(normal) ? -ray.direction : normal;
}

// A hit inside of a cell as near to its surface as floats allow, however far the ray came.
FN vec3 voxel_inner_position(const_in(SceneView) scene, const_in(VoxelGrid) grid, const_in(Hit) hit, vec3 p) {
    float shape = voxel_shape(scene, grid, hit.primitive);
    if (shape < 0.0f) return vec3(p.x, float(hit.cell.y) + wave_height(scene, grid, p.x, p.z), p.z);
    vec3 n = hit.normal;  // zero along the axes on which the core goes on
    vec3 core = p - vec3(hit.cell);
    vec3 q = core;
    if (n.x != 0.0f) core.x = n.x > 0.0f ? 1.0f - shape : shape;
    if (n.y != 0.0f) core.y = n.y > 0.0f ? 1.0f - shape : shape;
    if (n.z != 0.0f) core.z = n.z > 0.0f ? 1.0f - shape : shape;
    float size = length(q - core);
    if (!(size > 0.0f)) return p;
    return vec3(hit.cell) + core + (q - core) * (shape * 1.000001f / size);
}

FN void shaped_voxels_closest(const_in(SceneView) scene, uint grid_index, uint slot_first, Ray ray, inout(Hit) hit) {
    RECORD(VoxelGrid) grid = scene.voxel_grids.at[grid_index];
    ivec3 size = grid.size;
    VoxelRay r = voxel_ray(size, ray);
    if (!(r.enter < r.leave) || r.enter >= hit.t) return;
    vec3 d = ray.direction;

    ivec3 cell = voxel_first_cell(size, ray, r);
    VoxelStack stack;
    uint top = grid.level_count - 1u;
    stack.node[top] = grid.root;
    VoxelCube cube = voxel_cube(scene, grid, cell, top, stack);
    uint palette = cube.palette;
    vec3 p = ray_at(ray, r.enter);
    if (r.from_outside) p[r.enter_axis] = component(d, r.enter_axis) > 0.0f ? 0.0f : float(size[r.enter_axis]);

    ivec3 next = cell;
    bool inside = true;
    uint left_palette = 0u;
    uint medium = VOXEL_AIR;
    uint axis = 0u;
    bool forward = false;
    float t = r.enter;
    int steps = size.x + size.y + size.z;
    for (int i = 0; i <= steps; ++i) {
        VoxelPart part = voxel_part(scene, grid, slot_first, next, palette);
        uint entered = voxel_holds(scene, grid, part, next, p) ? voxel_class(scene, slot_first, palette) : VOXEL_AIR;
        if (i == 0) {
            if (voxel_first_hit(ray, r, next, palette, entered, hit)) return;
            medium = entered;
        } else if (entered != medium) {
            if (entered == VOXEL_AIR) {
                ivec3 left = next;
                left[axis] += forward ? -1 : 1;
                voxel_hit(ray, t, left, left_palette, axis, forward, hit);
                if (palette != 0u) hit.face |= VOXEL_FACE_TO_AIR;
            } else {
                voxel_hit(ray, t, next, palette, axis, !forward, hit);
                if (medium == VOXEL_AIR && left_palette != 0u) hit.face |= VOXEL_FACE_TO_AIR;
            }
            return;
        }
        if (!inside) return;
        cell = next;
        bool may_have_shape = voxel_shape(scene, grid, palette) != 0.0f;
        VoxelStep step = voxel_step(ray, r, cell, may_have_shape ? 0u : cube.log2_edge);
        if (part.shape != 0.0f) {
            float before = hit.t;
            voxel_inner_hit(scene, grid, part, cell, palette, ray, t, step.t, medium != VOXEL_AIR, hit);
            if (hit.t < before) return;
        }
        t = step.t;
        if (t >= hit.t) return;
        next = step.next;
        axis = step.axis;
        forward = component(d, axis) > 0.0f;
        inside = voxel_in_set(grid, next);
        left_palette = palette;
        if (!inside) {
            palette = 0u;
        } else {
            uint changed = uint((cell.x ^ next.x) | (cell.y ^ next.y) | (cell.z ^ next.z));
            if ((changed >> cube.log2_edge) != 0u) {  // else: still in the same cube
                cube = voxel_cube(scene, grid, next, (31u - leading_zeros32(changed)) >> 1u, stack);
                palette = cube.palette;
            }
        }
        p = ray_at(ray, t);
        p[axis] = float(next[axis] + (forward ? 0 : 1));
    }
}

KERNELS_END
#endif
