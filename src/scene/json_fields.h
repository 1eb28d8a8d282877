#pragma once
// Reads JSON values into plain structs by the rows of scene_fields.h. The first error is kept and reading
// goes on, so callers need not check after every value; what was wrong keeps its default.

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "scene/json_document.h"
#include "scene/scene_fields.h"

namespace spinel {

// Comma-separated names for a message.
std::string list_names(const std::vector<std::string>& names);

// Names that may be referred to, each with the index it stands for.
struct NameTable {
    std::string noun;  // "texture"
    std::map<std::string, int, std::less<>> indices;
    std::vector<std::string> names;  // in the order of the file
    void add(const std::string& name) {
        indices.emplace(name, int(names.size()));
        names.push_back(name);
    }
};

class JsonReader {
  public:
    explicit JsonReader(const JsonDocument& document) : document_(document) {}

    void fail(const JsonValue& at, const std::string& message) { fail(at.offset, message); }
    void fail(std::size_t offset, const std::string& message);
    const std::optional<Error>& error() const { return error_; }

    const NameTable* textures = nullptr;  // those that rows with a texture may name

    // Checks keys (none unknown, none missing) and reads the rows that have a member into `target`, an
    // instance of the record's struct. `what` names the thing in messages: `material "gold"`. False if
    // `value` is no object.
    bool record(const JsonValue& value, const Record& record, void* target, const std::string& what);

    // The record of a family that "type" names, or null.
    const Record* select(const JsonValue& value, const Family& family, const std::string& what);

    void field(const JsonValue& value, const Field& field, void* target, const std::string& what);

    // `where` names the value in messages: `"roughness" of material "gold"`.
    std::optional<double> number(const JsonValue& value, const Range& range, const std::string& where);
    std::optional<int> integer(const JsonValue& value, const Range& range, const std::string& where);
    std::optional<vec3> triple(const JsonValue& value, const Range& range, const std::string& where);
    std::optional<vec3> color(const JsonValue& value, const Range& range,
                              const std::string& where);  // 1 number or 3
    std::optional<ivec3> size(const JsonValue& value, const std::string& where);
    std::optional<std::string> text(const JsonValue& value, const std::string& where);  // not empty
    std::optional<int> choice(const JsonValue& value, std::span<const std::string_view> choices,
                              const std::string& where);
    // Index of a name in the table, or −1 with an error that lists what exists.
    int reference(const JsonValue& value, const NameTable& table, const std::string& where);

    // Reads `count` numbers; true if all are there and right.
    bool numbers(const JsonValue& value, std::size_t count, const Range& range, const std::string& where, float* out);

    // Calls `element(value, where)` for each element of an array.
    void elements(const JsonValue& value, const std::string& where,
                  const std::function<void(const JsonValue&, std::size_t)>& element);

  private:
    void texture(const JsonValue& value, const Field& field, void* target, const std::string& what);

    const JsonDocument& document_;
    std::optional<Error> error_;
};

}  // namespace spinel
