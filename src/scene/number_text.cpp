#include "scene/number_text.h"

#include <charconv>
#include <cmath>

namespace spinel {
namespace {

template <class T>
std::string shortest(T x) {
    char buffer[64];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, x).ptr;
    return std::string(buffer, end);
}

}  // namespace

std::string number_text(double x) { return shortest(x); }
std::string number_text(float x) { return shortest(x); }

std::string range_text(const Range& range) {
    const bool below = std::isfinite(range.lower), above = std::isfinite(range.upper);
    if (below && above)
        return (range.open ? "between " : "") + number_text(range.lower) + (range.open ? " and " : " … ") +
               number_text(range.upper) + (range.open ? ", without these" : "");
    if (below) return (range.open ? "> " : "≥ ") + number_text(range.lower);
    if (above) return (range.open ? "< " : "≤ ") + number_text(range.upper);
    return "any";
}

}  // namespace spinel
