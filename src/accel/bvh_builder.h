#pragma once
// Builds the binary bounding volume hierarchies that kernels walk (kernels/bvh.h) from boxes alone: the tree
// never knows a shape. Binned surface area heuristic: Wald, "On fast Construction of SAH-based Bounding
// Volume Hierarchies", RT 2007.

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/bvh.h"

namespace spinel {

struct Box {
    glm::vec3 lower;
    glm::vec3 upper;
};

enum class BvhMethod {
    binned,       // surface area heuristic at sixteen planes an axis
    sweep,        // at every plane between two primitives: slower to build, a little better
    reinsertion,  // the binned tree, its nodes moved to where they cost the least: many times slower to build
    median,       // halves by number, along the widest axis: no heuristic at all
};

struct BvhOptions {
    std::uint32_t max_leaf = 4;   // primitives, at most kernels::BVH_MAX_LEAF
    float traversal_cost = 2.0f;  // of one interior node (two boxes and a turn), in triangle tests; measured
    BvhMethod method = BvhMethod::binned;
};

struct BvhStatistics {
    double sah_cost = 0;      // expected primitive tests (interior nodes weighted) of a ray that meets the root's box
    std::uint32_t depth = 0;  // edges from the root to the deepest leaf, at most kernels::BVH_MAX_DEPTH
    std::uint32_t leaf_count = 0;
};

// Nodes in depth-first order, the root first, siblings adjacent; leaves own ranges of `order`, which holds
// indices of boxes. Without boxes there are no nodes. Boxes that are not finite or not ordered (NaN, ±∞,
// lower > upper) are left out: nothing could ever hit what is inside.
struct Bvh {
    std::vector<kernels::BvhNode> nodes;
    std::vector<std::uint32_t> order;
    BvhStatistics statistics;
};

// The result depends on the boxes and options only, not on the number of threads. At most BVH_MAX_PRIMITIVES
// boxes.
Bvh build_bvh(std::span<const Box> boxes, const BvhOptions& options = {});

// Of any tree of this form.
BvhStatistics bvh_statistics(std::span<const kernels::BvhNode> nodes, float traversal_cost);

// Bounds of nodes anew, after the boxes (in the order of Bvh::order) have moved: the tree stays as it is, which is
// right whatever moved, and good as long as neighbours stay neighbours. Children stand behind their parents.
void refit_bvh(std::span<kernels::BvhNode> nodes, std::span<const Box> boxes_in_order);

// The same tree for walks without a stack: nodes in depth-first order, and links in place of children
// (kernels/mesh_bvh2.h).
std::vector<kernels::BvhNode> with_skip_links(std::span<const kernels::BvhNode> nodes);

}  // namespace spinel
