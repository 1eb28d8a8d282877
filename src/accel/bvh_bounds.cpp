#include "accel/bvh_bounds.h"

#include <algorithm>
#include <cmath>

namespace spinel {

BvhStatistics bvh_statistics(std::span<const kernels::BvhNode> nodes, float traversal_cost) {
    BvhStatistics statistics;
    if (nodes.empty()) return statistics;
    const auto half_area = [](const kernels::BvhNode& n) {
        const glm::dvec3 e = glm::dvec3(n.upper) - glm::dvec3(n.lower);
        return e.x * e.y + e.y * e.z + e.z * e.x;
    };
    struct Pending {
        std::uint32_t node;
        std::uint32_t depth;
    };
    std::vector<Pending> stack = {{0, 0}};
    double cost = 0;
    while (!stack.empty()) {
        const Pending pending = stack.back();
        stack.pop_back();
        const kernels::BvhNode& node = nodes[pending.node];
        statistics.depth = std::max(statistics.depth, pending.depth);
        if (node.count > 0) {
            ++statistics.leaf_count;
            cost += half_area(node) * node.count;
            continue;
        }
        cost += half_area(node) * double(traversal_cost);
        stack.push_back({node.first + 1, pending.depth + 1});
        stack.push_back({node.first, pending.depth + 1});
    }
    const double root_area = half_area(nodes[0]);
    statistics.sah_cost = root_area > 0 ? cost / root_area : 0;
    return statistics;
}

namespace bvh {

std::vector<Primitive> usable_primitives(std::span<const Box> boxes) {
    std::vector<Primitive> primitives;
    primitives.reserve(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const glm::vec3 lower = boxes[i].lower, upper = boxes[i].upper;
        bool usable = true;
        for (int axis = 0; axis < 3; ++axis) {
            usable = usable && std::isfinite(lower[axis]) && std::isfinite(upper[axis]) && lower[axis] <= upper[axis];
        }
        if (!usable) continue;
        primitives.push_back(
            {{{lower.x, lower.y, lower.z, 0}, {upper.x, upper.y, upper.z, 0}}, static_cast<std::uint32_t>(i)});
    }
    return primitives;
}

void compact(const std::vector<kernels::BvhNode>& sparse, float traversal_cost, Bvh& bvh) {
    std::vector<std::uint32_t> stack;  // into bvh.nodes
    bvh.nodes.push_back(sparse[0]);
    stack.push_back(0);
    while (!stack.empty()) {
        const std::uint32_t at = stack.back();
        stack.pop_back();
        const kernels::BvhNode node = bvh.nodes[at];
        if (node.count > 0) continue;
        const auto first = static_cast<std::uint32_t>(bvh.nodes.size());
        bvh.nodes[at].first = first;
        bvh.nodes.push_back(sparse[node.first]);
        bvh.nodes.push_back(sparse[node.first + 1]);
        stack.push_back(first + 1);
        stack.push_back(first);
    }
    bvh.statistics = bvh_statistics(bvh.nodes, traversal_cost);
}

}  // namespace bvh
}  // namespace spinel
