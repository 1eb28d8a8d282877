#ifndef SPINEL_KERNELS_VOXELS_H
#define SPINEL_KERNELS_VOXELS_H
// Rays against a sparse 64-tree of voxels. Where a cube of any size is known to be of one palette index, empty or
// solid, the ray goes to its exit in one step; what comes next is found from the lowest common ancestor of both cells,
// which the highest differing bit of their coordinates tells (Laine, Karras, "Efficient Sparse Voxel Octrees", I3D
// 2010).
//
// The walk is exact in this sense: it sees the same cells change, in the same order and at the same t, as a 3D-DDA that
// visits every cell (Amanatides, Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987) and
// computes each crossing from its plane's integer coordinate. So two cells agree exactly about the face between them,
// and no ray slips through an edge. Where planes of several axes are met at the same t, x is passed before y and y
// before z.
//
// Space is a partition into media. A cell belongs to a class: air (palette 0, or outside of the set), opaque
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
#include "sdf.h"
KERNELS_BEGIN

const uint VOXEL_AIR = 0xfffffffeu;
const uint VOXEL_OPAQUE = NONE;  // anything else is an index into SceneView::interiors
const uint VOXEL_MAX_LEVELS = 10u;

// A slot with neither material nor interior bounds nothing: air.
FN uint voxel_class(const_in(SceneView) scene, uint slot_first, uint palette) {
    if (palette == 0u) return VOXEL_AIR;
    Slot slot = scene.slots.at[slot_first + palette - 1u];
    if (slot.interior != NONE) return slot.interior;
    return slot.material == NONE ? VOXEL_AIR : VOXEL_OPAQUE;
}

// --------------------------------------------------------------------------------------------------------- the tree
// The palette index of child number `rank` of a node whose children are no nodes.
FN uint voxel_palette(const_in(SceneView) scene, const_in(VoxelGrid) grid, VoxelNode node, uint rank) {
    uint kind = node.link & VOXEL_LINK_KIND;
    uint at = node.link & ~VOXEL_LINK_KIND;
    if (kind == VOXEL_LINK_SOLID) return at;
    uint first = grid.palette_first + at;
    if (kind == VOXEL_LINK_BYTES) return (scene.words.at[first + (rank >> 2u)] >> (8u * (rank & 3u))) & 0xffu;
    return (scene.words.at[first + (rank >> 1u)] >> (16u * (rank & 1u))) & 0xffffu;
}

// Child number `rank` of a node whose children are nodes.
FN VoxelNode voxel_child(const_in(SceneView) scene, const_in(VoxelGrid) grid, VoxelNode node, uint rank) {
    uint at = node.link + rank;
    if (grid.reference_first != NONE) at = scene.words.at[grid.reference_first + at];
    return scene.voxel_nodes.at[grid.node_first + at];
}

// The bit of the child that holds a cell; its coordinates are the base-4 digits number `level`.
FN uint voxel_digit(ivec3 cell, uint level) {
    uvec3 digits = (uvec3(cell) >> (2u * level)) & 3u;
    return digits.x | (digits.y << 2u) | (digits.z << 4u);
}

// The nodes from the root to the one that was looked into last; entry L has children of 4^L cells an edge.
struct VoxelStack {
    VoxelNode node[VOXEL_MAX_LEVELS];
};

// A cube of 2^log2_edge cells an edge, aligned to its own size, all of one palette index.
struct VoxelCube {
    uint log2_edge;
    uint palette;
};

// The largest cube around a cell that can be told at once. The stack is valid from `level` upwards.
FN VoxelCube voxel_cube(const_in(SceneView) scene, const_in(VoxelGrid) grid, ivec3 cell, uint level,
                        inout(VoxelStack) stack) {
    for (uint i = 0u; i < VOXEL_MAX_LEVELS; ++i) {
        VoxelNode node = stack.node[level];
        mask64 mask = make_mask64(node.mask_low, node.mask_high);
        uint digit = voxel_digit(cell, level);
        // The 2×2×2 children around the cell are skipped together if they are alike: bits 0, 1, 4, 5, 16, 17, 20, 21.
        uint half_bits = mask64_low(mask64_shift_right(mask, digit & 0x2au)) & 0x00330033u;
        if (!mask64_bit(mask, digit)) return VoxelCube(2u * level + (half_bits == 0u ? 1u : 0u), 0u);
        uint rank = popcount64(mask64_below(mask, digit));
        if ((node.link & VOXEL_LINK_KIND) != VOXEL_LINK_CHILDREN) {
            uint palette = voxel_palette(scene, grid, node, rank);
            if ((node.link & VOXEL_LINK_KIND) != VOXEL_LINK_SOLID) return VoxelCube(0u, palette);
            if ((node.mask_low & node.mask_high) == 0xffffffffu) return VoxelCube(2u * level + 2u, palette);
            return VoxelCube(2u * level + (half_bits == 0x00330033u ? 1u : 0u), palette);
        }
        --level;
        stack.node[level] = voxel_child(scene, grid, node, rank);
    }
    return VoxelCube(0u, 0u);  // not reached: a tree has at most that many levels
}

// ---------------------------------------------------------------------------------------- cells that an SDF tells

// The SDF in the middle of a cell, in its own units.
FN float voxel_sdf(const_in(SceneView) scene, const_in(VoxelGrid) grid, ivec3 cell) {
    return sdf_distance(scene, grid.sdf, grid.sdf_origin + (vec3(cell) + vec3(0.5f)) * grid.sdf_cell);
}

// Palette index of a solid cell at this height: one more for each stratum that begins below its middle.
FN uint voxel_stratum(const_in(SceneView) scene, const_in(VoxelGrid) grid, int y) {
    float height = grid.sdf_origin.y + (float(y) + 0.5f) * grid.sdf_cell;
    uint palette = 1u;
    for (uint i = 0u; i < grid.strata_count; ++i)
        if (scene.floats.at[grid.strata_first + i] <= height) ++palette;
    return palette;
}

FN bool voxel_in_set(const_in(VoxelGrid) grid, ivec3 c) {
    return c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x < grid.size.x && c.y < grid.size.y && c.z < grid.size.z;
}

// Palette index of a cell of a set that is a tree; 0, empty, outside the set.
FN uint voxel_in_tree(const_in(SceneView) scene, const_in(VoxelGrid) grid, ivec3 c) {
    if (!voxel_in_set(grid, c)) return 0u;
    VoxelStack stack;
    stack.node[grid.level_count - 1u] = grid.root;
    VoxelCube cube = voxel_cube(scene, grid, c, grid.level_count - 1u, stack);
    return cube.palette;
}

// The same of any set.
FN uint voxel_at(const_in(SceneView) scene, const_in(VoxelGrid) grid, ivec3 c) {
    if (grid.sdf == NONE) return voxel_in_tree(scene, grid, c);
    return voxel_in_set(grid, c) && voxel_sdf(scene, grid, c) <= 0.0f ? voxel_stratum(scene, grid, c.y) : 0u;
}

// A face of a cell in two words, by which its light is found (light_of_primitive).
FN uvec2 voxel_light_key(ivec3 cell, uint face) {
    return uvec2(uint(cell.x) | (uint(cell.y) << 20u), (uint(cell.y) >> 12u) | (uint(cell.z) << 8u) | (face << 28u));
}

// ---------------------------------------------------------------------------------------------------------- the walk
// t at which the ray meets plane number `plane` of an axis.
FN float voxel_plane(int plane, float origin, float inverse) { return (float(plane) - origin) * inverse; }

// The cell along one axis at t, within lower … upper. Planes met before t have been passed, and those met at t exactly
// if `inclusive`. The guess by floor() may be off by rounding; the crossings decide, so that the walk never meets a
// plane twice or not at all.
FN int voxel_cell(float origin, float direction, float inverse, float t, bool inclusive, int lower, int upper) {
    if (abs(direction) < TINY_DIRECTION) return clamp(int(floor(clamp(origin, -1.0f, 2.0e6f))), lower, upper);
    int cell = int(floor(clamp(origin + t * direction, float(lower), float(upper))));
    if (direction > 0.0f) {
        for (int i = 0; i < 4 && cell > lower; ++i) {
            float before = voxel_plane(cell, origin, inverse);
            if (inclusive ? before <= t : before < t) break;
            --cell;
        }
        for (int i = 0; i < 4 && cell < upper; ++i) {
            float next = voxel_plane(cell + 1, origin, inverse);
            if (inclusive ? next > t : next >= t) break;
            ++cell;
        }
    } else {
        for (int i = 0; i < 4 && cell < upper; ++i) {
            float before = voxel_plane(cell + 1, origin, inverse);
            if (inclusive ? before <= t : before < t) break;
            ++cell;
        }
        for (int i = 0; i < 4 && cell > lower; ++i) {
            float next = voxel_plane(cell, origin, inverse);
            if (inclusive ? next > t : next >= t) break;
            --cell;
        }
    }
    return cell;
}

// Records the face of `owner` on `axis`, on its + side or not.
FN void voxel_hit(Ray ray, float t, ivec3 owner, uint palette, uint axis, bool positive, inout(Hit) hit) {
    vec3 p = clamp(ray_at(ray, t) - vec3(owner), vec3(0.0f), vec3(1.0f));
    float s = positive ? 1.0f : -1.0f;
    hit.t = t;
    hit.primitive = palette;
    hit.face = 2u * axis + (positive ? 1u : 0u);
    hit.cell = owner;
    hit.uv = vec2(component(p, (axis + 1u) % 3u), component(p, (axis + 2u) % 3u));
    hit.normal = vec3(axis == 0u ? s : 0.0f, axis == 1u ? s : 0.0f, axis == 2u ? s : 0.0f);
}

// A ray as the walk needs it, and where it is inside the box of a set.
struct VoxelRay {
    vec3 inverse;     // of the direction
    ivec3 positive;   // 1 where the direction is
    bvec3 still;      // where it is zero
    float enter;      // the walk begins here …
    float leave;      // … and ends here
    uint enter_axis;  // of the face that it comes in by
    bool from_outside;
};

// `leave` is not above `enter` where the ray misses the box.
FN VoxelRay voxel_ray(ivec3 size, Ray ray) {
    vec3 o = ray.origin;
    vec3 d = ray.direction;
    VoxelRay r;
    r.still = bvec3(abs(d.x) < TINY_DIRECTION, abs(d.y) < TINY_DIRECTION, abs(d.z) < TINY_DIRECTION);
    r.inverse = vec3(safe_inverse(d.x), safe_inverse(d.y), safe_inverse(d.z));
    r.positive = ivec3(d.x > 0.0f ? 1 : 0, d.y > 0.0f ? 1 : 0, d.z > 0.0f ? 1 : 0);
    r.enter = 0.0f;
    r.leave = 0.0f;
    r.enter_axis = 0u;
    r.from_outside = false;
    if (r.still.x && !(o.x >= 0.0f && o.x < float(size.x))) return r;
    if (r.still.y && !(o.y >= 0.0f && o.y < float(size.y))) return r;
    if (r.still.z && !(o.z >= 0.0f && o.z < float(size.z))) return r;
    if (r.still.x && r.still.y && r.still.z) return r;

    // Exactly as the walk sees the outermost planes.
    vec3 enter = vec3(r.still.x ? -INFINITE : voxel_plane(r.positive.x == 1 ? 0 : size.x, o.x, r.inverse.x),
                      r.still.y ? -INFINITE : voxel_plane(r.positive.y == 1 ? 0 : size.y, o.y, r.inverse.y),
                      r.still.z ? -INFINITE : voxel_plane(r.positive.z == 1 ? 0 : size.z, o.z, r.inverse.z));
    vec3 leave = vec3(r.still.x ? INFINITE : voxel_plane(r.positive.x == 1 ? size.x : 0, o.x, r.inverse.x),
                      r.still.y ? INFINITE : voxel_plane(r.positive.y == 1 ? size.y : 0, o.y, r.inverse.y),
                      r.still.z ? INFINITE : voxel_plane(r.positive.z == 1 ? size.z : 0, o.z, r.inverse.z));
    r.enter_axis = enter.x >= enter.y && enter.x >= enter.z ? 0u : (enter.y >= enter.z ? 1u : 2u);
    r.enter = component(enter, r.enter_axis);
    r.leave = min_component(leave);
    r.from_outside = r.enter > ray.t_min;
    if (!r.from_outside) r.enter = ray.t_min;
    return r;
}

// The cell in which the walk begins.
FN ivec3 voxel_first_cell(ivec3 size, Ray ray, const_in(VoxelRay) r) {
    vec3 o = ray.origin;
    vec3 d = ray.direction;
    return ivec3(voxel_cell(o.x, d.x, r.inverse.x, r.enter, true, 0, size.x - 1),
                 voxel_cell(o.y, d.y, r.inverse.y, r.enter, true, 0, size.y - 1),
                 voxel_cell(o.z, d.z, r.inverse.z, r.enter, true, 0, size.z - 1));
}

// The way out of a cube of cells: the cell behind it, the axis of the plane between and its t.
struct VoxelStep {
    ivec3 next;
    uint axis;
    float t;
};

FN VoxelStep voxel_step(Ray ray, const_in(VoxelRay) r, ivec3 cell, uint log2_edge) {
    vec3 o = ray.origin;
    vec3 d = ray.direction;
    int edge = 1 << log2_edge;
    ivec3 lower = (cell >> int(log2_edge)) << int(log2_edge);
    ivec3 upper = lower + (edge - 1);
    float tx = r.still.x ? INFINITE : voxel_plane(r.positive.x == 1 ? lower.x + edge : lower.x, o.x, r.inverse.x);
    float ty = r.still.y ? INFINITE : voxel_plane(r.positive.y == 1 ? lower.y + edge : lower.y, o.y, r.inverse.y);
    float tz = r.still.z ? INFINITE : voxel_plane(r.positive.z == 1 ? lower.z + edge : lower.z, o.z, r.inverse.z);
    VoxelStep s;
    if (tx <= ty && tx <= tz) {
        s.axis = 0u;
        s.t = tx;
        s.next = ivec3(r.positive.x == 1 ? upper.x + 1 : lower.x - 1, cell.y, cell.z);
        if (edge > 1) {
            s.next.y = voxel_cell(o.y, d.y, r.inverse.y, s.t, false, lower.y, upper.y);
            s.next.z = voxel_cell(o.z, d.z, r.inverse.z, s.t, false, lower.z, upper.z);
        }
    } else if (ty <= tz) {
        s.axis = 1u;
        s.t = ty;
        s.next = ivec3(cell.x, r.positive.y == 1 ? upper.y + 1 : lower.y - 1, cell.z);
        if (edge > 1) {
            s.next.x = voxel_cell(o.x, d.x, r.inverse.x, s.t, true, lower.x, upper.x);
            s.next.z = voxel_cell(o.z, d.z, r.inverse.z, s.t, false, lower.z, upper.z);
        }
    } else {
        s.axis = 2u;
        s.t = tz;
        s.next = ivec3(cell.x, cell.y, r.positive.z == 1 ? upper.z + 1 : lower.z - 1);
        if (edge > 1) {
            s.next.x = voxel_cell(o.x, d.x, r.inverse.x, s.t, true, lower.x, upper.x);
            s.next.y = voxel_cell(o.y, d.y, r.inverse.y, s.t, true, lower.y, upper.y);
        }
    }
    return s;
}

// A hit in the cell where the walk begins: on the face that the ray comes in by, or at once where it starts in what is
// opaque. False: there is none.
FN bool voxel_first_hit(Ray ray, const_in(VoxelRay) r, ivec3 cell, uint palette, uint medium, inout(Hit) hit) {
    vec3 d = ray.direction;
    if (r.from_outside) {
        if (medium == VOXEL_AIR) return false;
        voxel_hit(ray, r.enter, cell, palette, r.enter_axis, component(d, r.enter_axis) < 0.0f, hit);
        return true;
    }
    if (medium != VOXEL_OPAQUE) return false;
    vec3 m = abs(d);
    uint axis = m.x >= m.y && m.x >= m.z ? 0u : (m.y >= m.z ? 1u : 2u);
    float t = ray.t_min + max(abs(ray.t_min) * 2.4e-7f, TINY_DIRECTION);
    if (t < hit.t) voxel_hit(ray, t, cell, palette, axis, component(d, axis) < 0.0f, hit);
    return true;
}

// The nearest interface in (ray.t_min, hit.t). Hit.uv runs along the axes axis + 1 and axis + 2 (cyclic).
FN void voxels_closest(const_in(SceneView) scene, uint grid_index, uint slot_first, Ray ray, inout(Hit) hit) {
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
    uint medium = voxel_class(scene, slot_first, palette);
    if (voxel_first_hit(ray, r, cell, palette, medium, hit)) return;

    // Each step leaves a cell for good along one axis, so there are at most this many.
    int steps = size.x + size.y + size.z;
    for (int i = 0; i < steps; ++i) {
        VoxelStep step = voxel_step(ray, r, cell, cube.log2_edge);
        ivec3 next = step.next;
        uint axis = step.axis;
        float t = step.t;
        if (t >= hit.t) return;
        bool inside =
            next.x >= 0 && next.y >= 0 && next.z >= 0 && next.x < size.x && next.y < size.y && next.z < size.z;
        cube = VoxelCube(0u, 0u);
        if (inside) {
            // The children of node L differ in digit L of their cells: the highest that changed names the ancestor.
            uint changed = uint((cell.x ^ next.x) | (cell.y ^ next.y) | (cell.z ^ next.z));
            cube = voxel_cube(scene, grid, next, (31u - leading_zeros32(changed)) >> 1u, stack);
        }
        if (cube.palette != palette) {
            uint entered = voxel_class(scene, slot_first, cube.palette);
            if (entered != medium) {
                bool forward = component(d, axis) > 0.0f;
                if (entered == VOXEL_AIR) {
                    ivec3 left = next;
                    left[axis] += forward ? -1 : 1;
                    voxel_hit(ray, t, left, palette, axis, forward, hit);
                } else {
                    voxel_hit(ray, t, next, cube.palette, axis, !forward, hit);
                }
                return;
            }
            palette = cube.palette;
        }
        if (!inside) return;
        cell = next;
    }
}

KERNELS_END
#endif
