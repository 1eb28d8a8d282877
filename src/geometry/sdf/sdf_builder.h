#pragma once
// From an SDF expression to the tape that kernels/sdf.h interprets.

#include <vector>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

struct SdfData {
    std::vector<kernels::SdfOp> ops;
    kernels::Sdf sdf;  // op_first = 0: relative to `ops`
};

// The solid ends at the bounds where the user gave some; an expression without end must have them.
// Errors name the part of the expression by its path: "union[1].translate: …".
Result<SdfData> build_sdf(const SdfGeometry& geometry);

}  // namespace spinel
