#ifndef SPINEL_KERNELS_BVH_H
#define SPINEL_KERNELS_BVH_H
// What walks over a binary BVH share: a stack of nodes still to visit, nearest first.
//
// A walk goes on with the nearer child that was hit and pushes the other one, so at most one entry a level is
// pending. The builder keeps trees at most BVH_MAX_DEPTH levels deep, so the stack cannot overflow; and every
// node is visited at most once, which bounds the loop.
#include "box.h"
#include "scene_view.h"
KERNELS_BEGIN

const uint BVH_MAX_DEPTH = 60u;
const uint BVH_MAX_LEAF = 15u;              // primitives in a leaf
const uint BVH_MAX_PRIMITIVES = 1u << 28u;  // in a tree

// A node still to visit: its `first` and `count` in one word (so that a pop needs no second look at the
// node), and where the ray enters it, so that it is dropped unseen once something nearer was hit.
struct BvhStack {
    uint entry[BVH_MAX_DEPTH + 1u];
    float enter[BVH_MAX_DEPTH + 1u];
};

FN uint bvh_entry(const_in(BvhNode) node) { return (node.first << 4u) | node.count; }
FN uint bvh_entry_first(uint entry) { return entry >> 4u; }
FN uint bvh_entry_count(uint entry) { return entry & 15u; }

// Two siblings in the order in which the ray enters them; INFINITE where it misses.
struct BvhSiblings {
    uint nearer;  // entries
    uint farther;
    float enter_nearer;
    float enter_farther;
};

FN BvhSiblings bvh_siblings(BvhNodes nodes, uint left, const_in(SlabRay) ray, float t_max) {
    float enter_left = slab_entry(nodes.at[left].lower, nodes.at[left].upper, ray, t_max);
    float enter_right = slab_entry(nodes.at[left + 1u].lower, nodes.at[left + 1u].upper, ray, t_max);
    uint entry_left = bvh_entry(nodes.at[left]);
    uint entry_right = bvh_entry(nodes.at[left + 1u]);
    bool right_nearer = enter_right < enter_left;
    return BvhSiblings(right_nearer ? entry_right : entry_left, right_nearer ? entry_left : entry_right,
                       min(enter_left, enter_right), max(enter_left, enter_right));
}

KERNELS_END
#endif
