#ifndef SPINEL_KERNELS_MESH_COMPACT_H
#define SPINEL_KERNELS_MESH_COMPACT_H
// The walk over a wide hierarchy that takes half the memory of the usual one (mesh_wide.h) and less: boxes in bytes, as
// steps of a grid of the node's own (after Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through
// Compressed Wide BVHs", HPG 2017), and vertices once for the triangles of a block that share them.
//
// A node is COMPACT_NODE_WORDS words: a corner x, y, z; the exponents of the steps along x, y and z and a mask of the
// children that there are, in bytes from the lowest; then as bytes, one a child, the planes lower x, upper x, lower y,
// upper y, lower z, upper z; then references. A plane is corner + byte · step, rounded once, since the product is
// exact; what is stored is such that no box is smaller than what it holds. A reference's upper four bits count the
// blocks of a leaf, 0: a node; the lower ones say where it begins, in steps of COMPACT_STEP words from the root.
//
// A block holds up to eight triangles with up to eight vertices: a word with both numbers, in bytes; for each triangle
// half a word with the places of its corners among the vertices, three bits each; the x of all vertices, their y, their
// z; the indices of the triangles. The next one follows at once.
#include "mesh_wide.h"
KERNELS_BEGIN

const uint COMPACT_NODE_WORDS = 24u;
const uint COMPACT_BLOCK_TRIANGLES = 8u;
const uint COMPACT_BLOCK_VERTICES = 8u;

// Places in a block, in words.
FN uint compact_rows(uint triangles) { return 1u + ((triangles + 1u) >> 1u); }
FN uint compact_indices(uint triangles, uint vertices) { return compact_rows(triangles) + 3u * vertices; }
FN uint compact_block_words(uint triangles, uint vertices) { return compact_indices(triangles, vertices) + triangles; }

FN uint compact_word(const_in(SceneView) scene, uint root, uint word) {
    return float_bits(scene.wide_units.at[root + (word >> 3u)].lanes[word & 7u]);
}

FN uint byte_of(uint word, uint i) { return (word >> (8u * i)) & 255u; }

// Of child i; `row` begins the bytes of one kind of plane.
FN float compact_plane(const_in(SceneView) scene, uint root, uint row, uint i, float corner, float step) {
    return multiply_add(float(byte_of(compact_word(scene, root, row + (i >> 2u)), i & 3u)), step, corner);
}

FN_ANEW void mesh_compact_walk(const_in(SceneView) scene, uint mesh, const_in(MeshRay) ray, inout(MeshNearest) nearest,
                               inout(WalkCount) count) {
    uint root = scene.meshes.at[mesh].node_first;
    vec3 inverse = wide_inverse(ray.ray.direction);
    float padding = slab_padding(scene.meshes.at[mesh].lower, scene.meshes.at[mesh].upper, ray.ray.origin);
    vec3 lower_origin = ray.ray.origin + vec3(padding);
    vec3 upper_origin = ray.ray.origin - vec3(padding);
    WideStack stack;
    uint size = 1u;
    stack.reference[0] = 0u;
    stack.enter[0] = ray.ray.t_min;
    while (size > 0u) {
        --size;
        if (!(stack.enter[size] <= nearest.hit.t)) continue;
        uint word = (stack.reference[size] & WIDE_UNIT_MASK) * COMPACT_STEP;
        uint blocks = stack.reference[size] >> 28u;
        ++count.steps;
        if (blocks > 0u) {
            for (uint block = 0u; block < blocks; ++block) {
                uint header = compact_word(scene, root, word);
                uint triangles = byte_of(header, 0u);
                uint indices = word + compact_indices(triangles, byte_of(header, 1u));
                count.tests += triangles;
                for (uint i = 0u; i < triangles; ++i) {
                    uint triangle = compact_word(scene, root, indices + i);
                    if (mesh_test(scene, ray, ray.triangle_first + triangle, nearest) && ray.any) return;
                }
                word = indices + triangles;
            }
            continue;
        }
        count.boxes += 8u;
        vec3 corner =
            vec3(bits_float(compact_word(scene, root, word)), bits_float(compact_word(scene, root, word + 1u)),
                 bits_float(compact_word(scene, root, word + 2u)));
        uint packed = compact_word(scene, root, word + 3u);
        vec3 step = vec3(bits_float(byte_of(packed, 0u) << 23u), bits_float(byte_of(packed, 1u) << 23u),
                         bits_float(byte_of(packed, 2u) << 23u));
        uint present = byte_of(packed, 3u);
        uint first = size;
        for (uint i = 0u; i < 8u; ++i) {
            if (((present >> i) & 1u) == 0u) continue;
            vec3 lower = vec3(compact_plane(scene, root, word + 4u, i, corner.x, step.x),
                              compact_plane(scene, root, word + 8u, i, corner.y, step.y),
                              compact_plane(scene, root, word + 12u, i, corner.z, step.z));
            vec3 upper = vec3(compact_plane(scene, root, word + 6u, i, corner.x, step.x),
                              compact_plane(scene, root, word + 10u, i, corner.y, step.y),
                              compact_plane(scene, root, word + 14u, i, corner.z, step.z));
            vec3 t0 = (lower - lower_origin) * inverse;
            vec3 t1 = (upper - upper_origin) * inverse;
            vec3 from = min(t0, t1);
            vec3 to = max(t0, t1);
            float enter = max(max(from.x, from.y), max(from.z, ray.ray.t_min));
            float leave = min(min(to.x, to.y), min(to.z, nearest.hit.t));
            if (!(enter <= leave)) continue;
            // The nearest comes on top.
            uint at = size;
            while (at > first && stack.enter[at - 1u] < enter) {
                stack.reference[at] = stack.reference[at - 1u];
                stack.enter[at] = stack.enter[at - 1u];
                --at;
            }
            stack.reference[at] = compact_word(scene, root, word + 16u + i);
            stack.enter[at] = enter;
            ++size;
        }
    }
}

KERNELS_END
#endif
