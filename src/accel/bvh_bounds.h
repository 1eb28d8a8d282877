#pragma once
// What the builders of bounding volume hierarchies share.

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <span>
#include <vector>

#include "accel/bvh_builder.h"

namespace spinel::bvh {

// Four lanes, the last one idle, so that the compiler keeps a box in two vector registers.
struct alignas(16) Bounds {
    std::array<float, 4> lower;
    std::array<float, 4> upper;

    static Bounds empty() {
        constexpr float inf = std::numeric_limits<float>::infinity();
        return {{inf, inf, inf, inf}, {-inf, -inf, -inf, -inf}};
    }
    void extend(const Bounds& other) {
        for (std::size_t i = 0; i < 4; ++i) lower[i] = std::min(lower[i], other.lower[i]);
        for (std::size_t i = 0; i < 4; ++i) upper[i] = std::max(upper[i], other.upper[i]);
    }
    void extend_center(const Bounds& other) {
        for (std::size_t i = 0; i < 4; ++i) {
            const float center = other.center(i);
            lower[i] = std::min(lower[i], center);
            upper[i] = std::max(upper[i], center);
        }
    }
    // Half the sum before adding would lose nothing but the denormals; it cannot overflow.
    float center(std::size_t axis) const { return 0.5f * lower[axis] + 0.5f * upper[axis]; }
    float half_area() const {
        const float x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
        return x * y + y * z + z * x;
    }
};

struct Primitive {
    Bounds bounds;
    std::uint32_t index;
};

inline int ceil_log2(std::size_t n) { return n <= 1 ? 0 : std::bit_width(n - 1); }

// Boxes that are finite and ordered.
std::vector<Primitive> usable_primitives(std::span<const Box> boxes);

// Copies a tree without the nodes that it does not reach, in depth-first order, siblings adjacent, and measures it.
void compact(const std::vector<kernels::BvhNode>& sparse, float traversal_cost, Bvh& bvh);

// At least one primitive.
Bvh build_by_sweep(std::vector<Primitive> primitives, const BvhOptions& options);

}  // namespace spinel::bvh
