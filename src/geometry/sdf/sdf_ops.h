#pragma once
// The operations of SDF expressions: one table, from which the readers (text and JSON), `spinel list sdf`,
// the error messages and the contract tests come.
//
// To add a shape: a case in both interpreters of kernels/sdf.h, a row in sdf_ops.cpp with the function that
// turns its numbers into that instruction and its bounds, and its closed form in sdf_reference.cpp.

#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "kernels/sdf_ops.h"
#include "spinel/scene.h"

namespace spinel {

// What an operation does to its children; one case of the compiler each.
enum class SdfRole {
    shape,    // no children
    combine,  // hard or smooth set operation of any number of children
    translate,
    rotate,
    scale,
    repeat,
    twist,
    elongate,
    offset,
    shell,
    displace,
};

struct SdfParameter {
    std::string_view name;
    std::string_view doc;
    float minimum;
    float maximum;
    std::optional<float> fallback = std::nullopt;  // none: must be given. Only the last parameters may have one
};

// A box that may be infinite in any direction.
struct SdfBox {
    glm::dvec3 lower;
    glm::dvec3 upper;
};

// A shape as an instruction, with the bounds of its solid. Shapes are exact outside of these, or at least
// never less than the distance to them, and have a Lipschitz constant of 1.
struct SdfShape {
    kernels::uint op;
    vec4 data;
    SdfBox bounds;
};

struct SdfOperation {
    std::string_view name;
    std::string_view doc;
    SdfRole role;
    std::vector<SdfParameter> parameters;
    std::size_t child_minimum;
    std::size_t child_maximum;
    SdfShape (*shape)(std::span<const float> numbers) = nullptr;                    // of role shape
    kernels::uint kernel_op = 0;                                                    // of role combine
    std::optional<std::string> (*fault)(std::span<const float> numbers) = nullptr;  // what ranges cannot say
    std::string_view example = {};                                                  // a bounded use of it, as text
};

constexpr std::size_t SDF_ANY_COUNT = ~std::size_t(0);
constexpr std::size_t SDF_MAX_DEPTH = 200;        // of nesting
constexpr std::size_t SDF_MAX_NODES = 1'000'000;  // of an expression

std::span<const SdfOperation> sdf_operations();

// Null: there is none of that name.
const SdfOperation* find_sdf_operation(std::string_view name);

// "unknown operation 'spheer'; available: sphere, box, …"
std::string unknown_sdf_operation(std::string_view name);

// The numbers with defaults filled in, or what is wrong with them: too few, too many, out of range.
Result<std::vector<float>> complete_sdf_numbers(const SdfOperation& operation, std::span<const float> numbers);

// What is wrong with that many children, if anything.
std::optional<std::string> sdf_child_fault(const SdfOperation& operation, std::size_t child_count);

}  // namespace spinel
