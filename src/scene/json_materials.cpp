// Materials of the scene file.

#include "scene/json_context.h"
#include "scene/material_fields.h"
#include "scene/material_registry.h"

namespace spinel {
namespace {

// What a complex index of refraction makes pointless is an error, not silently unread.
void exclude_colours(JsonContext& context, const JsonValue& value, const std::string& what, const char* reason,
                     std::initializer_list<const char*> keys) {
    for (const JsonMember& member : *value.object())
        for (const char* key : keys)
            if (member.key == key)
                context.json.fail(member.offset, "\"" + member.key + "\" of " + what + " is not read where " + reason);
}

void read_preset(JsonContext& context, const JsonValue& preset, const MaterialInfo& info, kernels::Material& material,
                 const std::string& what) {
    const auto name = context.json.text(preset, "\"preset\" of " + what);
    if (!name) return;
    std::vector<std::string> names;
    for (const MaterialPreset& candidate : info.presets) {
        names.emplace_back(candidate.name);
        if (candidate.name != *name) continue;
        material.eta = candidate.eta;
        material.k = candidate.k;
        return;
    }
    context.json.fail(preset, "unknown preset \"" + *name + "\" of " + what + "; available: " + list_names(names));
}

void read_material(JsonContext& context, const JsonValue& value, Material& material) {
    const std::string what = named("material", material.name);
    const Record* record = context.json.select(value, material_family(), what);
    if (!record) return;
    const MaterialInfo& info = *find_material_info(record->type);
    material.values = default_material(info.kind);
    context.json.record(value, *record, &material.values, what);

    if (!info.presets.empty()) {
        if (const JsonValue* preset = value.find("preset")) {
            exclude_colours(context, value, what, "a preset is given", {"color", "edge_color", "eta", "k"});
            read_preset(context, *preset, info, material.values, what);
        } else if (value.find("eta") || value.find("k")) {
            exclude_colours(context, value, what, "\"eta\" and \"k\" are given", {"color", "edge_color"});
            if (!value.find("eta") || !value.find("k"))
                context.json.fail(value, what + " needs both \"eta\" and \"k\", or neither");
        }
    }
    if (const JsonValue* interior = value.find("interior")) {
        const int index = context.json.reference(*interior, context.media, "\"interior\" of " + what);
        if (index >= 0) material.values.interior = kernels::uint(index);
    }
    if (const JsonValue* map = value.find("normal_map")) {
        const int index = context.json.reference(*map, context.textures, "\"normal_map\" of " + what);
        if (index >= 0) material.values.normal_texture = kernels::uint(index);
    }
}

}  // namespace

void read_materials(JsonContext& context, const JsonValue& value) {
    if (!value.object()) return;  // said already, when the names were collected
    for (std::size_t i = 0; i < value.object()->size(); ++i) {
        const JsonMember& member = (*value.object())[i];
        context.scene.materials[i].name = member.key;
        read_material(context, member.value, context.scene.materials[i]);
    }
}

}  // namespace spinel
