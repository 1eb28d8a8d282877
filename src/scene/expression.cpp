#include "scene/expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "kernels/random.h"

namespace spinel {
namespace {

constexpr int max_depth = 64;  // of parentheses, signs and powers within each other

using Arguments = std::span<const double>;

double smoothstep(double low, double high, double x) {
    const double u = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return u * u * (3 - 2 * u);
}

// Uniform in [0, 1), another for each pair of whole parts.
double random(double a, double b) {
    if (!std::isfinite(a) || !std::isfinite(b)) return std::nan("");
    const auto bits = [](double x) { return kernels::uint(std::int64_t(std::floor(std::clamp(x, -1e15, 1e15)))); };
    return kernels::uint_to_unit_float(kernels::hash_combine(kernels::hash_uint(bits(a)), bits(b)));
}

// Through times and values, t0, v0, t1, v1 …: linear between, constant outside.
double keys(Arguments a) {
    const double t = a[0];
    if (t <= a[1]) return a[2];
    for (std::size_t i = 3; i + 1 < a.size(); i += 2)
        if (t < a[i]) return a[i - 1] + (a[i + 1] - a[i - 1]) * (t - a[i - 2]) / (a[i] - a[i - 2]);
    return a.back();
}

struct Function {
    std::string_view name;
    std::string_view usage;
    std::size_t least, most;  // arguments
    double (*call)(Arguments a);
};

constexpr std::size_t many = 2001;

constexpr Function functions[] = {
    {"abs", "abs(x)", 1, 1, [](Arguments a) { return std::abs(a[0]); }},
    {"ceil", "ceil(x)", 1, 1, [](Arguments a) { return std::ceil(a[0]); }},
    {"clamp", "clamp(x, low, high)", 3, 3, [](Arguments a) { return std::min(std::max(a[0], a[1]), a[2]); }},
    {"cos", "cos(x)", 1, 1, [](Arguments a) { return std::cos(a[0]); }},
    {"exp", "exp(x)", 1, 1, [](Arguments a) { return std::exp(a[0]); }},
    {"floor", "floor(x)", 1, 1, [](Arguments a) { return std::floor(a[0]); }},
    {"fract", "fract(x)", 1, 1, [](Arguments a) { return a[0] - std::floor(a[0]); }},
    {"keys", "keys(t, t0, v0, t1, v1, …)", 3, many, keys},
    {"log", "log(x)", 1, 1, [](Arguments a) { return std::log(a[0]); }},
    {"max", "max(x, y)", 2, 2, [](Arguments a) { return std::max(a[0], a[1]); }},
    {"min", "min(x, y)", 2, 2, [](Arguments a) { return std::min(a[0], a[1]); }},
    {"mix", "mix(a, b, x)", 3, 3, [](Arguments a) { return a[0] + (a[1] - a[0]) * a[2]; }},
    {"mod", "mod(x, y)", 2, 2, [](Arguments a) { return a[0] - a[1] * std::floor(a[0] / a[1]); }},
    {"random", "random(n, stream)", 1, 2, [](Arguments a) { return random(a[0], a.size() > 1 ? a[1] : 0); }},
    {"sin", "sin(x)", 1, 1, [](Arguments a) { return std::sin(a[0]); }},
    {"smoothstep", "smoothstep(low, high, x)", 3, 3, [](Arguments a) { return smoothstep(a[0], a[1], a[2]); }},
    {"sqrt", "sqrt(x)", 1, 1, [](Arguments a) { return std::sqrt(a[0]); }},
    {"step", "step(edge, x)", 2, 2, [](Arguments a) { return a[1] < a[0] ? 0.0 : 1.0; }},
    {"tan", "tan(x)", 1, 1, [](Arguments a) { return std::tan(a[0]); }},
};

const Function* find_function(std::string_view name) {
    for (const Function& f : functions)
        if (f.name == name) return &f;
    return nullptr;
}

// Characters by hand: <cctype> depends on the locale.
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

// Recursive descent that computes as it reads:
//   sum = product { ("+" | "-") product }; product = signed { ("*" | "/") signed };
//   signed = [ "+" | "-" ] signed | power; power = atom [ "^" signed ]; atom = number | name | call | "(" sum ")"
class Evaluator {
  public:
    Evaluator(std::string_view text, const Variables& variables) : text_(text), variables_(variables) {}

    std::variant<double, ExpressionFault> run() {
        const double value = sum(0);
        if (!fault_ && at_ < text_.size()) fail(at_, fmt::format("expected an operator or the end, found {}", found()));
        if (!fault_ && !std::isfinite(value)) fail(0, "the value is not a finite number");
        if (fault_) return *fault_;
        return value;
    }

  private:
    void fail(std::size_t at, std::string message) {
        if (!fault_) fault_ = {at, std::move(message)};
    }
    void skip() {
        while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    }
    char peek() {
        skip();
        return at_ < text_.size() ? text_[at_] : '\0';
    }
    bool take(char c) {
        if (fault_ || peek() != c) return false;
        ++at_;
        return true;
    }
    std::string found() const {
        return at_ < text_.size() ? fmt::format("'{}'", text_.substr(at_, 12)) : std::string("the end");
    }

    double sum(int depth) {
        double value = product(depth);
        while (true) {
            if (take('+')) value += product(depth);
            else if (take('-')) value -= product(depth);
            else return value;
        }
    }
    double product(int depth) {
        double value = signed_power(depth);
        while (true) {
            if (take('*')) value *= signed_power(depth);
            else if (take('/')) value /= signed_power(depth);
            else return value;
        }
    }
    double signed_power(int depth) {
        if (depth >= max_depth) {
            fail(at_, fmt::format("nested deeper than {}", max_depth));
            return 0;
        }
        if (take('-')) return -signed_power(depth + 1);
        if (take('+')) return signed_power(depth + 1);
        const double base = atom(depth + 1);
        return take('^') ? std::pow(base, signed_power(depth + 1)) : base;
    }
    double atom(int depth) {
        if (fault_) return 0;
        if (take('(')) {
            const double value = sum(depth);
            if (!take(')')) fail(at_, fmt::format("expected ')', found {}", found()));
            return value;
        }
        const char c = peek();
        if (is_digit(c) || c == '.') {
            double value = 0;
            const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
            if (error != std::errc()) fail(at_, fmt::format("expected a number, found {}", found()));
            else at_ = std::size_t(end - text_.data());
            return value;
        }
        if (is_letter(c)) return name(depth);
        fail(at_, fmt::format("expected a number, a name or '(', found {}", found()));
        return 0;
    }
    double name(int depth) {
        const std::size_t start = at_;
        while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
        const std::string_view name = text_.substr(start, at_ - start);
        if (const Function* function = find_function(name)) return call(*function, start, depth);
        if (name == "pi") return M_PI;
        if (const auto variable = variables_.find(name); variable != variables_.end()) return variable->second;
        std::string known = "pi";
        for (const auto& [other, value] : variables_) known += ", " + other;
        fail(start,
             fmt::format("unknown name '{}'; there are {}, and the functions {}", name, known, expression_functions()));
        return 0;
    }
    double call(const Function& function, std::size_t start, int depth) {
        if (!take('(')) {
            fail(at_, fmt::format("expected '(' after {}, found {}", function.name, found()));
            return 0;
        }
        std::vector<double> arguments;
        do arguments.push_back(sum(depth));
        while (!fault_ && arguments.size() < many && take(','));
        if (!fault_ && !take(')')) fail(at_, fmt::format("expected ',' or ')', found {}", found()));
        if (fault_) return 0;
        const bool paired = function.most != many || arguments.size() % 2 == 1;
        if (arguments.size() < function.least || arguments.size() > function.most || !paired) {
            fail(start, fmt::format("{} takes other arguments: {}", function.name, function.usage));
            return 0;
        }
        return function.call(arguments);
    }

    std::string_view text_;
    const Variables& variables_;
    std::size_t at_ = 0;
    std::optional<ExpressionFault> fault_;
};

}  // namespace

std::variant<double, ExpressionFault> evaluate_expression(std::string_view text, const Variables& variables) {
    return Evaluator(text, variables).run();
}

std::string expression_functions() {
    std::string list;
    for (const Function& f : functions) list += (list.empty() ? "" : ", ") + std::string(f.usage);
    return list;
}

bool is_variable_name(std::string_view name) {
    if (name.empty() || !is_letter(name[0]) || name == "pi" || find_function(name)) return false;
    return std::all_of(name.begin(), name.end(), [](char c) { return is_letter(c) || is_digit(c); });
}

}  // namespace spinel
