#pragma once
// The scene file, described once: for every record the rows of what may stand in it: name, member, range,
// unit, one sentence. The JSON reader and writer, the messages, the JSON Schema and the reference page all
// come from these tables. A new field is one row: in scene_fields.cpp of what is in a scene, in settings_fields.cpp of
// how a picture is made of it. Materials have their own table, from which material_record() makes rows.

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "spinel/scene.h"

namespace spinel {

struct Range {
    double lower = -std::numeric_limits<double>::infinity();
    double upper = std::numeric_limits<double>::infinity();
    bool open = false;  // the bounds themselves are not allowed
    bool contains(double x) const { return open ? x > lower && x < upper : x >= lower && x <= upper; }
};
inline constexpr Range any{};
inline constexpr Range positive{0, std::numeric_limits<double>::infinity(), true};
inline constexpr Range non_negative{0, std::numeric_limits<double>::infinity()};
inline constexpr Range unit_interval{0, 1};

enum class FieldKind {
    boolean,  // bool
    flag,     // kernels::uint, 0 or 1; true or false in the file
    integer,  // int
    number,   // float
    text,     // std::string
    choice,   // an enum: value i has the name choices[i]
    vec2,
    vec3,
    color,    // vec3; one number stands for three
    size2,    // ivec2
    size3,    // ivec3
    by_hand,  // read by code of its own; `shape` names its definition in the schema
};

struct Field {
    std::string_view name;
    FieldKind kind = FieldKind::by_hand;
    std::size_t offset = 0;  // of the member within its record
    std::string_view doc = {};
    Range range = {};  // of every component
    std::string_view unit = {};
    bool required = false;
    std::span<const std::string_view> choices = {};
    std::string_view shape = {};
    std::optional<std::size_t> texture = {};  // offset of the index (uint) of a texture that may multiply it
};

// What one "type" of a family holds, or a record that has no types.
struct Record {
    std::string_view type;
    std::string_view doc = {};
    std::vector<Field> fields;
    const void* defaults = nullptr;  // an instance in its initial state; null when all rows are read by hand
    const Field* find(std::string_view name) const;
};

// Records told apart by their "type". Where they are the alternatives of a variant they stand in its order.
struct Family {
    std::string_view noun;
    std::vector<Record> records;
    std::string_view default_type;  // empty: "type" must be given
};

const Record& film_record();
const Record& integrator_record();
const Record& accelerator_record();
const Record& march_record();
const Record& dvr_record();
const Record& transfer_point_record();
const Record& expected_record();
const Record& medium_record();
const Record& erosion_record();
const Record& outlines_record();
const Record& waves_record();
const Record& object_record();
const Record& animation_record();
const Record& scene_record();
const Family& camera_family();       // in the order of Camera::Kind
const Family& environment_family();  // of EnvironmentData without its monostate
const Family& texture_family();
const Family& geometry_family();
const Family& light_family();

// Words for Filter and GridPrecision of volumes.
inline constexpr std::string_view volume_filters[] = {"nearest", "linear", "cubic"};
inline constexpr std::string_view volume_looks[] = {"fog", "surface"};
inline constexpr std::string_view solid_sides[] = {"below", "above"};
inline constexpr std::string_view grid_precisions[] = {"full", "half", "16 bits", "8 bits"};

// ---------------------------------------------------------------------------------------------- how rows are
// made
template <class E>
struct ChoiceNames;  // specialised where an enum is used in a row: static constexpr std::string_view names[]

template <class Owner, class Member>
std::size_t member_offset(Member Owner::*member) {
    static const Owner instance{};
    return std::size_t(reinterpret_cast<const char*>(&(instance.*member)) - reinterpret_cast<const char*>(&instance));
}

template <class Owner, class Member>
Field field(std::string_view name, Member Owner::*member, std::string_view doc, Range range = any,
            std::string_view unit = {}) {
    Field row{.name = name, .offset = member_offset(member), .doc = doc, .range = range, .unit = unit};
    if constexpr (std::is_same_v<Member, bool>) row.kind = FieldKind::boolean;
    else if constexpr (std::is_same_v<Member, int>) row.kind = FieldKind::integer;
    else if constexpr (std::is_same_v<Member, float>) row.kind = FieldKind::number;
    else if constexpr (std::is_same_v<Member, std::string>) row.kind = FieldKind::text;
    else if constexpr (std::is_same_v<Member, vec2>) row.kind = FieldKind::vec2;
    else if constexpr (std::is_same_v<Member, vec3>) row.kind = FieldKind::vec3;
    else if constexpr (std::is_same_v<Member, ivec2>) row.kind = FieldKind::size2;
    else if constexpr (std::is_same_v<Member, ivec3>) row.kind = FieldKind::size3;
    else {
        static_assert(std::is_enum_v<Member> && sizeof(Member) == sizeof(int));
        row.kind = FieldKind::choice;
        row.choices = ChoiceNames<Member>::names;
    }
    return row;
}

template <class Owner>
Field color(std::string_view name, vec3 Owner::*member, std::string_view doc, Range range = non_negative,
            std::string_view unit = {}) {
    Field row = field(name, member, doc, range, unit);
    row.kind = FieldKind::color;
    return row;
}

inline Field by_hand(std::string_view name, std::string_view shape, std::string_view doc) {
    return {.name = name, .doc = doc, .shape = shape};
}

inline Field required(Field row) {
    row.required = true;
    return row;
}

template <class T>
Record record(std::string_view type, std::string_view doc, std::vector<Field> fields) {
    static const T defaults{};
    return {type, doc, std::move(fields), &defaults};
}

inline Record record_by_hand(std::string_view type, std::string_view doc, std::vector<Field> fields) {
    return {type, doc, std::move(fields), nullptr};
}

}  // namespace spinel
