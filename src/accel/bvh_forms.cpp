// A tree that is already there: bounds anew, and the form that is walked without a stack.

#include <cassert>

#include "accel/bvh_builder.h"

namespace spinel {

void refit_bvh(std::span<kernels::BvhNode> nodes, std::span<const Box> boxes_in_order) {
    for (std::size_t i = nodes.size(); i-- > 0;) {
        kernels::BvhNode& node = nodes[i];
        if (node.count == 0) {
            assert(node.first > i);
            const kernels::BvhNode &left = nodes[node.first], &right = nodes[node.first + 1];
            node.lower = glm::min(left.lower, right.lower);
            node.upper = glm::max(left.upper, right.upper);
            continue;
        }
        node.lower = boxes_in_order[node.first].lower;
        node.upper = boxes_in_order[node.first].upper;
        for (std::size_t k = node.first + 1; k < node.first + node.count; ++k) {
            node.lower = glm::min(node.lower, boxes_in_order[k].lower);
            node.upper = glm::max(node.upper, boxes_in_order[k].upper);
        }
    }
}

std::vector<kernels::BvhNode> with_skip_links(std::span<const kernels::BvhNode> nodes) {
    std::vector<kernels::BvhNode> linked;
    linked.reserve(nodes.size());
    if (nodes.empty()) return linked;
    // A node, or the end of the subtree of one that was written.
    struct Pending {
        std::uint32_t node;
        bool end;
    };
    std::vector<Pending> stack = {{0, false}};
    while (!stack.empty()) {
        const Pending pending = stack.back();
        stack.pop_back();
        if (pending.end) {
            linked[pending.node].count = std::uint32_t(linked.size());
            continue;
        }
        const kernels::BvhNode& node = nodes[pending.node];
        const auto at = std::uint32_t(linked.size());
        linked.push_back({node.lower, node.count > 0 ? kernels::bvh_entry(node) : 0u, node.upper, 0});
        stack.push_back({at, true});
        if (node.count > 0) continue;
        stack.push_back({node.first + 1, false});
        stack.push_back({node.first, false});
    }
    return linked;
}

}  // namespace spinel
