#include "geometry/sdf/sdf_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "geometry/sdf/sdf_ops.h"

namespace spinel {
namespace {

// Characters by hand: <cctype> depends on the locale.
bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool starts_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool starts_number(char c) { return is_digit(c) || c == '-' || c == '+' || c == '.'; }

// Recursive descent. expression = name "(" [ argument { "," argument } ] ")"; argument = number | expression.
class Parser {
  public:
    Parser(std::string_view text, const std::string& where) : text_(text), where_(where) {}

    Result<SdfNode> parse() {
        SdfNode root;
        skip();
        if (auto error = parse_expression(root, 1)) return *error;
        skip();
        if (at_ != text_.size()) return error_at(at_, fmt::format("expected the end, found {}", found()));
        return root;
    }

  private:
    std::optional<Error> parse_expression(SdfNode& node, std::size_t depth) {
        std::size_t start = at_;
        if (depth > SDF_MAX_DEPTH) return error_at(start, fmt::format("nested deeper than {}", SDF_MAX_DEPTH));
        if (++count_ > SDF_MAX_NODES) return error_at(start, fmt::format("more than {} operations", SDF_MAX_NODES));
        if (!starts_name(peek())) return error_at(start, fmt::format("expected an operation, found {}", found()));
        while (starts_name(peek()) || is_digit(peek())) at_++;
        node.op = text_.substr(start, at_ - start);
        const SdfOperation* operation = find_sdf_operation(node.op);
        if (!operation) return error_at(start, unknown_sdf_operation(node.op));
        skip();
        if (peek() != '(') return error_at(at_, fmt::format("expected '(' after {}, found {}", node.op, found()));
        at_++;
        skip();
        if (peek() != ')') {
            if (auto error = parse_arguments(node, depth)) return error;
        }
        at_++;
        if (Result<std::vector<float>> numbers = complete_sdf_numbers(*operation, node.numbers); !numbers)
            return error_at(start, numbers.error().message);
        if (auto fault = sdf_child_fault(*operation, node.children.size())) return error_at(start, *fault);
        return std::nullopt;
    }

    // Up to the closing parenthesis.
    std::optional<Error> parse_arguments(SdfNode& node, std::size_t depth) {
        while (true) {
            if (starts_number(peek())) {
                if (!node.children.empty())
                    return error_at(at_, fmt::format("the numbers of {} stand before its children", node.op));
                if (auto error = parse_number(node)) return error;
            } else if (starts_name(peek())) {
                if (auto error = parse_expression(node.children.emplace_back(), depth + 1)) return error;
            } else {
                return error_at(at_, fmt::format("expected a number or an operation, found {}", found()));
            }
            skip();
            if (peek() == ')') return std::nullopt;
            if (peek() != ',') return error_at(at_, fmt::format("expected ',' or ')', found {}", found()));
            at_++;
            skip();
        }
    }

    std::optional<Error> parse_number(SdfNode& node) {
        const char* first = text_.data() + at_ + (peek() == '+' ? 1 : 0);
        const char* last = text_.data() + text_.size();
        float value = 0;
        std::from_chars_result parsed = std::from_chars(first, last, value);
        if (parsed.ec == std::errc::result_out_of_range)
            return error_at(at_, "the number is beyond the range of single precision");
        if (parsed.ec != std::errc() || !std::isfinite(value))  // from_chars also knows inf and nan
            return error_at(at_, fmt::format("expected a number, found {}", found()));
        at_ = static_cast<std::size_t>(parsed.ptr - text_.data());
        node.numbers.push_back(value);
        return std::nullopt;
    }

    void skip() {
        while (at_ < text_.size()) {
            if (text_[at_] == '#') {
                while (at_ < text_.size() && text_[at_] != '\n') at_++;
            } else if (is_space(text_[at_])) {
                at_++;
            } else {
                return;
            }
        }
    }

    // 0 at the end.
    char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

    std::string found() const {
        if (at_ >= text_.size()) return "the end";
        unsigned char c = static_cast<unsigned char>(text_[at_]);
        return c >= 32 && c < 127 ? fmt::format("'{}'", text_[at_]) : fmt::format("byte {:#04x}", c);
    }

    Error error_at(std::size_t place, std::string_view message) const {
        std::size_t line = 1;
        std::size_t column = 1;
        for (char c : text_.substr(0, place)) {
            column = c == '\n' ? 1 : column + 1;
            line += c == '\n';
        }
        return Error{fmt::format("{}{}{}:{}: {}", where_, where_.empty() ? "" : ":", line, column, message)};
    }

    std::string_view text_;
    const std::string& where_;
    std::size_t at_ = 0;
    std::size_t count_ = 0;
};

void write(const SdfNode& node, std::string& text) {
    text += node.op;
    text += '(';
    std::string_view separator = "";
    for (float number : node.numbers) {
        text += fmt::format("{}{}", separator, number);  // the shortest that reads back the same
        separator = ", ";
    }
    for (const SdfNode& child : node.children) {
        text += separator;
        write(child, text);
        separator = ", ";
    }
    text += ')';
}

}  // namespace

Result<SdfNode> parse_sdf_text(std::string_view text, const std::string& where) { return Parser(text, where).parse(); }

std::string sdf_text(const SdfNode& node) {
    std::string text;
    write(node, text);
    return text;
}

}  // namespace spinel
