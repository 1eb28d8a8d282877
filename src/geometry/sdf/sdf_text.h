#pragma once
// SDF expressions as text: difference(box(2, 2, 2), translate(0.5, 0, 0, sphere(1))). An operation's numbers
// stand before its children; `#` starts a comment that runs to the end of the line; space means nothing.

#include <string>
#include <string_view>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

// Errors begin with where:line:column (where: a file's name; left out if empty).
Result<SdfNode> parse_sdf_text(std::string_view text, const std::string& where);

// One line that parse_sdf_text reads back to the same tree, bit by bit (numbers are finite).
std::string sdf_text(const SdfNode& node);

}  // namespace spinel
