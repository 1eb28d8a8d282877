#pragma once
// Numbers and ranges as people read them, in messages, the reference page and written scenes.

#include <string>

#include "scene/scene_fields.h"

namespace spinel {

std::string number_text(double x);  // the shortest text that gives the same number back
std::string number_text(float x);
std::string range_text(const Range& range);  // "0 … 1", "> 0", "≥ 0", "any"

}  // namespace spinel
