#include "geometry/sdf/sdf_analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace spinel {
namespace {

using glm::dvec3;
using glm::dvec4;

constexpr double UNBOUNDED = std::numeric_limits<double>::infinity();
const double INV_SQRT3 = 1.0 / std::sqrt(3.0);

SdfBox grown(const SdfBox& box, double r) { return {box.lower - dvec3(r), box.upper + dvec3(r)}; }

SdfBox hull(const SdfBox& a, const SdfBox& b) { return {glm::min(a.lower, b.lower), glm::max(a.upper, b.upper)}; }

bool contains(const SdfBox& outer, const SdfBox& inner) {
    return glm::all(glm::lessThanEqual(outer.lower, inner.lower)) &&
           glm::all(glm::greaterThanEqual(outer.upper, inner.upper));
}

dvec3 rotate(dvec4 q, dvec3 p) {
    dvec3 axis(q);
    return p + 2.0 * glm::cross(axis, glm::cross(axis, p) + q.w * p);
}

// The box around a rotated box; 0·∞ counts as 0.
SdfBox rotated(dvec4 q, const SdfBox& box) {
    SdfBox result = {dvec3(0), dvec3(0)};
    for (int j = 0; j < 3; j++) {
        dvec3 unit(0);
        unit[j] = 1;
        dvec3 column = rotate(q, unit);
        for (int i = 0; i < 3; i++) {
            if (column[i] == 0) continue;
            double a = column[i] * box.lower[j];
            double b = column[i] * box.upper[j];
            result.lower[i] += std::min(a, b);
            result.upper[i] += std::max(a, b);
        }
    }
    return result;
}

// Furthest distance from the y axis.
double cylinder_radius(const SdfBox& box) {
    return std::hypot(std::max(std::abs(box.lower.x), std::abs(box.upper.x)),
                      std::max(std::abs(box.lower.z), std::abs(box.upper.z)));
}

double box_size(const SdfBox& box) {
    dvec3 e = box.upper - box.lower;
    return e.x + e.y + e.z;
}

// f = max(a, b, …). The largest of distances to boxes is at least the greatest gap along an axis to their
// intersection, and so at least 1/√3 of the distance to it; if the intersection is one of the boxes, all of
// it.
SdfSupport intersected(const std::vector<SdfTree>& children) {
    SdfBox box = children[0].support.box;
    const SdfSupport* smallest = &children[0].support;
    double slope = 1;
    for (const SdfTree& child : children) {
        const SdfSupport& support = child.support;
        box = {glm::max(box.lower, support.box.lower), glm::min(box.upper, support.box.upper)};
        slope = std::min(slope, support.slope);
        if (box_size(support.box) < box_size(smallest->box)) smallest = &support;
    }
    bool empty = glm::any(glm::greaterThan(box.lower, box.upper));
    if (empty || contains(box, smallest->box)) return *smallest;
    return {box, slope * INV_SQRT3};
}

SdfSupport united(const SdfSupport& a, const SdfSupport& b) { return {hull(a.box, b.box), std::min(a.slope, b.slope)}; }

// How far below the least of n equal values a fold of smooth minima can end: each step adds (k − depth)² /
// 4k.
double smooth_depth(std::size_t count, double k) {
    double depth = 0;
    for (std::size_t i = 1; i < count && depth < k; i++) depth += (k - depth) * (k - depth) / (4 * k);
    return depth;
}

SdfSupport combined(const SdfTree& node) {
    SdfSupport support = node.children[0].support;
    switch (node.operation->kernel_op) {
        case kernels::SDF_OP_MIN:
        case kernels::SDF_OP_SMOOTH_MIN:
            for (std::size_t i = 1; i < node.children.size(); i++) support = united(support, node.children[i].support);
            if (node.operation->kernel_op == kernels::SDF_OP_SMOOTH_MIN)
                support.box = grown(support.box, smooth_depth(node.children.size(), node.numbers[0]) / support.slope);
            return support;
        case kernels::SDF_OP_MAX:
        case kernels::SDF_OP_SMOOTH_MAX:  // never below the maximum
            return intersected(node.children);
        default: return support;  // differences: within the first child
    }
}

// Copies on a lattice; see the header for the cut-off. The error says what would fit.
std::optional<std::string> analyse_repeat(SdfTree& node) {
    const SdfSupport& child = node.children[0].support;
    node.support = child;
    node.far = true;
    node.least = UNBOUNDED;
    for (int axis = 0; axis < 3; axis++) {
        double period = node.numbers[axis];
        double extent = sdf_repeat_extent(node.numbers, axis);
        if (period == 0 || extent == 0) {
            node.nearest_axes |= 1u << axis;
            continue;
        }
        // Copies that are not evaluated are half a period away at least, or a whole one if two cells are.
        double side = std::max(-child.box.lower[axis], child.box.upper[axis]);
        double half_gap = child.slope * (0.5 * period - side);
        double gap = child.slope * (period - side);
        bool nearest = half_gap > 1.01 * node.reach && half_gap > 0.125 * child.slope * period;
        if (nearest) node.nearest_axes |= 1u << axis;
        double least = nearest ? half_gap : gap;
        if (!(least > 1.01 * node.reach)) {
            return fmt::format(
                "period_{} is {}, but the child reaches to {:.6g} from its place{}: it must stay within one "
                "period",
                "xyz"[axis], period, side,
                node.reach > 0 ? fmt::format(" and what is around it by {:.6g} more", node.reach / child.slope) : "");
        }
        node.least = std::min(node.least, least);
        double shift = extent >= SDF_ENDLESS ? UNBOUNDED : period * extent;
        node.support.box.lower[axis] -= shift;
        node.support.box.upper[axis] += shift;
    }
    if (node.least == UNBOUNDED) node.far = false;  // a single copy
    return std::nullopt;
}

// The reach that a node asks of its children.
double child_reach(const SdfTree& node) {
    switch (node.operation->role) {
        case SdfRole::combine:
            switch (node.operation->kernel_op) {
                case kernels::SDF_OP_SMOOTH_MIN:
                case kernels::SDF_OP_SMOOTH_MAX:
                case kernels::SDF_OP_SMOOTH_SUBTRACT:
                    // A result of v comes from values within depth of it, and from others up to k further.
                    return node.reach + node.numbers[0] + smooth_depth(node.children.size(), node.numbers[0]);
                default: return node.reach;
            }
        case SdfRole::scale: return node.reach / node.numbers[0];
        case SdfRole::offset: return node.reach + std::abs(double(node.numbers[0]));
        case SdfRole::shell: return node.reach + 0.5 * node.numbers[0];
        case SdfRole::displace: return node.reach + std::abs(double(node.numbers[0]));
        default: return node.reach;
    }
}

// Children are evaluated one after the other beside one register for what has been folded. Minima and maxima
// start with the most demanding child (Sethi, Ullman, "The Generation of Optimal Code for Arithmetic
// Expressions", JACM 17(4), 1970), so that balanced trees need few more registers than their depth;
// differences and smooth folds keep their order.
kernels::uint registers_needed(const SdfTree& node) {
    const std::vector<SdfTree>& children = node.children;
    kernels::uint op = node.operation->kernel_op;
    if (node.operation->role == SdfRole::shape) return 1;
    if (node.operation->role == SdfRole::repeat) return children[0].value_registers + (node.nearest_axes == 7 ? 0 : 1);
    if (node.operation->role != SdfRole::combine) return children[0].value_registers;
    bool commutes = op == kernels::SDF_OP_MIN || op == kernels::SDF_OP_MAX;
    kernels::uint first = children[0].value_registers;
    kernels::uint others = 0;
    for (std::size_t i = 1; i < children.size(); i++) {
        kernels::uint need = children[i].value_registers;
        if (commutes && need > first) std::swap(first, need);
        others = std::max(others, need);
    }
    return std::max(first, others + 1);
}

double weight_of(const SdfTree& node) {
    double weight = 1;
    for (const SdfTree& child : node.children) weight += child.weight;
    if (node.operation->role == SdfRole::repeat) weight *= std::exp2(3 - std::popcount(node.nearest_axes));
    return weight;
}

class Resolver {
  public:
    // Fills `node` from `source`; an error otherwise.
    std::optional<Error> resolve(const SdfNode& source, const std::string& path, double reach, std::size_t depth,
                                 SdfTree& node) {
        if (depth > SDF_MAX_DEPTH) return Error{fmt::format("{}: nested deeper than {}", path, SDF_MAX_DEPTH)};
        if (++count_ > SDF_MAX_NODES)
            return Error{fmt::format("{}: the expression has more than {} operations", path, SDF_MAX_NODES)};
        node.operation = find_sdf_operation(source.op);
        if (!node.operation) return Error{fmt::format("{}: {}", path, unknown_sdf_operation(source.op))};
        if (auto fault = sdf_child_fault(*node.operation, source.children.size()))
            return Error{fmt::format("{}: {}", path, *fault)};
        Result<std::vector<float>> numbers = complete_sdf_numbers(*node.operation, source.numbers);
        if (!numbers) return Error{fmt::format("{}: {}", path, numbers.error().message)};
        node.numbers = *std::move(numbers);
        node.reach = reach;
        node.children.resize(source.children.size());
        double inner_reach = 0;
        if (!node.children.empty()) inner_reach = child_reach(node);
        for (std::size_t i = 0; i < node.children.size(); i++) {
            const SdfNode& child = source.children[i];
            std::string child_path = source.children.size() > 1 ? fmt::format("{}[{}].{}", path, i, child.op)
                                                                : fmt::format("{}.{}", path, child.op);
            if (auto error = resolve(child, child_path, inner_reach, depth + 1, node.children[i])) return error;
        }
        if (auto fault = find_support(node)) return Error{fmt::format("{}: {}", path, *fault)};
        node.weight = weight_of(node);
        node.value_registers = registers_needed(node);
        if (node.value_registers > kernels::SDF_VALUE_REGISTERS) {
            return Error{fmt::format("{}: needs {} value registers, of which there are {}: nest less deeply", path,
                                     node.value_registers, kernels::SDF_VALUE_REGISTERS)};
        }
        return std::nullopt;
    }

  private:
    static std::optional<std::string> find_support(SdfTree& node) {
        const std::vector<float>& n = node.numbers;
        if (node.operation->role == SdfRole::shape) {
            node.support = {node.operation->shape(n).bounds, 1};
            return std::nullopt;
        }
        SdfSupport child = node.children[0].support;
        switch (node.operation->role) {
            case SdfRole::shape: break;
            case SdfRole::combine: child = combined(node); break;
            case SdfRole::translate:
                child.box.lower += dvec3(n[0], n[1], n[2]);
                child.box.upper += dvec3(n[0], n[1], n[2]);
                break;
            case SdfRole::rotate: child.box = rotated(sdf_quaternion(n), child.box); break;
            case SdfRole::scale:
                child.box.lower *= double(n[0]);
                child.box.upper *= double(n[0]);
                break;
            case SdfRole::repeat: return analyse_repeat(node);
            case SdfRole::twist: {  // keeps y and the distance from the axis, so the cylinder around the
                                    // child
                double r = cylinder_radius(child.box);
                child.box = {dvec3(-r, child.box.lower.y, -r), dvec3(r, child.box.upper.y, r)};
                break;
            }
            case SdfRole::elongate:
                child.box.lower -= 0.5 * dvec3(n[0], n[1], n[2]);
                child.box.upper += 0.5 * dvec3(n[0], n[1], n[2]);
                break;
            case SdfRole::offset: child.box = grown(child.box, std::max(double(n[0]), 0.0) / child.slope); break;
            case SdfRole::shell: child.box = grown(child.box, 0.5 * n[0] / child.slope); break;
            case SdfRole::displace: child.box = grown(child.box, std::abs(double(n[0])) / child.slope); break;
        }
        node.support = child;
        return std::nullopt;
    }

    std::size_t count_ = 0;
};

}  // namespace

bool is_finite(const SdfBox& box) {
    constexpr double limit = 1e9;  // beyond, floats resolve nothing
    return glm::all(glm::greaterThan(box.lower, dvec3(-limit))) && glm::all(glm::lessThan(box.upper, dvec3(limit)));
}

float sdf_repeat_extent(std::span<const float> numbers, int axis) {
    if (numbers[axis] == 0) return 0;
    return numbers[3 + axis] == 0 ? SDF_ENDLESS : 0.5f * (numbers[3 + axis] - 1);
}

glm::dvec4 sdf_quaternion(std::span<const float> numbers) {
    dvec3 axis = glm::normalize(dvec3(numbers[0], numbers[1], numbers[2]));
    double half = 0.5 * glm::radians(double(numbers[3]));
    return dvec4(std::sin(half) * axis, std::cos(half));
}

Result<SdfTree> resolve_sdf(const SdfNode& root) {
    SdfTree tree;
    if (auto error = Resolver().resolve(root, root.op.empty() ? "expression" : root.op, 0, 1, tree)) return *error;
    return tree;
}

double sdf_lipschitz(SdfTree& node, const SdfBox& domain) {
    const std::vector<float>& n = node.numbers;
    switch (node.operation->role) {
        case SdfRole::shape: return 1;
        case SdfRole::combine: {  // smooth folds blend gradients convexly
            double greatest = 0;
            for (SdfTree& child : node.children) greatest = std::max(greatest, sdf_lipschitz(child, domain));
            return greatest;
        }
        case SdfRole::translate: {
            dvec3 shift(n[0], n[1], n[2]);
            return sdf_lipschitz(node.children[0], {domain.lower - shift, domain.upper - shift});
        }
        case SdfRole::rotate: {
            dvec4 q = sdf_quaternion(n);
            return sdf_lipschitz(node.children[0], rotated(dvec4(-dvec3(q), q.w), domain));
        }
        case SdfRole::scale:
            return sdf_lipschitz(node.children[0], {domain.lower / double(n[0]), domain.upper / double(n[0])});
        case SdfRole::repeat: {
            SdfBox cell = domain;
            for (int axis = 0; axis < 3; axis++) {
                if (n[axis] == 0) continue;
                bool endless = n[3 + axis] == 0;
                cell.lower[axis] = endless ? -n[axis] : std::min(-double(n[axis]), domain.lower[axis]);
                cell.upper[axis] = endless ? n[axis] : std::max(double(n[axis]), domain.upper[axis]);
            }
            return std::max(sdf_lipschitz(node.children[0], cell), node.support.slope);
        }
        case SdfRole::twist: {
            double radius = cylinder_radius(domain);
            const SdfSupport& support = node.support;
            double solid_radius = support.box.upper.x;
            double least = std::max(0.5 * support.slope * solid_radius, 1.25 * node.reach);
            double far_radius = cylinder_radius(grown(support.box, least / support.slope));
            double floor = 0;
            if (is_finite(support.box) && radius > 1.5 * far_radius) {
                node.far = true;
                node.least = least;
                radius = far_radius;
                floor = support.slope;
            }
            SdfBox inner = {dvec3(-radius, domain.lower.y, -radius), dvec3(radius, domain.upper.y, radius)};
            // A shear by a: its largest singular value is (a + √(a² + 4)) / 2.
            double shear = std::abs(double(n[0])) * radius;
            double stretch = 0.5 * (shear + std::sqrt(shear * shear + 4));
            return std::max(floor, stretch * sdf_lipschitz(node.children[0], inner));
        }
        case SdfRole::elongate:
        case SdfRole::offset:
        case SdfRole::shell: return sdf_lipschitz(node.children[0], domain);
        case SdfRole::displace:  // |∇ sin·sin·sin|² is affine in each sin², so greatest at a corner: 1
            return sdf_lipschitz(node.children[0], domain) + std::abs(double(n[0]) * double(n[1]));
    }
    return 1;
}

}  // namespace spinel
