#include "geometry/sdf/sdf_reference.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "geometry/sdf/sdf_ops.h"

namespace spinel {
namespace {

using glm::dmat3;
using glm::dvec2;
using glm::dvec3;

double box_distance(dvec3 p, dvec3 half) {
    dvec3 q = glm::abs(p) - half;
    return glm::length(glm::max(q, dvec3(0))) + std::min(std::max({q.x, q.y, q.z}), 0.0);
}

double shape_distance(std::string_view op, const std::vector<float>& n, dvec3 p) {
    if (op == "sphere") return glm::length(p) - n[0];
    if (op == "box") return box_distance(p, 0.5 * dvec3(n[0], n[1], n[2]));
    if (op == "rounded_box") return box_distance(p, 0.5 * dvec3(n[0], n[1], n[2]) - double(n[3])) - n[3];
    if (op == "torus") return std::hypot(std::hypot(p.x, p.z) - n[0], p.y) - n[1];
    if (op == "cylinder") {
        dvec2 q(std::hypot(p.x, p.z) - n[0], std::abs(p.y) - 0.5 * n[1]);
        return glm::length(glm::max(q, dvec2(0))) + std::min(std::max(q.x, q.y), 0.0);
    }
    if (op == "plane") return glm::dot(glm::normalize(dvec3(n[0], n[1], n[2])), p) - n[3];
    assert(op == "gyroid");
    double frequency = 2 * 3.14159265358979323846 / n[0];
    dvec3 s = glm::sin(frequency * p);
    dvec3 c = glm::cos(frequency * p);
    return std::abs(s.x * c.y + s.y * c.z + s.z * c.x) / (std::sqrt(3.0) * frequency) - 0.5 * n[1];
}

double smooth_minimum(double a, double b, double k) {
    double h = std::max(k - std::abs(a - b), 0.0);
    return std::min(a, b) - h * h / (4 * k);
}

double combine(std::string_view op, double k, double a, double b) {
    if (op == "union") return std::min(a, b);
    if (op == "intersection") return std::max(a, b);
    if (op == "difference") return std::max(a, -b);
    if (op == "smooth_union") return smooth_minimum(a, b, k);
    if (op == "smooth_intersection") return -smooth_minimum(-a, -b, k);
    assert(op == "smooth_difference");
    return -smooth_minimum(-a, b, k);
}

// Rodrigues' rotation of p about an axis.
dvec3 rotate(dvec3 axis, double angle, dvec3 p) {
    axis = glm::normalize(axis);
    return std::cos(angle) * p + std::sin(angle) * glm::cross(axis, p) +
           (1 - std::cos(angle)) * glm::dot(axis, p) * axis;
}

// The union of all copies; where there is no end of them, of five cells about the point.
double repeat(const SdfNode& child, const std::vector<float>& n, dvec3 p) {
    dvec3 first(0);  // cell; half a cell where the count is even
    int count[3] = {1, 1, 1};
    for (int axis = 0; axis < 3; axis++) {
        if (n[axis] == 0) continue;
        const bool endless = n[3 + axis] == 0;
        count[axis] = endless ? 5 : int(n[3 + axis]);
        first[axis] = endless ? std::round(p[axis] / n[axis]) - 2 : -0.5 * (n[3 + axis] - 1);
    }
    double nearest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < count[0]; i++)
        for (int j = 0; j < count[1]; j++)
            for (int k = 0; k < count[2]; k++) {
                const dvec3 cell = first + dvec3(i, j, k);
                nearest = std::min(nearest, sdf_reference(child, p - cell * dvec3(n[0], n[1], n[2])));
            }
    return nearest;
}

}  // namespace

double sdf_reference(const SdfNode& node, dvec3 p) {
    const SdfOperation& operation = *find_sdf_operation(node.op);
    const std::vector<float> n = *complete_sdf_numbers(operation, node.numbers);
    auto child = [&](dvec3 q) { return sdf_reference(node.children[0], q); };
    switch (operation.role) {
        case SdfRole::shape: return shape_distance(node.op, n, p);
        case SdfRole::combine: {
            double value = child(p);
            for (std::size_t i = 1; i < node.children.size(); i++)
                value = combine(node.op, n.empty() ? 0 : n[0], value, sdf_reference(node.children[i], p));
            return value;
        }
        case SdfRole::translate: return child(p - dvec3(n[0], n[1], n[2]));
        case SdfRole::rotate: return child(rotate(dvec3(n[0], n[1], n[2]), -glm::radians(double(n[3])), p));
        case SdfRole::scale: return n[0] * child(p / double(n[0]));
        case SdfRole::repeat: return repeat(node.children[0], n, p);
        case SdfRole::twist: return child(rotate(dvec3(0, 1, 0), -n[0] * p.y, p));
        case SdfRole::elongate: {
            dvec3 half = 0.5 * dvec3(n[0], n[1], n[2]);
            return child(p - glm::clamp(p, -half, half));
        }
        case SdfRole::offset: return child(p) - n[0];
        case SdfRole::shell: return std::abs(child(p)) - 0.5 * n[0];
        case SdfRole::displace: {
            dvec3 s = glm::sin(double(n[1]) * p);
            return child(p) + n[0] * s.x * s.y * s.z;
        }
    }
    return 0;
}

}  // namespace spinel
