#include "scene/material_fields.h"

#include <deque>

#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel {
namespace {

Field row_of(const MaterialParameter& parameter) {
    const Range range{parameter.minimum, parameter.maximum};
    Field row = std::visit(
        [&](auto member) {
            using Value = std::remove_cvref_t<decltype(kernels::Material{}.*member)>;
            if constexpr (std::is_same_v<Value, vec3>) {
                return color(parameter.name, member, parameter.doc, range);
            } else if constexpr (std::is_same_v<Value, kernels::uint>) {
                return Field{.name = parameter.name,
                             .kind = FieldKind::flag,
                             .offset = member_offset(member),
                             .doc = parameter.doc};
            } else {
                return field(parameter.name, member, parameter.doc, range);
            }
        },
        parameter.member);
    // The texture of normal_scale does not multiply it; it is the normal map, a row of its own.
    if (parameter.texture && parameter.texture != &kernels::Material::normal_texture)
        row.texture = member_offset(parameter.texture);
    return row;
}

Record record_of(const MaterialInfo& info) {
    static std::deque<kernels::Material> defaults;  // at rest in memory: records point to them
    Record record{info.name, info.doc, {}, &defaults.emplace_back(default_material(info.kind))};
    if (!info.presets.empty())
        record.fields.push_back(by_hand(
            "preset", "preset", "Measured complex index of refraction, in place of `eta` and `k`; see presets."));
    for (const MaterialParameter& parameter : info.parameters) record.fields.push_back(row_of(parameter));
    if (info.kind == kernels::MATERIAL_DIELECTRIC)
        record.fields.push_back(by_hand("interior", "reference", "Medium inside."));
    for (const MaterialParameter& parameter : common_material_parameters()) record.fields.push_back(row_of(parameter));
    record.fields.push_back(
        by_hand("normal_map", "reference", "Texture of tangent-space normals; its picture has `srgb` false."));
    return record;
}

}  // namespace

const Family& material_family() {
    static const Family family = [] {
        Family result{"material", {}, ""};
        for (const MaterialInfo& info : material_infos()) result.records.push_back(record_of(info));
        return result;
    }();
    return family;
}

bool is_common_material_field(std::string_view name) {
    for (const MaterialParameter& parameter : common_material_parameters())
        if (parameter.name == name) return true;
    return name == "normal_map";
}

}  // namespace spinel
