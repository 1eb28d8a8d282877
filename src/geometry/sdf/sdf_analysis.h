#pragma once
// What must be known of an expression before it becomes a tape: where its solid is, how steep it is, and how
// much of it is asked for.
//
// Every node gets a support: a box S and a slope c with f(p) ≥ c·distance(p, S) wherever p is outside of S.
// So S bounds the solid, and f far away is worth at least c·distance. Supports compose bottom-up; the
// Lipschitz constant needs the bounds of the whole (a twist is steeper further out) and follows top-down.
//
// Two operations cut their values off away from their support (kernels::SDF_OP_FAR). f becomes min(f, far)
// with far(p) = max(least, c·distance(p, S)):
//  * twist: where c·distance(p, S) > least, f ≥ far, so the result is far itself, whose slope is c; the
//  steepness of the
//    twist matters only near to the child, however large the scene is around it.
//  * repeat: only the nearest cells are evaluated. `least` is what any other copy is worth at p at least, so
//  the result is
//    exactly min(far, every copy): continuous, Lipschitz, and right for children that reach into neighbouring
//    cells.
// Values are cut above `least` only. What lies around such a node may make values up to some `reach` matter
// for the surface (an offset by r moves the surface to where f = r): least > reach is guaranteed, or the
// expression is refused.

#include <string>
#include <vector>

#include "geometry/sdf/sdf_ops.h"

namespace spinel {

struct SdfSupport {
    SdfBox box;
    double slope;  // c, in (0, 1]
};

// A resolved node: numbers complete and checked.
struct SdfTree {
    const SdfOperation* operation = nullptr;
    std::vector<float> numbers;
    std::vector<SdfTree> children;
    SdfSupport support;
    double reach = 0;  // values of f in [−reach, reach] matter to what is above
    bool far = false;  // twist, repeat: cut off, see above
    double least = 0;
    kernels::uint nearest_axes = 0;  // repeat: bits of axes where the nearest cell is enough; two cells on the others
    kernels::uint value_registers = 1;  // that the node needs
    double weight = 1;                  // roughly how many instructions it becomes
};

// Checks every node: operation, numbers, children, depth, count. An error names the node by its path.
Result<SdfTree> resolve_sdf(const SdfNode& root);

// A Lipschitz constant of f for segments inside of `domain`. Decides on the cut-offs of twists on the way.
double sdf_lipschitz(SdfTree& tree, const SdfBox& domain);

bool is_finite(const SdfBox& box);

// Of repeat along an axis: half the span of cell indices, (count − 1) / 2; a number beyond use where there is
// no end.
constexpr float SDF_ENDLESS = 1e9f;
float sdf_repeat_extent(std::span<const float> numbers, int axis);

// Unit quaternion (xyz axis, w) of rotate's numbers.
glm::dvec4 sdf_quaternion(std::span<const float> numbers);

}  // namespace spinel
