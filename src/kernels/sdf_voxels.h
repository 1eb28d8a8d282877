#ifndef SPINEL_KERNELS_SDF_VOXELS_H
#define SPINEL_KERNELS_SDF_VOXELS_H
// Rays against voxels that are not stored: a cell is solid where an SDF is not positive in the cell's middle. Far from
// the surface the ray goes by sphere tracing (Hart 1996), near it cell by cell, as the walk over a tree does.
//
// A cell is known to be empty if its middle is nearer to a place than the surface is. Both the ray and the middle of
// the cell that it is in lie within half a diagonal of each other, here and at the end of a step; so while the distance
// asked in the middle of the ray's cell exceeds a whole diagonal, by that excess the ray may go on unseen. Cells that
// are skipped are empty for sure, and all others are visited with crossings computed from the planes' integer
// coordinates: hits are those of the walk over all cells, bit for bit.
#include "voxels.h"
KERNELS_BEGIN

const float VOXEL_DIAGONAL = 1.7330f;  // √3, and what rounding may add

FN void sdf_voxels_closest(const_in(SceneView) scene, uint grid_index, uint slot_first, Ray ray, inout(Hit) hit) {
    RECORD(VoxelGrid) grid = scene.voxel_grids.at[grid_index];
    ivec3 size = grid.size;
    VoxelRay r = voxel_ray(size, ray);
    if (!(r.enter < r.leave) || r.enter >= hit.t) return;
    vec3 o = ray.origin;
    vec3 d = ray.direction;
    float cells =
        0.9999f / (scene.sdfs.at[grid.sdf].lipschitz * grid.sdf_cell);  // a distance bound in cells is f times
    float inverse_speed = 1.0f / length(d);

    ivec3 cell = voxel_first_cell(size, ray, r);
    float f = voxel_sdf(scene, grid, cell);
    uint palette = f <= 0.0f ? voxel_stratum(scene, grid, cell.y) : 0u;
    uint medium = voxel_class(scene, slot_first, palette);
    if (voxel_first_hit(ray, r, cell, palette, medium, hit)) return;

    // A step leaves a cell for good along one axis, or goes on by a cell's edge at least.
    float t = r.enter;
    int steps = 3 * (size.x + size.y + size.z);
    for (int i = 0; i < steps; ++i) {
        float safe = palette == 0u ? f * cells - VOXEL_DIAGONAL : 0.0f;
        if (safe > 1.0f) {
            float further = t + safe * inverse_speed;
            if (further >= hit.t || further >= r.leave) return;
            ivec3 there = ivec3(voxel_cell(o.x, d.x, r.inverse.x, further, true, 0, size.x - 1),
                                voxel_cell(o.y, d.y, r.inverse.y, further, true, 0, size.y - 1),
                                voxel_cell(o.z, d.z, r.inverse.z, further, true, 0, size.z - 1));
            float there_f = voxel_sdf(scene, grid, there);
            if (there_f > 0.0f) {
                cell = there;
                f = there_f;
                t = further;
                continue;
            }
        }
        VoxelStep step = voxel_step(ray, r, cell, 0u);
        t = step.t;
        if (t >= hit.t) return;
        ivec3 next = step.next;
        bool inside =
            next.x >= 0 && next.y >= 0 && next.z >= 0 && next.x < size.x && next.y < size.y && next.z < size.z;
        f = inside ? voxel_sdf(scene, grid, next) : 1.0f;
        uint entered_palette = f <= 0.0f ? voxel_stratum(scene, grid, next.y) : 0u;
        if (entered_palette != palette) {
            uint entered = voxel_class(scene, slot_first, entered_palette);
            if (entered != medium) {
                bool forward = component(d, step.axis) > 0.0f;
                if (entered == VOXEL_AIR) voxel_hit(ray, t, cell, palette, step.axis, forward, hit);
                else voxel_hit(ray, t, next, entered_palette, step.axis, !forward, hit);
                return;
            }
            palette = entered_palette;
        }
        if (!inside) return;
        cell = next;
    }
}

KERNELS_END
#endif
