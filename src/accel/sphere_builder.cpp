#include "accel/sphere_builder.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace spinel {

std::vector<kernels::SphereNode> sphere_nodes(std::span<const kernels::BvhNode> nodes, const FarthestPoint& farthest) {
    // The range of primitives below each node; children stand behind their parents, left before right.
    struct Range {
        std::uint32_t begin, end;
    };
    std::vector<Range> ranges(nodes.size());
    for (std::size_t i = nodes.size(); i-- > 0;) {
        const kernels::BvhNode& n = nodes[i];
        if (n.count > 0) ranges[i] = {n.first, n.first + n.count};
        else ranges[i] = {ranges[n.first].begin, ranges[n.first + 1].end};
    }
    std::vector<kernels::SphereNode> balls(nodes.size());
    parallel_for(nodes.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const kernels::BvhNode& n = nodes[i];
            const glm::vec3 center(0.5f * n.lower + 0.5f * n.upper);
            double radius = 0;
            for (std::uint32_t k = ranges[i].begin; k < ranges[i].end; ++k)
                radius = std::max(radius, farthest(k, glm::dvec3(center)));
            balls[i] = {center, std::nextafter(float(radius), kernels::INFINITE), n.first, n.count};
        }
    });
    return balls;
}

double sphere_cost(std::span<const kernels::SphereNode> nodes, float traversal_cost) {
    const double root = double(nodes[0].radius) * double(nodes[0].radius);
    double cost = 0;
    for (const kernels::SphereNode& n : nodes)
        cost += double(n.radius) * double(n.radius) * (n.count > 0 ? double(n.count) : double(traversal_cost));
    return root > 0 ? cost / root : 0;
}

}  // namespace spinel
