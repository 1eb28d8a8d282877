#include "geometry/mesh/wide_mesh.h"

#include <algorithm>
#include <array>
#include <cstdint>
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

// Three coordinates and an idle lane, in the compilers' own vector types.
using Doubles = double __attribute__((vector_size(32)));
using Floats = float __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(16)));

// std::nextafter() towards −∞, lane by lane.
Floats next_below(Floats x) {
    const Ints bits = (Ints)x + (x > 0 ? Ints{-1, -1, -1, -1} : Ints{1, 1, 1, 1});
    constexpr std::int32_t least = std::numeric_limits<std::int32_t>::min() + 1;  // the bits of −2⁻¹⁴⁹
    return (Floats)(x == 0 ? Ints{least, least, least, least} : bits);
}

// The hull of what is added, in double.
struct Hull {
    static constexpr double infinity = std::numeric_limits<double>::infinity();
    Doubles lower = {infinity, infinity, infinity, infinity};
    Doubles upper = -lower;

    void add(const Doubles& p) {
        lower = p < lower ? p : lower;
        upper = p > upper ? p : upper;
    }
    // In floats, within `box`.
    Box within(const Box& box) const {
        const Floats low = next_below(__builtin_convertvector(lower, Floats));
        const Floats high = -next_below(__builtin_convertvector(-upper, Floats));
        Box out;
        for (int a = 0; a < 3; ++a) {
            out.lower[a] = std::max(low[a], box.lower[a]);
            out.upper[a] = std::min(high[a], box.upper[a]);
        }
        return out;
    }
};

}  // namespace

std::span<const WidePreset> wide_presets() { return presets; }
const WidePreset& default_wide_preset() { return presets.back(); }

void clip_triangle(const kernels::Triangle& triangle, const Box& box, int axis, float plane, Box& below, Box& above) {
    Doubles vertices[3];
    double along[3];
    for (int i = 0; i < 3; ++i) {
        const glm::vec3& p = i == 0 ? triangle.a : i == 1 ? triangle.b : triangle.c;
        vertices[i] = Doubles{p.x, p.y, p.z, 0};
        along[i] = p[axis];
    }
    const double at = plane;
    Hull low, high;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        if (along[i] <= at) low.add(vertices[i]);
        if (along[i] >= at) high.add(vertices[i]);
        if ((along[i] < at && along[j] > at) || (along[i] > at && along[j] < at)) {
            const Doubles crossing =
                vertices[i] + (vertices[j] - vertices[i]) * ((at - along[i]) / (along[j] - along[i]));
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
