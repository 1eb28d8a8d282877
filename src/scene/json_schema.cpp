#include "scene/json_schema.h"

#include <cmath>

#include "geometry/sdf/sdf_ops.h"
#include "scene/json_values.h"
#include "scene/material_fields.h"
#include "scene/material_registry.h"
#include "scene/number_text.h"
#include "scene/scene_fields.h"

namespace spinel {
namespace {

OrderedJson reference_to(std::string_view definition) { return {{"$ref", "#/definitions/" + std::string(definition)}}; }

OrderedJson bounded(std::string_view type, const Range& range) {
    OrderedJson schema = {{"type", type}};
    if (std::isfinite(range.lower))
        schema[range.open ? "exclusiveMinimum" : "minimum"] = json_number(float(range.lower));
    if (std::isfinite(range.upper))
        schema[range.open ? "exclusiveMaximum" : "maximum"] = json_number(float(range.upper));
    return schema;
}

OrderedJson array_of(OrderedJson items, int count = 0) {
    OrderedJson schema = {{"type", "array"}, {"items", std::move(items)}};
    if (count) schema["minItems"] = schema["maxItems"] = count;
    return schema;
}

OrderedJson name() { return {{"type", "string"}, {"minLength", 1}}; }

OrderedJson closed_object(OrderedJson properties, std::vector<std::string> required) {
    return {{"type", "object"},
            {"properties", std::move(properties)},
            {"required", std::move(required)},
            {"additionalProperties", false}};
}

OrderedJson field_schema(const Field& field, const void* defaults) {
    OrderedJson schema;
    switch (field.kind) {
        case FieldKind::boolean:
        case FieldKind::flag: schema = {{"type", "boolean"}}; break;
        case FieldKind::integer: schema = bounded("integer", field.range); break;
        case FieldKind::number: schema = bounded("number", field.range); break;
        case FieldKind::text: schema = name(); break;
        case FieldKind::choice:
            schema = {{"enum", std::vector<std::string>(field.choices.begin(), field.choices.end())}};
            break;
        case FieldKind::vec2: schema = array_of(bounded("number", field.range), 2); break;
        case FieldKind::vec3: schema = array_of(bounded("number", field.range), 3); break;
        case FieldKind::color: {
            const OrderedJson number = bounded("number", field.range);
            schema["anyOf"] = OrderedJson::array({number, array_of(number, 3)});
            break;
        }
        case FieldKind::size2: schema = array_of(bounded("integer", field.range), 2); break;
        case FieldKind::size3: schema = array_of(bounded("integer", field.range), 3); break;
        case FieldKind::by_hand:
            return {{"allOf", OrderedJson::array({reference_to(field.shape)})}, {"description", field.doc}};
    }
    if (field.texture) {
        const OrderedJson factor = schema;
        if (!schema.contains("anyOf")) schema = {{"anyOf", OrderedJson::array({factor})}};
        schema["anyOf"].push_back(name());
        schema["anyOf"].push_back(closed_object({{"texture", name()}, {"factor", factor}}, {"texture"}));
    }
    schema["description"] =
        std::string(field.doc) + (field.unit.empty() ? "" : " Unit: " + std::string(field.unit) + ".");
    if (defaults && !field.required) schema["default"] = json_value(field, defaults);
    return schema;
}

OrderedJson record_schema(const Record& record, bool type_required) {
    OrderedJson schema = {{"type", "object"}, {"description", record.doc}};
    OrderedJson properties = OrderedJson::object(), required = OrderedJson::array();
    if (!record.type.empty()) {
        properties["type"] = {{"const", record.type}};
        if (type_required) required.push_back("type");
    }
    for (const Field& field : record.fields) {
        properties[std::string(field.name)] = field_schema(field, record.defaults);
        if (field.required) required.push_back(field.name);
    }
    schema["properties"] = std::move(properties);
    if (!required.empty()) schema["required"] = std::move(required);
    schema["additionalProperties"] = false;
    return schema;
}

OrderedJson family_schema(const Family& family) {
    OrderedJson alternatives = OrderedJson::array();
    for (const Record& record : family.records)
        alternatives.push_back(record_schema(record, record.type != family.default_type));
    return {{"oneOf", std::move(alternatives)}};
}

OrderedJson by_name(std::string_view definition) {
    return {
        {"type", "object"}, {"propertyNames", {{"minLength", 1}}}, {"additionalProperties", reference_to(definition)}};
}

OrderedJson transform_schema() {
    const OrderedJson number = {{"type", "number"}}, triple = array_of(number, 3);
    const OrderedJson factor = {{"anyOf", OrderedJson::array({number, triple})}};
    const OrderedJson rotation = closed_object({{"axis", triple}, {"degrees", number}}, {"axis", "degrees"});
    const OrderedJson step = {{"oneOf", OrderedJson::array({closed_object({{"scale", factor}}, {"scale"}),
                                                            closed_object({{"rotate", rotation}}, {"rotate"}),
                                                            closed_object({{"translate", triple}}, {"translate"})})}};
    return {{"anyOf", OrderedJson::array({array_of(step), array_of(number, 12), array_of(number, 16)})}};
}

OrderedJson sdf_node_schema() {
    OrderedJson alternatives = OrderedJson::array();
    for (const SdfOperation& operation : sdf_operations()) {
        OrderedJson properties = {{"op", {{"const", operation.name}}}};
        std::vector<std::string> required = {"op"};
        for (const SdfParameter& parameter : operation.parameters) {
            OrderedJson schema = bounded("number", {parameter.minimum, parameter.maximum});
            schema["description"] = parameter.doc;
            if (parameter.fallback) schema["default"] = json_number(*parameter.fallback);
            else required.emplace_back(parameter.name);
            properties[std::string(parameter.name)] = std::move(schema);
        }
        if (operation.child_maximum > 0) {
            OrderedJson args = array_of(reference_to("sdf_node"));
            args["minItems"] = operation.child_minimum;
            if (operation.child_maximum != SDF_ANY_COUNT) args["maxItems"] = operation.child_maximum;
            properties["args"] = std::move(args);
            if (operation.child_minimum > 0) required.push_back("args");
        }
        alternatives.push_back(closed_object(std::move(properties), std::move(required)));
        alternatives.back()["description"] = operation.doc;
    }
    return {{"oneOf", std::move(alternatives)}};
}

// The values that are read by hand, by the names that rows give as their shape.
OrderedJson definitions() {
    const OrderedJson number = {{"type", "number"}}, index = {{"type", "integer"}, {"minimum", 0}};
    const OrderedJson slot = {{"anyOf", OrderedJson::array({name(), {{"type", "null"}}})}};
    OrderedJson slots = array_of(slot);
    slots["minItems"] = 1;
    OrderedJson d;
    d["version"] = {{"const", 1}};
    d["text"] = d["path"] = d["reference"] = name();
    std::vector<std::string_view> presets;
    for (const MaterialInfo& info : material_infos())
        for (const MaterialPreset& preset : info.presets) presets.push_back(preset.name);
    d["preset"] = {{"enum", presets}};
    d["number_list"] = array_of(bounded("number", any));
    d["vec2_list"] = array_of(array_of(number, 2));
    d["vec3_list"] = array_of(array_of(number, 3));
    d["vec4_list"] = array_of(array_of(number, 4));
    d["index_list"] = array_of(index);
    d["index3_list"] = array_of(array_of(index, 3));
    d["frame"] = bounded("integer", {0, 1 << 20});
    d["voxel_height"] = bounded("number", {1, 65536});
    d["pixels"] = bounded("number", {0, 1024});
    d["level"] = bounded("number", any);
    d["size3"] = array_of(bounded("integer", {1, 65536}), 3);
    d["layers"] = array_of(array_of({{"type", "string"}, {"pattern", "^[. 1-9a-z]+$"}}));
    d["filter"] = {{"enum", volume_filters}};
    d["volume_look"] = {{"enum", volume_looks}};
    d["solid_side"] = {{"enum", solid_sides}};
    d["precision"] = {{"enum", grid_precisions}};
    d["bounds"] = array_of(array_of(number, 3), 2);
    d["sdf_node"] = sdf_node_schema();
    d["sdf"] = {{"anyOf", OrderedJson::array({name(), reference_to("sdf_node")})}};
    d["transform"] = transform_schema();
    d["material_slots"] = {{"anyOf", OrderedJson::array({name(), {{"type", "null"}}, slots})}};
    d["camera"] = family_schema(camera_family());
    d["film"] = record_schema(film_record(), false);
    d["integrator"] = record_schema(integrator_record(), false);
    d["accelerator"] = record_schema(accelerator_record(), false);
    d["march"] = record_schema(march_record(), false);
    d["dvr"] = record_schema(dvr_record(), false);
    d["transfer_point"] = record_schema(transfer_point_record(), false);
    d["transfer_points"] = array_of(reference_to("transfer_point"));
    d["clip_planes"] = array_of(array_of(number, 4));
    d["rate"] = {{"type", "number"}, {"exclusiveMinimum", 0}, {"maximum", 1e6}};
    d["formula"] = {{"type", {"number", "string"}}};
    d["formulas"] = {{"type", "object"}, {"additionalProperties", reference_to("formula")}};
    d["formula_value"] = {
        {"anyOf", OrderedJson::array({reference_to("formula"), array_of(reference_to("formula_value"))})}};
    d["formula_values"] = {{"type", "object"},
                           {"propertyNames", {{"pattern", "^/"}}},
                           {"additionalProperties", reference_to("formula_value")}};
    d["animation"] = record_schema(animation_record(), false);
    d["environment"] = family_schema(environment_family());
    d["texture"] = family_schema(texture_family());
    d["material"] = family_schema(material_family());
    d["medium"] = record_schema(medium_record(), false);
    d["erosion"] = record_schema(erosion_record(), false);
    d["tile"] = {{"anyOf", OrderedJson::array({index, array_of(index, 4)})}};
    d["tile_grid"] = array_of(bounded("integer", {1, 65536}), 2);
    const OrderedJson radius = bounded("number", {0, 0.5});
    d["rounding"] = {{"anyOf", OrderedJson::array({radius, array_of(radius)})}};
    d["heights"] = array_of(number);
    OrderedJson palette_list = array_of(bounded("integer", {1, 65535}));
    palette_list["minItems"] = 1;
    d["palette_list"] = std::move(palette_list);
    d["outlines"] = record_schema(outlines_record(), false);
    d["waves"] = record_schema(waves_record(), false);
    d["geometry"] = family_schema(geometry_family());
    d["geometry_reference"] = {{"anyOf", OrderedJson::array({name(), reference_to("geometry")})}};
    d["object"] = record_schema(object_record(), false);
    d["light"] = family_schema(light_family());
    d["expected"] = record_schema(expected_record(), false);
    d["cameras"] = by_name("camera");
    d["textures"] = by_name("texture");
    d["materials"] = by_name("material");
    d["media"] = by_name("medium");
    d["geometries"] = by_name("geometry");
    d["objects"] = array_of(reference_to("object"));
    d["lights"] = array_of(reference_to("light"));
    return d;
}

// ------------------------------------------------------------------------------------------------ the
// reference page
std::string type_text(const Field& field) {
    std::string text;
    switch (field.kind) {
        case FieldKind::boolean:
        case FieldKind::flag: text = "true or false"; break;
        case FieldKind::integer: text = "whole number"; break;
        case FieldKind::number: text = "number"; break;
        case FieldKind::text: text = "text"; break;
        case FieldKind::choice:
            for (const std::string_view choice : field.choices)
                text += (text.empty() ? "`" : ", `") + std::string(choice) + "`";
            break;
        case FieldKind::vec2: text = "[x, y]"; break;
        case FieldKind::vec3: text = "[x, y, z]"; break;
        case FieldKind::color: text = "number or [r, g, b]"; break;
        case FieldKind::size2: text = "[width, height]"; break;
        case FieldKind::size3: text = "[x, y, z], whole"; break;
        case FieldKind::by_hand: {
            static const std::pair<std::string_view, std::string_view> words[] = {
                {"version", "1"},
                {"text", "text"},
                {"cameras", "[cameras](#camera) by name"},
                {"path", "path"},
                {"reference", "name"},
                {"preset", "name of a preset"},
                {"number_list", "list of numbers"},
                {"vec2_list", "list of [u, v]"},
                {"vec3_list", "list of [x, y, z]"},
                {"vec4_list", "list of [x, y, z, w]"},
                {"index_list", "list of whole numbers"},
                {"index3_list", "list of [a, b, c]"},
                {"frame", "whole number"},
                {"voxel_height", "number"},
                {"pixels", "number"},
                {"level", "number"},
                {"size3", "[x, y, z], whole"},
                {"layers", "list of lists of text"},
                {"tile", "number or [x, y, width, height]"},
                {"tile_grid", "[columns, rows]"},
                {"rounding", "number or list"},
                {"heights", "list of numbers"},
                {"palette_list", "list of whole numbers"},
                {"transfer_points", "list of [points](#transfer_point)"},
                {"clip_planes", "list of [x, y, z, w]"},
                {"rate", "number"},
                {"formulas", "formulas by name"},
                {"formula_values", "formulas by place"},
                {"filter", "`nearest`, `linear`, `cubic`"},
                {"volume_look", "`fog`, `surface`"},
                {"solid_side", "`below`, `above`"},
                {"precision", "`full`, `half`, `16 bits`, `8 bits`"},
                {"bounds", "two corners"},
                {"sdf", "text or tree"},
                {"transform", "list"},
                {"material_slots", "name, null or list"},
                {"geometry_reference", "name or geometry"},
            };
            for (const auto& [shape, word] : words)
                if (shape == field.shape) return std::string(word);
            return "see [" + std::string(field.shape) + "](#" + std::string(field.shape) + ")";
        }
    }
    return field.texture ? text + ", or a texture" : text;
}

std::string row_text(const Field& field, const void* defaults) {
    std::string range, preset;
    if (field.kind != FieldKind::by_hand) {
        range = range_text(field.range) == "any" ? "" : range_text(field.range);
        if (defaults && !field.required) preset = json_value(field, defaults).dump();
    }
    if (field.required) preset = "required";
    return "| `" + std::string(field.name) + "` | " + type_text(field) + " | " + std::string(field.unit) + " | " +
           range + " | " + preset + " | " + std::string(field.doc) + " |\n";
}

std::string table(const Record& record) {
    if (record.fields.empty()) return "No keys.\n\n";
    std::string text = "| Key | Value | Unit | Range | Default | |\n|---|---|---|---|---|---|\n";
    for (const Field& field : record.fields) text += row_text(field, record.defaults);
    return text + "\n";
}

std::string section(std::string_view title, const Record& record) {
    return "### " + std::string(title) + "\n\n" + std::string(record.doc) + "\n\n" + table(record);
}

std::string heading(const Record& record, const Family& family) {
    const bool implied = record.type == family.default_type;
    return "#### `\"type\": \"" + std::string(record.type) + "\"`" + (implied ? " (the default)" : "") + "\n\n" +
           std::string(record.doc) + "\n\n";
}

std::string section(std::string_view title, const Family& family) {
    std::string text = "### " + std::string(title) + "\n\n";
    for (const Record& record : family.records) text += heading(record, family) + table(record);
    return text;
}

// What all materials have in common stands in a table of its own.
std::string material_section() {
    const Family& family = material_family();
    std::string text = "### materials\n\n";
    Record common{"", "", {}, family.records.front().defaults};
    for (const Field& field : family.records.front().fields)
        if (is_common_material_field(field.name)) common.fields.push_back(field);
    for (Record record : family.records) {
        std::erase_if(record.fields, [](const Field& field) { return is_common_material_field(field.name); });
        text += heading(record, family) + table(record);
    }
    return text + "#### Every material\n\n" + table(common);
}

std::string preset_section() {
    std::string text = "#### Presets\n\n";
    for (const MaterialInfo& info : material_infos()) {
        if (info.presets.empty()) continue;
        text += "Of `" + std::string(info.name) + "`: ";
        for (const MaterialPreset& preset : info.presets)
            text += (&preset == info.presets.data() ? "`" : ", `") + std::string(preset.name) + "`";
        text += ".\n\n";
    }
    return text;
}

std::string sdf_section() {
    std::string text =
        "### SDF operations\n\nAs text, parameters come first, then children: the examples. As a tree, `op` "
        "names the "
        "operation, parameters are keys, `args` lists the children.\n\n"
        "| `op` | Parameters | Children | | Example |\n|---|---|---|---|---|\n";
    for (const SdfOperation& operation : sdf_operations()) {
        std::string parameters, children = std::to_string(operation.child_minimum);
        for (const SdfParameter& parameter : operation.parameters) {
            parameters += (parameters.empty() ? "`" : ", `") + std::string(parameter.name) + "`";
            if (parameter.fallback) parameters += " = " + number_text(*parameter.fallback);
        }
        if (operation.child_maximum == SDF_ANY_COUNT) children += " or more";
        text += "| `" + std::string(operation.name) + "` | " + parameters + " | " + children + " | " +
                std::string(operation.doc) + " | `" + std::string(operation.example) + "` |\n";
    }
    return text + "\n";
}

}  // namespace

std::string scene_schema() {
    OrderedJson schema = {{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "Spinel scene"}};
    schema.update(record_schema(scene_record(), false));
    schema["not"] = {{"required", {"camera", "cameras"}}};
    schema["definitions"] = definitions();
    return schema.dump(2) + "\n";
}

std::string scene_reference() {
    return section("The file", scene_record()) + section("camera", camera_family()) + section("film", film_record()) +
           section("integrator", integrator_record()) + section("march", march_record()) +
           section("dvr", dvr_record()) + section("transfer_point", transfer_point_record()) +
           section("accelerator", accelerator_record()) + section("environment", environment_family()) +
           section("textures", texture_family()) + material_section() + preset_section() +
           section("media", medium_record()) + section("erosion", erosion_record()) +
           section("geometries", geometry_family()) + section("outlines", outlines_record()) +
           section("waves", waves_record()) + sdf_section() + section("objects", object_record()) +
           section("lights", light_family()) + section("animation", animation_record()) +
           section("expected", expected_record());
}

}  // namespace spinel
