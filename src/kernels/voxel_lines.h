#ifndef SPINEL_KERNELS_VOXEL_LINES_H
#define SPINEL_KERNELS_VOXEL_LINES_H
// Outlines: lines of a colour along the edges of voxels, drawn on the faces. Every voxel may have them, or only edges
// where something ends: the visible shape, or the shape or the palette index.
//
// Half of a line's width lies on each of the two faces that share an edge. In SceneView::floats at
// VoxelGrid::line_first: VOXEL_LINES_… as a number, half the width in cells, strength, red, green, blue.
#include "voxels.h"
KERNELS_BEGIN

const uint VOXEL_LINES_ALL = 0u;
const uint VOXEL_LINES_CHANGES = 1u;
const uint VOXEL_LINES_SHAPE = 2u;

// Whether the face of `palette` under `above` ends before the neighbouring cell, `above` being what lies across it.
FN bool voxel_face_ends(const_in(SceneView) scene, const_in(VoxelGrid) grid, uint mode, uint palette, uint above,
                        ivec3 neighbour, ivec3 normal) {
    uint there = voxel_at(scene, grid, neighbour);
    if (there == 0u) return true;
    uint across = voxel_at(scene, grid, neighbour + normal);
    if ((across == 0u) != (above == 0u)) return true;
    return mode == VOXEL_LINES_CHANGES && (there != palette || across != above);
}

// Colour (xyz) and strength (w) of the line at a place on a face of a cell; uv as in Hit.
FN vec4 voxel_line(const_in(SceneView) scene, const_in(VoxelGrid) grid, ivec3 cell, uint axis, bool positive, vec2 uv) {
    uint first = grid.line_first;
    float width = scene.floats.at[first + 1u];
    ivec3 u = ivec3(0);
    ivec3 v = ivec3(0);
    u[(axis + 1u) % 3u] = uv.x < width ? -1 : (uv.x > 1.0f - width ? 1 : 0);
    v[(axis + 2u) % 3u] = uv.y < width ? -1 : (uv.y > 1.0f - width ? 1 : 0);
    bool at_u = uv.x < width || uv.x > 1.0f - width;
    bool at_v = uv.y < width || uv.y > 1.0f - width;
    bool drawn = at_u || at_v;
    uint mode = uint(scene.floats.at[first]);
    if (drawn && mode != VOXEL_LINES_ALL) {
        ivec3 normal = ivec3(0);
        normal[axis] = positive ? 1 : -1;
        uint palette = voxel_at(scene, grid, cell);
        uint above = voxel_at(scene, grid, cell + normal);
        drawn = false;
        if (at_u) drawn = voxel_face_ends(scene, grid, mode, palette, above, cell + u, normal);
        if (at_v && !drawn) drawn = voxel_face_ends(scene, grid, mode, palette, above, cell + v, normal);
        if (at_u && at_v && !drawn)  // where two lines of other faces meet in this one's corner
            drawn = voxel_face_ends(scene, grid, mode, palette, above, cell + u + v, normal);
    }
    if (!drawn) return vec4(0.0f);
    return vec4(scene.floats.at[first + 3u], scene.floats.at[first + 4u], scene.floats.at[first + 5u],
                scene.floats.at[first + 2u]);
}

KERNELS_END
#endif
