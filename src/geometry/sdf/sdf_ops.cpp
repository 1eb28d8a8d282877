#include "geometry/sdf/sdf_ops.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace spinel {
namespace {

constexpr float SMALL = 1e-6f;
constexpr float LARGE = 1e6f;
constexpr double UNBOUNDED = std::numeric_limits<double>::infinity();

SdfBox centred(double x, double y, double z) { return {{-x, -y, -z}, {x, y, z}}; }

SdfShape sphere(std::span<const float> n) {
    return {kernels::SDF_OP_SPHERE, vec4(n[0], 0, 0, 0), centred(n[0], n[0], n[0])};
}

SdfShape box(std::span<const float> n) {
    vec3 half = 0.5f * vec3(n[0], n[1], n[2]);
    return {kernels::SDF_OP_BOX, vec4(half, 0), centred(half.x, half.y, half.z)};
}

SdfShape rounded_box(std::span<const float> n) {
    vec3 half = 0.5f * vec3(n[0], n[1], n[2]);
    return {kernels::SDF_OP_BOX, vec4(half - n[3], n[3]), centred(half.x, half.y, half.z)};
}
std::optional<std::string> rounded_box_fault(std::span<const float> n) {
    float most = 0.5f * std::min({n[0], n[1], n[2]});
    if (n[3] <= most) return std::nullopt;
    return fmt::format("radius is {}, allowed is at most half the shortest edge, {}", n[3], most);
}

SdfShape torus(std::span<const float> n) {
    return {kernels::SDF_OP_TORUS, vec4(n[0], n[1], 0, 0), centred(n[0] + n[1], n[1], n[0] + n[1])};
}

SdfShape cylinder(std::span<const float> n) {
    return {kernels::SDF_OP_CYLINDER, vec4(n[0], 0.5f * n[1], 0, 0), centred(n[0], 0.5 * n[1], n[0])};
}

std::optional<std::string> direction_fault(std::span<const float> n) {
    if (std::hypot(double(n[0]), double(n[1]), double(n[2])) > 1e-6) return std::nullopt;
    return "the direction is zero, it needs a length";
}

SdfShape plane(std::span<const float> n) {
    glm::dvec3 normal = glm::normalize(glm::dvec3(n[0], n[1], n[2]));
    SdfBox bounds = centred(UNBOUNDED, UNBOUNDED, UNBOUNDED);
    for (int axis = 0; axis < 3; axis++) {  // along an axis the half-space is a box with one side
        if (normal[axis] == 1.0) bounds.upper[axis] = n[3];
        if (normal[axis] == -1.0) bounds.lower[axis] = -double(n[3]);
    }
    return {kernels::SDF_OP_PLANE, vec4(vec3(normal), n[3]), bounds};
}

SdfShape gyroid(std::span<const float> n) {
    double frequency = 2.0 * 3.14159265358979323846 / n[0];
    return {kernels::SDF_OP_GYROID, vec4(frequency, 1.0 / (std::sqrt(3.0) * frequency), 0.5 * n[1], 0),
            centred(UNBOUNDED, UNBOUNDED, UNBOUNDED)};
}

// With the count of copies given, 0 means no end to them.
std::optional<std::string> repeat_fault(std::span<const float> n) {
    for (int axis = 0; axis < 3; axis++) {
        if (n[axis] == 0 && n[3 + axis] > 1)
            return fmt::format("count_{0} is {1} but period_{0} is 0", "xyz"[axis], n[3 + axis]);
        if (n[axis] != 0 && n[axis] < SMALL)
            return fmt::format("period_{} is {}, allowed is 0 or at least {}", "xyz"[axis], n[axis], SMALL);
        if (n[3 + axis] != std::floor(n[3 + axis]))
            return fmt::format("count_{} is {}, allowed are whole numbers", "xyz"[axis], n[3 + axis]);
    }
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) return "all periods are 0, one must be greater";
    return std::nullopt;
}

SdfParameter size(std::string_view name, std::string_view doc) { return {name, doc, SMALL, LARGE}; }
SdfParameter coordinate(std::string_view name, std::string_view doc) { return {name, doc, -LARGE, LARGE}; }

SdfOperation shape_row(std::string_view name, std::string_view doc, std::vector<SdfParameter> parameters,
                       SdfShape (*make)(std::span<const float>), std::string_view example) {
    return {.name = name,
            .doc = doc,
            .role = SdfRole::shape,
            .parameters = std::move(parameters),
            .child_minimum = 0,
            .child_maximum = 0,
            .shape = make,
            .example = example};
}

SdfOperation combine_row(std::string_view name, std::string_view doc, std::vector<SdfParameter> parameters,
                         kernels::uint op, std::string_view example) {
    return {.name = name,
            .doc = doc,
            .role = SdfRole::combine,
            .parameters = std::move(parameters),
            .child_minimum = 2,
            .child_maximum = SDF_ANY_COUNT,
            .kernel_op = op,
            .example = example};
}

SdfOperation change_row(std::string_view name, std::string_view doc, SdfRole role, std::vector<SdfParameter> parameters,
                        std::string_view example) {
    return {.name = name,
            .doc = doc,
            .role = role,
            .parameters = std::move(parameters),
            .child_minimum = 1,
            .child_maximum = 1,
            .example = example};
}

SdfOperation with_fault(SdfOperation row, std::optional<std::string> (*fault)(std::span<const float>)) {
    row.fault = fault;
    return row;
}

std::vector<SdfOperation> make_table() {
    const SdfParameter blend = size("k", "width of the blend: where the two distances differ by less");
    return {
        shape_row("sphere", "Sphere about the origin.", {size("radius", "of the sphere")}, sphere, "sphere(0.8)"),
        shape_row("box", "Box about the origin.",
                  {size("x", "full edge"), size("y", "full edge"), size("z", "full edge")}, box, "box(1, 1.4, 0.6)"),
        with_fault(shape_row("rounded_box", "Box about the origin with rounded edges.",
                             {size("x", "full edge"), size("y", "full edge"), size("z", "full edge"),
                              SdfParameter{"radius", "of the edges", 0, LARGE}},
                             rounded_box, "rounded_box(1, 1.4, 0.6, 0.2)"),
                   rounded_box_fault),
        shape_row("torus", "Ring about the y axis.",
                  {size("ring", "radius of the ring's centre line"), size("tube", "radius of the tube")}, torus,
                  "torus(0.7, 0.25)"),
        shape_row("cylinder", "Capped cylinder along the y axis, about the origin.",
                  {size("radius", "of the cylinder"), size("height", "full height")}, cylinder, "cylinder(0.6, 1.2)"),
        with_fault(shape_row("plane", "Half-space below a plane: solid where dot(normal, p) < distance. Unbounded.",
                             {coordinate("nx", "normal"), coordinate("ny", "normal"), coordinate("nz", "normal"),
                              coordinate("distance", "of the plane from the origin, along the normal")},
                             plane, "intersection(sphere(1), plane(1, 2, 3, 0.1))"),
                   direction_fault),
        shape_row("gyroid", "Triply periodic sheet sin x cos y + sin y cos z + sin z cos x = 0. Unbounded.",
                  {size("period", "edge of the cubic cell"), size("thickness", "of the sheet where it is thinnest")},
                  gyroid, "intersection(sphere(1), gyroid(0.9, 0.15))"),

        combine_row("union", "Solid where any child is.", {}, kernels::SDF_OP_MIN,
                    "union(sphere(0.6), translate(0.5, 0.1, 0.2, box(1, 0.5, 0.7)))"),
        combine_row("intersection", "Solid where all children are.", {}, kernels::SDF_OP_MAX,
                    "intersection(sphere(0.6), translate(0.3, 0.1, 0.2, box(1, 0.5, 0.7)))"),
        combine_row("difference", "The first child without the others.", {}, kernels::SDF_OP_SUBTRACT,
                    "difference(sphere(0.8), translate(0.5, 0.1, 0.2, box(1, 0.5, 0.7)))"),
        combine_row("smooth_union", "Union with a blend.", {blend}, kernels::SDF_OP_SMOOTH_MIN,
                    "smooth_union(0.4, sphere(0.6), translate(0.5, 0.1, 0.2, box(1, 0.5, 0.7)))"),
        combine_row("smooth_intersection", "Intersection with a blend.", {blend}, kernels::SDF_OP_SMOOTH_MAX,
                    "smooth_intersection(0.2, sphere(0.6), translate(0.3, 0.1, 0.2, box(1, 0.5, 0.7)))"),
        combine_row("smooth_difference", "Difference with a blend.", {blend}, kernels::SDF_OP_SMOOTH_SUBTRACT,
                    "smooth_difference(0.2, sphere(0.8), translate(0.5, 0.1, 0.2, box(1, 0.5, 0.7)))"),

        change_row("translate", "Moves the child.", SdfRole::translate,
                   {coordinate("x", "shift"), coordinate("y", "shift"), coordinate("z", "shift")},
                   "translate(0.5, -0.25, 1, box(1, 1, 0.5))"),
        with_fault(change_row("rotate", "Turns the child about an axis through the origin, counter-clockwise.",
                              SdfRole::rotate,
                              {coordinate("ax", "axis"), coordinate("ay", "axis"), coordinate("az", "axis"),
                               coordinate("degrees", "angle")},
                              "rotate(1, 2, -0.5, 35, box(1, 1.4, 0.5))"),
                   direction_fault),
        change_row("scale", "Scales the child about the origin.", SdfRole::scale, {size("factor", "of all axes")},
                   "scale(1.7, torus(0.7, 0.25))"),
        with_fault(
            change_row("repeat",
                       "Copies of the child on a lattice. The child must not reach beyond one period from its "
                       "place.",
                       SdfRole::repeat,
                       {SdfParameter{"period_x", "distance of the copies, 0: not along this axis", 0, LARGE},
                        SdfParameter{"period_y", "distance of the copies, 0: not along this axis", 0, LARGE},
                        SdfParameter{"period_z", "distance of the copies, 0: not along this axis", 0, LARGE},
                        SdfParameter{"count_x", "of copies, centred about the origin; 0: no end", 0, 10000, 0.0f},
                        SdfParameter{"count_y", "of copies, centred about the origin; 0: no end", 0, 10000, 0.0f},
                        SdfParameter{"count_z", "of copies, centred about the origin; 0: no end", 0, 10000, 0.0f}},
                       "repeat(0.8, 0, 1.1, 3, 0, 2, translate(0.1, 0, 0, box(0.5, 0.9, 0.4)))"),
            repeat_fault),
        change_row("twist", "Turns the child about the y axis, ever further along it.", SdfRole::twist,
                   {SdfParameter{"rate", "radians per unit of y", -1000, 1000}}, "twist(1.5, box(0.6, 2, 0.3))"),
        change_row("elongate", "Cuts the child at its middle planes and draws the halves apart.", SdfRole::elongate,
                   {SdfParameter{"x", "how far apart", 0, LARGE}, SdfParameter{"y", "how far apart", 0, LARGE},
                    SdfParameter{"z", "how far apart", 0, LARGE}},
                   "elongate(0.5, 0, 1, torus(0.5, 0.2))"),
        change_row("offset", "Grows the child all around.", SdfRole::offset,
                   {SdfParameter{"distance", "outwards; negative: inwards", -LARGE, LARGE}},
                   "offset(0.15, box(0.8, 1, 0.5))"),
        change_row("shell", "Hollows the child: a wall to both sides of its surface.", SdfRole::shell,
                   {size("thickness", "of the wall")}, "shell(0.1, box(1, 1.4, 0.6))"),
        change_row("displace", "Adds amplitude·sin(frequency·x)·sin(frequency·y)·sin(frequency·z) to the distance.",
                   SdfRole::displace,
                   {SdfParameter{"amplitude", "greatest displacement", -LARGE, LARGE},
                    SdfParameter{"frequency", "radians per unit", 0, LARGE}},
                   "displace(0.05, 9, sphere(0.8))"),
    };
}

}  // namespace

std::span<const SdfOperation> sdf_operations() {
    static const std::vector<SdfOperation> table = make_table();
    return table;
}

const SdfOperation* find_sdf_operation(std::string_view name) {
    for (const SdfOperation& operation : sdf_operations())
        if (operation.name == name) return &operation;
    return nullptr;
}

std::string unknown_sdf_operation(std::string_view name) {
    std::string message = fmt::format("unknown operation '{}'; available: ", name.substr(0, 40));
    std::string_view separator = "";
    for (const SdfOperation& operation : sdf_operations()) {
        message += separator;
        message += operation.name;
        separator = ", ";
    }
    return message;
}

namespace {

std::string signature(const SdfOperation& operation) {
    std::string names;
    for (const SdfParameter& parameter : operation.parameters) {
        if (!names.empty()) names += ", ";
        names += parameter.name;
        if (parameter.fallback) names += fmt::format(" = {}", *parameter.fallback);
    }
    return names.empty() ? "no numbers" : "numbers: " + names;
}

}  // namespace

Result<std::vector<float>> complete_sdf_numbers(const SdfOperation& operation, std::span<const float> numbers) {
    const std::vector<SdfParameter>& parameters = operation.parameters;
    std::size_t needed = 0;
    while (needed < parameters.size() && !parameters[needed].fallback) needed++;
    if (numbers.size() < needed || numbers.size() > parameters.size()) {
        return Error{fmt::format("{} takes {}; {} given", operation.name, signature(operation), numbers.size())};
    }
    std::vector<float> complete(numbers.begin(), numbers.end());
    for (std::size_t i = complete.size(); i < parameters.size(); i++) complete.push_back(*parameters[i].fallback);
    for (std::size_t i = 0; i < complete.size(); i++) {
        const SdfParameter& parameter = parameters[i];
        if (!(complete[i] >= parameter.minimum && complete[i] <= parameter.maximum)) {  // also rejects NaN
            return Error{fmt::format("{} of {} is {}, allowed is {} to {}", parameter.name, operation.name, complete[i],
                                     parameter.minimum, parameter.maximum)};
        }
    }
    if (operation.fault) {
        if (std::optional<std::string> fault = operation.fault(complete))
            return Error{fmt::format("{}: {}", operation.name, *fault)};
    }
    return complete;
}

std::optional<std::string> sdf_child_fault(const SdfOperation& operation, std::size_t child_count) {
    if (child_count >= operation.child_minimum && child_count <= operation.child_maximum) return std::nullopt;
    std::string allowed = operation.child_maximum == 0 ? "no children"
                          : operation.child_maximum == SDF_ANY_COUNT
                              ? fmt::format("{} or more children", operation.child_minimum)
                              : "one child";
    return fmt::format("{} takes {}; {} given", operation.name, allowed, child_count);
}

}  // namespace spinel
