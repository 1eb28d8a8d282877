#include "accel/wide_refit.h"

#include <bit>
#include <vector>

#include "accel/float4.h"
#include "core/parallel.h"

namespace spinel {
namespace {

constexpr std::uint32_t width = 8, block_size = 4, unit_mask = 0x0fffffffu;
constexpr std::uint32_t unused = 0;  // the reference of a child that is not there: no child is the root

std::uint32_t reference_of(const kernels::WideUnit* node, std::uint32_t child) {
    return std::bit_cast<std::uint32_t>(node[6].lanes[child]);
}

void put_child_bounds(const Bounds& bounds, std::uint32_t child, kernels::WideUnit* node) {
    const auto lower = lanes_of(bounds.lower), upper = lanes_of(bounds.upper);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        node[2 * axis].lanes[child] = lower[axis];
        node[2 * axis + 1].lanes[child] = upper[axis];
    }
}

// Of all children; those that are not there have empty boxes.
Bounds bounds_of_node(const kernels::WideUnit* node) {
    Bounds all;
    for (std::uint32_t i = 0; i < width; ++i)
        all.extend({Float4(glm::vec3(node[0].lanes[i], node[2].lanes[i], node[4].lanes[i])),
                    Float4(glm::vec3(node[1].lanes[i], node[3].lanes[i], node[5].lanes[i]))});
    return all;
}

// Writes the vertices of a leaf anew.
Bounds refit_leaf(kernels::WideUnit* block, std::uint32_t blocks, std::span<const kernels::Triangle> triangles) {
    Bounds bounds;
    for (; blocks > 0; --blocks, block += kernels::WIDE_BLOCK_UNITS) {
        float* const rows = block->lanes;
        for (std::uint32_t lane = 0; lane < block_size; ++lane) {
            const kernels::Triangle& t = triangles[std::bit_cast<std::uint32_t>(rows[9 * block_size + lane])];
            const glm::vec3* const vertices[3] = {&t.a, &t.b, &t.c};
            for (std::uint32_t v = 0; v < 3; ++v) {
                bounds.extend(Float4(*vertices[v]));
                for (std::uint32_t axis = 0; axis < 3; ++axis)
                    rows[(3 * v + axis) * block_size + lane] = (*vertices[v])[int(axis)];
            }
        }
    }
    return bounds;
}

}  // namespace

void refit_wide_bvh(std::span<kernels::WideUnit> units, std::span<const kernels::Triangle> triangles) {
    if (units.empty()) return;
    std::vector<std::uint32_t> nodes{0};  // parents before their children
    for (std::size_t n = 0; n < nodes.size(); ++n)
        for (std::uint32_t i = 0; i < width; ++i) {
            const std::uint32_t reference = reference_of(&units[nodes[n]], i);
            if (reference != unused && reference <= unit_mask) nodes.push_back(reference);
        }
    parallel_for(nodes.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            kernels::WideUnit* const node = &units[nodes[n]];
            for (std::uint32_t i = 0; i < width; ++i)
                if (const std::uint32_t reference = reference_of(node, i); reference > unit_mask)
                    put_child_bounds(refit_leaf(&units[reference & unit_mask], reference >> 28, triangles), i, node);
        }
    });
    for (std::size_t n = nodes.size(); n-- > 0;) {
        kernels::WideUnit* const node = &units[nodes[n]];
        for (std::uint32_t i = 0; i < width; ++i)
            if (const std::uint32_t reference = reference_of(node, i); reference != unused && reference <= unit_mask)
                put_child_bounds(bounds_of_node(&units[reference]), i, node);
    }
}

}  // namespace spinel
