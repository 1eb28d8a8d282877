// Objects of the scene file: a geometry at its place, with its materials.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/json_context.h"
#include "scene/merge.h"
#include "scene/validate.h"

namespace spinel {
namespace {

// One step of a transform list, in double precision so that right angles stay right.
glm::dmat4 read_step(JsonContext& context, const JsonValue& value, const std::string& where) {
    const glm::dmat4 identity(1);
    if (!value.object() || value.object()->size() != 1) {
        context.json.fail(value, where +
                                     " must be a list of objects with one key each: scale, rotate or translate, not " +
                                     value.description());
        return identity;
    }
    const JsonMember& step = value.object()->front();
    if (step.key == "scale") {
        const auto scale = context.json.color(step.value, any, "\"scale\" of " + where);
        return scale ? glm::scale(identity, glm::dvec3(*scale)) : identity;
    }
    if (step.key == "translate") {
        const auto offset = context.json.triple(step.value, any, "\"translate\" of " + where);
        return offset ? glm::translate(identity, glm::dvec3(*offset)) : identity;
    }
    if (step.key != "rotate") {
        context.json.fail(step.offset,
                          "unknown step \"" + step.key + "\" in " + where + "; allowed: scale, rotate, translate");
        return identity;
    }
    const std::string what = "\"rotate\" of " + where;
    struct Rotation {
        vec3 axis = {0, 1, 0};
        float degrees = 0;
    } rotation;
    static const Record record{"",
                               "",
                               {required(field("axis", &Rotation::axis, "Axis, of any length.")),
                                required(field("degrees", &Rotation::degrees, "Counter-clockwise around the axis."))},
                               nullptr};
    context.json.record(value.object()->front().value, record, &rotation, what);
    if (!(glm::length(rotation.axis) > 0)) {
        context.json.fail(step.value, what + " has an axis of length 0");
        return identity;
    }
    return glm::rotate(identity, glm::radians(double(rotation.degrees)), glm::dvec3(rotation.axis));
}

// One row after the other: 3×4, or 4×4 with 0 0 0 1 at the end.
mat4x3 read_matrix(JsonContext& context, const JsonValue& value, const std::string& where) {
    const std::size_t count = value.array()->size();
    float m[16] = {};
    if (count != 12 && count != 16)
        context.json.fail(
            value, where + " must be a list of steps or a matrix of 12 or 16 numbers, not " + value.description());
    else if (context.json.numbers(value, count, any, where, m) && count == 16 &&
             !(m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1))
        context.json.fail(value, where + ": the last row of a 4×4 matrix must be 0, 0, 0, 1");
    return mat4x3(m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10], m[3], m[7], m[11]);
}

std::vector<int> read_material_slots(JsonContext& context, const JsonValue& value, const std::string& what) {
    const std::string where = "\"material\" of " + what;
    const auto one = [&](const JsonValue& v) {
        return v.is_null() ? -1 : context.json.reference(v, context.materials, where);
    };
    if (!value.array()) return {one(value)};
    std::vector<int> slots;
    for (const JsonValue& element : *value.array()) slots.push_back(one(element));
    if (slots.empty()) context.json.fail(value, where + " is an empty list");
    return slots;
}

void read_object(JsonContext& context, const JsonValue& value, std::size_t index) {
    std::string name, what = "objects[" + std::to_string(index) + "]";
    if (const JsonValue* given = value.find("name")) {
        name = context.json.text(*given, "\"name\" of " + what).value_or("");
        if (!name.empty()) what = named("object", name);
    }
    if (!context.json.record(value, object_record(), nullptr, what)) return;

    const JsonValue* geometry = value.find("geometry");
    if (!geometry) return;  // said already: it is required
    GeometryParts parts;
    if (geometry->object()) {
        parts = read_geometry(context, *geometry, name.empty() ? what : name);
    } else {
        const int found = context.json.reference(*geometry, context.geometries, "\"geometry\" of " + what);
        if (found < 0) return;
        parts = context.geometry_parts[std::size_t(found)];
        if (name.empty()) name = *geometry->text();
    }

    mat4x3 transform(1);
    const JsonValue* placed = value.find("transform");
    if (placed) transform = read_transform(context, *placed, what);
    const JsonValue* material = value.find("material");
    std::vector<int> materials;
    if (material) materials = read_material_slots(context, *material, what);
    const JsonValue* interior = value.find("interior");
    const int medium = interior ? context.json.reference(*interior, context.media, "\"interior\" of " + what) : -1;

    for (Object& part : parts.objects) {
        if (context.json.error()) return;
        const Geometry& shape = context.scene.geometries[std::size_t(part.geometry)];
        const auto* grid = std::get_if<VolumeGeometry>(&shape.data);
        const bool volume = grid && !grid->surface;
        if (!material && part.materials.empty() && !volume)
            context.json.fail(value, what +
                                         " needs \"material\": a name, null (an interface that does not scatter), or "
                                         "a list of these, one for each slot");
        if (material) part.materials = materials;
        if (interior) part.interior = medium;
        part.transform = compose(transform, part.transform);
        part.name = parts.objects.size() == 1 || part.name.empty() ? name : name + "/" + part.name;
        const bool closed = !std::holds_alternative<PlaneGeometry>(shape.data) &&
                            !std::holds_alternative<RectangleGeometry>(shape.data);
        if (interior && !closed)
            context.json.fail(*interior, what + " is a " + std::string(kind_name(shape)) +
                                             ", which has no inside for an interior medium");
        if (volume && part.interior < 0)
            context.json.fail(value, what + " is a volume and needs \"interior\", the medium that it holds");
        const std::uint32_t slots = slot_count(shape);
        if (material && part.materials.size() > 1 && part.materials.size() < slots)
            context.json.fail(*material, "\"material\" of " + what + " lists " + std::to_string(part.materials.size()) +
                                             " materials, but its geometry uses " + std::to_string(slots) + " slots");
        context.scene.objects.push_back(std::move(part));
    }
}

}  // namespace

mat4x3 read_transform(JsonContext& context, const JsonValue& value, const std::string& what) {
    const std::string where = "\"transform\" of " + what;
    const JsonValue::Array* array = value.array();
    if (!array) {
        context.json.fail(
            value, where + " must be a list of steps or a matrix of 12 or 16 numbers, not " + value.description());
        return mat4x3(1);
    }
    mat4x3 transform(1);
    if (!array->empty() && array->front().number()) {
        transform = read_matrix(context, value, where);
    } else {
        glm::dmat4 product(1);
        for (const JsonValue& step : *array) product = read_step(context, step, where) * product;
        transform = mat4x3(product);
    }
    if (!context.json.error())
        if (const auto f = transform_fault(transform)) context.json.fail(value, what + " " + *f);
    return transform;
}

void read_objects(JsonContext& context, const JsonValue& value) {
    context.json.elements(value, "\"objects\"",
                          [&](const JsonValue& element, std::size_t index) { read_object(context, element, index); });
}

}  // namespace spinel
