#pragma once
// A JSON text as a tree whose every value and key knows where it stands, so that whoever reads it can point
// at what is wrong: `scene.json:12:7: unknown key "roughnes" …`. Comments (// and /* */) are allowed; a key
// twice in one object, a number beyond a double, more than 512 levels or more than 64 MiB of text are errors.

#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/result.h"

namespace spinel {

struct JsonMember;

struct JsonValue {
    using Array = std::vector<JsonValue>;
    using Object = std::vector<JsonMember>;  // in the order of the text

    std::variant<std::nullptr_t, bool, double, std::string, Array, Object> data;
    std::size_t offset = 0;  // of its first byte in the text

    bool is_null() const { return std::holds_alternative<std::nullptr_t>(data); }
    const bool* boolean() const { return std::get_if<bool>(&data); }
    const double* number() const { return std::get_if<double>(&data); }
    const std::string* text() const { return std::get_if<std::string>(&data); }
    const Array* array() const { return std::get_if<Array>(&data); }
    const Object* object() const { return std::get_if<Object>(&data); }

    // The value of a key; null if this is no object or has no such key.
    const JsonValue* find(std::string_view key) const;
    // "a number", "an array of 3": what a message says was found.
    std::string description() const;
};

struct JsonMember {
    std::string key;
    std::size_t offset = 0;  // of the key's opening quote
    JsonValue value;
};

struct JsonDocument {
    std::string file;  // as messages name it
    std::string text;
    JsonValue root;

    // "file:line:column: message"; lines and columns count from 1, columns in characters (UTF-8 code points).
    Error error(std::size_t offset, std::string_view message) const;
};

// `file` only names the text in messages.
Result<JsonDocument> parse_json(std::string text, std::string file);

}  // namespace spinel
