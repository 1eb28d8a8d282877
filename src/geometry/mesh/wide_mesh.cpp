#include "geometry/mesh/wide_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/parallel.h"

namespace spinel {
namespace {

constexpr std::array<WidePreset, 3> presets = {{
    {"fast",
     "groups along a Morton curve, the heuristic over groups alone: for meshes that are built more often than looked "
     "at",
     true,
     {},
     {}},
    {"balanced", "binned surface area heuristic", false, {}, {}},
    {"high", "the same with spatial splits where boxes overlap much", false, {.spatial_growth = 0.3f}, {}},
}};

// The hull of what is added, in double.
struct Hull {
    glm::dvec3 lower = glm::dvec3(std::numeric_limits<double>::infinity());
    glm::dvec3 upper = glm::dvec3(-std::numeric_limits<double>::infinity());

    void add(const glm::dvec3& p) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    // In floats, within `box`.
    Box within(const Box& box) const {
        Box out;
        for (int a = 0; a < 3; ++a) {
            out.lower[a] =
                std::max(std::nextafter(float(lower[a]), -std::numeric_limits<float>::infinity()), box.lower[a]);
            out.upper[a] =
                std::min(std::nextafter(float(upper[a]), std::numeric_limits<float>::infinity()), box.upper[a]);
        }
        return out;
    }
};

}  // namespace

std::span<const WidePreset> wide_presets() { return presets; }
const WidePreset& default_wide_preset() { return presets.back(); }

void clip_triangle(const kernels::Triangle& triangle, const Box& box, int axis, float plane, Box& below, Box& above) {
    const glm::dvec3 vertices[3] = {triangle.a, triangle.b, triangle.c};
    const double at = plane;
    Hull low, high;
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 p = vertices[i], q = vertices[(i + 1) % 3];
        if (p[axis] <= at) low.add(p);
        if (p[axis] >= at) high.add(p);
        if ((p[axis] < at && q[axis] > at) || (p[axis] > at && q[axis] < at)) {
            const glm::dvec3 crossing = p + (q - p) * ((at - p[axis]) / (q[axis] - p[axis]));
            low.add(crossing);
            high.add(crossing);
        }
    }
    below = low.within(box);
    above = high.within(box);
    below.upper[axis] = std::min(below.upper[axis], plane);
    above.lower[axis] = std::max(above.lower[axis], plane);
}

namespace {

Bvh build_binary(std::span<const kernels::Triangle> triangles, const WidePreset& preset) {
    HugeVector<Box> boxes(triangles.size());
    parallel_for(triangles.size(), 16384, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const kernels::Triangle& t = triangles[i];
            boxes[i] = {glm::min(t.a, glm::min(t.b, t.c)), glm::max(t.a, glm::max(t.b, t.c))};
        }
    });
    if (preset.grains) return build_grain_bvh(boxes);
    return build_split_bvh(boxes, preset.binary,
                           [&](std::uint32_t triangle, const Box& box, int axis, float plane, Box& below, Box& above) {
                               clip_triangle(triangles[triangle], box, axis, plane, below, above);
                           });
}

}  // namespace

WideBvh build_wide_mesh(std::span<const kernels::Triangle> triangles, const WidePreset& preset) {
    if (preset.grains) return build_wide_grains(triangles, preset.wide);
    return collapse_bvh(build_binary(triangles, preset), triangles, preset.wide);
}

WideBvh build_compact_mesh(std::span<const kernels::Triangle> triangles, const WidePreset& preset) {
    return compact_bvh(build_binary(triangles, preset), triangles, preset.wide);
}

}  // namespace spinel
