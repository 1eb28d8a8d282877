#pragma once
// Numbers as formulas: "0.85*cos(0.55*t)". Operators + − * / ^ with the usual precedence, parentheses, names,
// functions.

#include <map>
#include <string>
#include <string_view>
#include <variant>

namespace spinel {

// What is wrong with a formula, and where: a byte of its text.
struct ExpressionFault {
    std::size_t position = 0;
    std::string message;
};

using Variables = std::map<std::string, double, std::less<>>;

// The value, a finite number. `pi` is known besides the variables; functions: expression_functions().
std::variant<double, ExpressionFault> evaluate_expression(std::string_view text, const Variables& variables);

// "abs(x), clamp(x, low, high), …", for messages and the reference.
std::string expression_functions();

// Whether a variable may have this name: a letter, then letters, digits and _; no function's and not pi.
bool is_variable_name(std::string_view name);

}  // namespace spinel
