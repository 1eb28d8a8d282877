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

    // The SDF is asked in one place, for the reason that sdf_crossing() has: in the cell where the walk begins, where a
    // leap would lead, or in the next cell.
    ivec3 cell = ivec3(0);
    ivec3 next = voxel_first_cell(size, ray, r);
    float t = r.enter;
    uint palette = 0u;
    uint medium = VOXEL_AIR;
    bool leaping = false;
    float further = 0.0f;
    VoxelStep step;
    step.axis = 0u;
    // A step leaves a cell for good along one axis, or goes on by a cell's edge at least; a leap may be asked for
    // before.
    int asked = 1 + 6 * (size.x + size.y + size.z);
    for (int i = 0; i < asked; ++i) {
        bool inside = voxel_in_set(grid, next);
        float f = inside ? voxel_sdf(scene, grid, next) : 1.0f;
        float safe = 0.0f;
        if (!leaping) {
            uint entered_palette = f <= 0.0f ? voxel_stratum(scene, grid, next.y) : 0u;
            if (i == 0 || entered_palette != palette) {
                uint entered = voxel_class(scene, slot_first, entered_palette);
                if (i == 0) {
                    if (voxel_first_hit(ray, r, next, entered_palette, entered, hit)) return;
                    medium = entered;
                } else if (entered != medium) {
                    bool forward = component(d, step.axis) > 0.0f;
                    if (entered == VOXEL_AIR) voxel_hit(ray, t, cell, palette, step.axis, forward, hit);
                    else voxel_hit(ray, t, next, entered_palette, step.axis, !forward, hit);
                    return;
                }
                palette = entered_palette;
            }
            if (!inside) return;
            cell = next;
            if (palette == 0u) safe = f * cells - VOXEL_DIAGONAL;
        } else if (f > 0.0f) {
            t = further;
            cell = next;
            safe = f * cells - VOXEL_DIAGONAL;
        }
        leaping = safe > 1.0f;
        if (leaping) {
            further = t + safe * inverse_speed;
            if (further >= hit.t || further >= r.leave) return;
            next = ivec3(voxel_cell(o.x, d.x, r.inverse.x, further, true, 0, size.x - 1),
                         voxel_cell(o.y, d.y, r.inverse.y, further, true, 0, size.y - 1),
                         voxel_cell(o.z, d.z, r.inverse.z, further, true, 0, size.z - 1));
        } else {
            step = voxel_step(ray, r, cell, 0u);
            t = step.t;
            if (t >= hit.t) return;
            next = step.next;
        }
    }
}

KERNELS_END
#endif
