#include "scene/json_fields.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "scene/number_text.h"

namespace spinel {
namespace {

std::string in_quotes(std::string_view text) { return "\"" + std::string(text) + "\""; }

std::string in(std::string_view key, const std::string& what) { return in_quotes(key) + " of " + what; }

std::vector<std::string> names_of(const Record& record, bool typed) {
    std::vector<std::string> names;
    if (typed) names.push_back("type");
    for (const Field& field : record.fields) names.emplace_back(field.name);
    return names;
}

}  // namespace

std::string list_names(const std::vector<std::string>& names) {
    constexpr std::size_t greatest_count = 40;
    std::string list;
    for (std::size_t i = 0; i < std::min(names.size(), greatest_count); ++i) list += (i ? ", " : "") + names[i];
    if (names.size() > greatest_count) list += ", … (" + std::to_string(names.size()) + " in all)";
    return list;
}

void JsonReader::fail(std::size_t offset, const std::string& message) {
    if (!error_) error_ = document_.error(offset, message);
}

bool JsonReader::record(const JsonValue& value, const Record& record, void* target, const std::string& what) {
    if (!value.object()) {
        fail(value, what + " must be an object, not " + value.description());
        return false;
    }
    const bool typed = !record.type.empty();
    for (const JsonMember& member : *value.object()) {
        if (typed && member.key == "type") continue;
        const Field* row = record.find(member.key);
        if (!row)
            fail(member.offset, "unknown key " + in_quotes(member.key) + " in " + what +
                                    (typed ? " of type " + in_quotes(record.type) : "") +
                                    "; allowed: " + list_names(names_of(record, typed)));
        else if (row->kind != FieldKind::by_hand && target) field(member.value, *row, target, what);
    }
    for (const Field& row : record.fields)
        if (row.required && !value.find(row.name)) fail(value, what + " needs " + in_quotes(row.name));
    return true;
}

const Record* JsonReader::select(const JsonValue& value, const Family& family, const std::string& what) {
    if (!value.object()) {
        fail(value, what + " must be an object, not " + value.description());
        return nullptr;
    }
    std::vector<std::string> types;
    for (const Record& record : family.records) types.emplace_back(record.type);
    std::string_view name = family.default_type;
    const JsonValue* type = value.find("type");
    if (type) {
        if (!type->text()) {
            fail(*type, in("type", what) + " must be one of " + list_names(types) + ", not " + type->description());
            return nullptr;
        }
        name = *type->text();
    } else if (name.empty()) {
        fail(value, what + " needs \"type\"; available: " + list_names(types));
        return nullptr;
    }
    for (const Record& record : family.records)
        if (record.type == name) return &record;
    fail(*type, "unknown " + std::string(family.noun) + " type " + in_quotes(name) + " in " + what +
                    "; available: " + list_names(types));
    return nullptr;
}

void JsonReader::field(const JsonValue& value, const Field& row, void* target, const std::string& what) {
    char* const member = static_cast<char*>(target) + row.offset;
    const std::string where = in(row.name, what);
    if (row.texture && (value.text() || value.object())) return texture(value, row, target, what);
    // The member's type is that of the row's kind: field() in scene_fields.h sees to it.
    const auto store = [&](const auto& result) {
        if (result) *reinterpret_cast<std::remove_cvref_t<decltype(*result)>*>(member) = *result;
    };
    switch (row.kind) {
        case FieldKind::boolean:
            if (value.boolean()) *reinterpret_cast<bool*>(member) = *value.boolean();
            else fail(value, where + " must be true or false, not " + value.description());
            break;
        case FieldKind::flag:
            if (value.boolean()) *reinterpret_cast<kernels::uint*>(member) = *value.boolean() ? 1 : 0;
            else fail(value, where + " must be true or false, not " + value.description());
            break;
        case FieldKind::integer: store(integer(value, row.range, where)); break;
        case FieldKind::number:
            if (const auto x = number(value, row.range, where)) *reinterpret_cast<float*>(member) = float(*x);
            break;
        case FieldKind::text: store(text(value, where)); break;
        case FieldKind::choice:
            if (const auto i = choice(value, row.choices, where)) std::memcpy(member, &*i, sizeof(int));
            break;
        case FieldKind::vec2: {
            vec2 pair;
            if (numbers(value, 2, row.range, where, &pair.x)) *reinterpret_cast<vec2*>(member) = pair;
            break;
        }
        case FieldKind::vec3: store(triple(value, row.range, where)); break;
        case FieldKind::color: store(color(value, row.range, where)); break;
        case FieldKind::size2: {
            vec2 pair;
            if (numbers(value, 2, row.range, where, &pair.x)) {
                if (pair == floor(pair)) *reinterpret_cast<ivec2*>(member) = ivec2(pair);
                else fail(value, where + " must be whole numbers");
            }
            break;
        }
        case FieldKind::size3: store(size(value, where)); break;
        case FieldKind::by_hand: break;
    }
}

// "name", or {"texture": "name", "factor": a value of the row's kind}; without a factor the texture counts as
// it is.
void JsonReader::texture(const JsonValue& value, const Field& row, void* target, const std::string& what) {
    const std::string where = in(row.name, what);
    char* const record = static_cast<char*>(target);
    const JsonValue* name = &value;
    const JsonValue* factor = nullptr;
    if (value.object()) {
        for (const JsonMember& member : *value.object())
            if (member.key != "texture" && member.key != "factor")
                fail(member.offset,
                     "unknown key " + in_quotes(member.key) + " in " + where + "; allowed: texture, factor");
        name = value.find("texture");
        factor = value.find("factor");
        if (!name) return fail(value, where + " needs \"texture\"");
    }
    if (factor) {
        Field number = row;
        number.texture.reset();
        field(*factor, number, target, what);
    } else if (row.kind == FieldKind::color) {
        *reinterpret_cast<vec3*>(record + row.offset) = vec3(1);
    } else {
        *reinterpret_cast<float*>(record + row.offset) = 1;
    }
    const int index = textures ? reference(*name, *textures, where) : -1;
    if (index >= 0) *reinterpret_cast<kernels::uint*>(record + *row.texture) = kernels::uint(index);
}

std::optional<double> JsonReader::number(const JsonValue& value, const Range& range, const std::string& where) {
    if (!value.number()) {
        fail(value, where + " must be a number, not " + value.description());
        return std::nullopt;
    }
    const double x = *value.number();
    if (!range.contains(x)) {
        fail(value, where + " is " + number_text(x) + "; allowed: " + range_text(range));
        return std::nullopt;
    }
    if (!std::isfinite(float(x))) {
        fail(value, where + " is " + number_text(x) + ", more than a 32-bit float holds");
        return std::nullopt;
    }
    return x;
}

std::optional<int> JsonReader::integer(const JsonValue& value, const Range& range, const std::string& where) {
    const auto x = number(value, range, where);
    if (!x) return std::nullopt;
    if (*x != std::floor(*x) || std::abs(*x) > std::numeric_limits<int>::max()) {
        fail(value, where + " is " + number_text(*x) + "; it must be a whole number of 32 bits");
        return std::nullopt;
    }
    return int(*x);
}

bool JsonReader::numbers(const JsonValue& value, std::size_t count, const Range& range, const std::string& where,
                         float* out) {
    const JsonValue::Array* array = value.array();
    if (!array || array->size() != count) {
        fail(value, where + " must be an array of " + std::to_string(count) + " numbers, not " + value.description());
        return false;
    }
    for (std::size_t i = 0; i < count; ++i) {
        const auto x = number((*array)[i], range, where);
        if (!x) return false;
        out[i] = float(*x);
    }
    return true;
}

std::optional<vec3> JsonReader::triple(const JsonValue& value, const Range& range, const std::string& where) {
    vec3 v;
    return numbers(value, 3, range, where, &v.x) ? std::optional(v) : std::nullopt;
}

std::optional<vec3> JsonReader::color(const JsonValue& value, const Range& range, const std::string& where) {
    if (value.array() && value.array()->size() == 3) return triple(value, range, where);
    if (!value.number()) {
        fail(value, where + " must be a number or an array of 3 numbers, not " + value.description());
        return std::nullopt;
    }
    const auto x = number(value, range, where);
    return x ? std::optional(vec3(float(*x))) : std::nullopt;
}

std::optional<ivec3> JsonReader::size(const JsonValue& value, const std::string& where) {
    vec3 v;
    if (!numbers(value, 3, {1, 65536}, where, &v.x)) return std::nullopt;
    if (v != floor(v)) {
        fail(value, where + " must be whole numbers");
        return std::nullopt;
    }
    return ivec3(v);
}

std::optional<std::string> JsonReader::text(const JsonValue& value, const std::string& where) {
    if (!value.text()) {
        fail(value, where + " must be a text in quotes, not " + value.description());
        return std::nullopt;
    }
    if (value.text()->empty()) {
        fail(value, where + " is empty");
        return std::nullopt;
    }
    return *value.text();
}

std::optional<int> JsonReader::choice(const JsonValue& value, std::span<const std::string_view> choices,
                                      const std::string& where) {
    if (value.text())
        for (std::size_t i = 0; i < choices.size(); ++i)
            if (choices[i] == *value.text()) return int(i);
    fail(value,
         where + " must be one of " + list_names({choices.begin(), choices.end()}) + ", not " + value.description());
    return std::nullopt;
}

int JsonReader::reference(const JsonValue& value, const NameTable& table, const std::string& where) {
    const auto name = text(value, where + " (the name of a " + table.noun + ")");
    if (!name) return -1;
    const auto found = table.indices.find(*name);
    if (found != table.indices.end()) return found->second;
    fail(value, where + ": no " + table.noun + " is named " + in_quotes(*name) +
                    (table.names.empty() ? "; the scene defines none" : "; defined: " + list_names(table.names)));
    return -1;
}

void JsonReader::elements(const JsonValue& value, const std::string& where,
                          const std::function<void(const JsonValue&, std::size_t)>& element) {
    if (!value.array()) {
        fail(value, where + " must be an array, not " + value.description());
        return;
    }
    for (std::size_t i = 0; i < value.array()->size(); ++i) element((*value.array())[i], i);
}

}  // namespace spinel
