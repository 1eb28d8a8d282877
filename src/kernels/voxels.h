#ifndef SPINEL_KERNELS_VOXELS_H
#define SPINEL_KERNELS_VOXELS_H
// Rays against a grid of voxels, by a 3D-DDA: Amanatides, Woo, "A Fast Voxel Traversal Algorithm for Ray
// Tracing", Eurographics 1987; but every crossing is computed from its plane's integer coordinate instead of
// being accumulated, so that the error does not grow along the ray and two cells agree exactly about the face
// between them.
//
// Space is a partition into media. A cell belongs to a class: air (palette 0, or outside of the grid), opaque
// (a material without an interior), or the interior of its slot. A surface is a face between cells of
// different classes: a block of glass is one solid however many palette entries it is made of, glass in water
// has one interface, and nothing lies inside what is opaque. The face belongs to the cell that is entered,
// or, into air, to the cell that is left.
//
// A ray starts in the cell of origin + t_min·direction; a plane that it reaches at t_min exactly counts as
// passed, and where it runs along a plane (a zero component), floor() decides. A ray that starts in an opaque
// cell sees that cell: it hits at the next number above t_min, on the face that opposes the direction's
// largest component.
#include "box.h"
#include "scene_view.h"
KERNELS_BEGIN

const uint VOXEL_AIR = 0xfffffffeu;
const uint VOXEL_OPAQUE = NONE;  // anything else is an index into SceneView::interiors

// A slot with neither material nor interior bounds nothing: air.
FN uint voxel_class(const_in(SceneView) scene, uint slot_first, uint palette) {
    if (palette == 0u) return VOXEL_AIR;
    Slot slot = scene.slots.at[slot_first + palette - 1u];
    if (slot.interior != NONE) return slot.interior;
    return slot.material == NONE ? VOXEL_AIR : VOXEL_OPAQUE;
}

FN uint voxel_palette(const_in(SceneView) scene, uint word_first, uint cell) {
    return (scene.words.at[word_first + (cell >> 2u)] >> ((cell & 3u) * 8u)) & 255u;
}

FN uint voxel_linear(ivec3 size, ivec3 cell) {
    return uint(cell.x) + uint(size.x) * (uint(cell.y) + uint(size.y) * uint(cell.z));
}

// t at which the ray meets plane number `plane` of an axis.
FN float voxel_plane(int plane, float origin, float inverse) { return (float(plane) - origin) * inverse; }

// The cell along one axis at t: planes met at or before t have been passed. The guess by floor() may be off
// by rounding; the crossings decide, so that the walk never meets a plane twice or not at all.
FN int voxel_start(float origin, float direction, float inverse, float t, int size) {
    if (abs(direction) < TINY_DIRECTION) return int(floor(origin));
    int cell = int(floor(clamp(origin + t * direction, -1.0f, float(size) + 1.0f)));
    if (direction > 0.0f) {
        for (int i = 0; i < 2 && voxel_plane(cell, origin, inverse) > t; ++i) --cell;
        for (int i = 0; i < 2 && voxel_plane(cell + 1, origin, inverse) <= t; ++i) ++cell;
    } else {
        for (int i = 0; i < 2 && voxel_plane(cell + 1, origin, inverse) > t; ++i) ++cell;
        for (int i = 0; i < 2 && voxel_plane(cell, origin, inverse) <= t; ++i) --cell;
    }
    return clamp(cell, 0, size - 1);
}

// Records the face of `owner` on `axis`, on its + side or not.
FN void voxel_hit(ivec3 size, Ray ray, float t, ivec3 owner, uint axis, bool positive, inout(Hit) hit) {
    vec3 p = clamp(ray_at(ray, t) - vec3(owner), vec3(0.0f), vec3(1.0f));
    float s = positive ? 1.0f : -1.0f;
    hit.t = t;
    hit.primitive = voxel_linear(size, owner);
    hit.face = 2u * axis + (positive ? 1u : 0u);
    hit.cell = owner;
    hit.uv = vec2(component(p, (axis + 1u) % 3u), component(p, (axis + 2u) % 3u));
    hit.normal = vec3(axis == 0u ? s : 0.0f, axis == 1u ? s : 0.0f, axis == 2u ? s : 0.0f);
}

// The nearest interface in (ray.t_min, hit.t). Hit.uv runs along the axes axis + 1 and axis + 2 (cyclic).
FN void voxels_closest(const_in(SceneView) scene, uint grid, uint slot_first, Ray ray, inout(Hit) hit) {
    ivec3 size = scene.voxel_grids.at[grid].size;
    uint word_first = scene.voxel_grids.at[grid].word_first;
    vec3 o = ray.origin;
    vec3 d = ray.direction;
    bool still_x = abs(d.x) < TINY_DIRECTION;
    bool still_y = abs(d.y) < TINY_DIRECTION;
    bool still_z = abs(d.z) < TINY_DIRECTION;
    if (still_x && !(o.x >= 0.0f && o.x < float(size.x))) return;
    if (still_y && !(o.y >= 0.0f && o.y < float(size.y))) return;
    if (still_z && !(o.z >= 0.0f && o.z < float(size.z))) return;
    if (still_x && still_y && still_z) return;
    vec3 inverse = vec3(safe_inverse(d.x), safe_inverse(d.y), safe_inverse(d.z));

    // Where the ray is inside the grid, exactly as the walk sees the outermost planes.
    ivec3 positive = ivec3(d.x > 0.0f ? 1 : 0, d.y > 0.0f ? 1 : 0, d.z > 0.0f ? 1 : 0);
    vec3 enter = vec3(still_x ? -INFINITE : voxel_plane(positive.x == 1 ? 0 : size.x, o.x, inverse.x),
                      still_y ? -INFINITE : voxel_plane(positive.y == 1 ? 0 : size.y, o.y, inverse.y),
                      still_z ? -INFINITE : voxel_plane(positive.z == 1 ? 0 : size.z, o.z, inverse.z));
    vec3 leave = vec3(still_x ? INFINITE : voxel_plane(positive.x == 1 ? size.x : 0, o.x, inverse.x),
                      still_y ? INFINITE : voxel_plane(positive.y == 1 ? size.y : 0, o.y, inverse.y),
                      still_z ? INFINITE : voxel_plane(positive.z == 1 ? size.z : 0, o.z, inverse.z));
    uint axis = enter.x >= enter.y && enter.x >= enter.z ? 0u : (enter.y >= enter.z ? 1u : 2u);
    float t = component(enter, axis);
    bool from_outside = t > ray.t_min;
    if (!from_outside) t = ray.t_min;
    if (!(t < min_component(leave)) || t >= hit.t) return;

    ivec3 cell = ivec3(voxel_start(o.x, d.x, inverse.x, t, size.x), voxel_start(o.y, d.y, inverse.y, t, size.y),
                       voxel_start(o.z, d.z, inverse.z, t, size.z));
    uint index = voxel_linear(size, cell);
    uint palette = voxel_palette(scene, word_first, index);
    uint current = voxel_class(scene, slot_first, palette);
    if (from_outside) {
        if (current != VOXEL_AIR) {
            voxel_hit(size, ray, t, cell, axis, component(d, axis) < 0.0f, hit);
            return;
        }
    } else if (current == VOXEL_OPAQUE) {
        vec3 m = abs(d);
        axis = m.x >= m.y && m.x >= m.z ? 0u : (m.y >= m.z ? 1u : 2u);
        t = ray.t_min + max(abs(ray.t_min) * 2.4e-7f, TINY_DIRECTION);
        if (t < hit.t) voxel_hit(size, ray, t, cell, axis, component(d, axis) < 0.0f, hit);
        return;
    }

    vec3 next = vec3(still_x ? INFINITE : voxel_plane(cell.x + positive.x, o.x, inverse.x),
                     still_y ? INFINITE : voxel_plane(cell.y + positive.y, o.y, inverse.y),
                     still_z ? INFINITE : voxel_plane(cell.z + positive.z, o.z, inverse.z));
    uint stride_y = uint(size.x);
    uint stride_z = uint(size.x) * uint(size.y);
    // Each step leaves a cell for good along one axis, so there are at most this many.
    int steps = size.x + size.y + size.z;
    for (int i = 0; i < steps; ++i) {
        ivec3 left = cell;
        bool inside;
        if (next.x <= next.y && next.x <= next.z) {
            axis = 0u;
            t = next.x;
            cell.x += 2 * positive.x - 1;
            index += positive.x == 1 ? 1u : 0xffffffffu;
            next.x = voxel_plane(cell.x + positive.x, o.x, inverse.x);
            inside = cell.x >= 0 && cell.x < size.x;
        } else if (next.y <= next.z) {
            axis = 1u;
            t = next.y;
            cell.y += 2 * positive.y - 1;
            index += positive.y == 1 ? stride_y : 0u - stride_y;
            next.y = voxel_plane(cell.y + positive.y, o.y, inverse.y);
            inside = cell.y >= 0 && cell.y < size.y;
        } else {
            axis = 2u;
            t = next.z;
            cell.z += 2 * positive.z - 1;
            index += positive.z == 1 ? stride_z : 0u - stride_z;
            next.z = voxel_plane(cell.z + positive.z, o.z, inverse.z);
            inside = cell.z >= 0 && cell.z < size.z;
        }
        if (t >= hit.t) return;
        uint entered_palette = inside ? voxel_palette(scene, word_first, index) : 0u;
        if (entered_palette != palette) {
            uint entered = voxel_class(scene, slot_first, entered_palette);
            if (entered != current) {
                bool forward = component(d, axis) > 0.0f;
                if (entered == VOXEL_AIR) {
                    voxel_hit(size, ray, t, left, axis, forward, hit);
                } else {
                    voxel_hit(size, ray, t, cell, axis, !forward, hit);
                }
                return;
            }
            palette = entered_palette;
        }
        if (!inside) return;
    }
}

// Whether any interface lies in (ray.t_min, ray.t_max).
FN bool voxels_any(const_in(SceneView) scene, uint grid, uint slot_first, Ray ray) {
    Hit hit = no_hit(ray.t_max);
    voxels_closest(scene, grid, slot_first, ray, hit);
    return hit.t < ray.t_max;
}

KERNELS_END
#endif
