#include "scene/material_registry.h"

#include <cstring>

#include "kernels/materials.h"

namespace spinel {

namespace {

constexpr MaterialInfo infos[] = {
#define SPINEL_MATERIAL_INFO(number, CONSTANT, name)                                   \
    MaterialInfo{kernels::MATERIAL_##CONSTANT, #name, kernels::name##_description.doc, \
                 kernels::name##_description.parameters, kernels::name##_description.presets},
    SPINEL_MATERIALS(SPINEL_MATERIAL_INFO)
#undef SPINEL_MATERIAL_INFO
};

constexpr MaterialParameter common_parameters[] = {
    {"emission", &kernels::Material::emission, glm::vec3(0.0f), 0, 1e9f, &kernels::Material::emission_texture,
     "Radiance that the surface sends out, W/(sr m^2)."},
    {"emission_two_sided", &kernels::Material::emission_two_sided, 0u, 0, 1, nullptr,
     "True: both sides emit; false: only the side of the outward normal."},
    {"normal_scale", &kernels::Material::normal_scale, 1.0f, 0, 10, &kernels::Material::normal_texture,
     "Strength of the normal map, which is the texture."},
    {"opacity", &kernels::Material::opacity, 1.0f, 0, 1, &kernels::Material::opacity_texture,
     "Chance that a ray meets the surface at all; of a texture, the alpha channel."},
};

void set_defaults(kernels::Material& material, std::span<const MaterialParameter> parameters) {
    for (const MaterialParameter& parameter : parameters) {
        std::visit(
            [&](auto member) {
                using Value = std::remove_reference_t<decltype(material.*member)>;
                material.*member = std::get<Value>(parameter.initial);
            },
            parameter.member);
    }
}

}  // namespace

std::span<const MaterialInfo> material_infos() { return infos; }

const MaterialInfo* find_material_info(std::string_view name) {
    for (const MaterialInfo& info : infos) {
        if (info.name == name) return &info;
    }
    return nullptr;
}

const MaterialInfo* find_material_info(kernels::uint kind) {
    for (const MaterialInfo& info : infos) {
        if (info.kind == kind) return &info;
    }
    return nullptr;
}

std::span<const MaterialParameter> common_material_parameters() { return common_parameters; }

kernels::Material default_material(kernels::uint kind) {
    kernels::Material material{};
    for (const auto member : material_texture_members) material.*member = kernels::NONE;
    material.interior = kernels::NONE;
    material.kind = kind;
    material.edge_color = glm::vec3(1.0f);  // members that a kind does not use still hold sane values
    material.ior = 1.5f;
    set_defaults(material, common_parameters);
    if (const MaterialInfo* info = find_material_info(kind)) set_defaults(material, info->parameters);
    return material;
}

bool same_material(const kernels::Material& a, const kernels::Material& b) {
    // Scalar layout without padding: what is equal to the user has equal bytes, but for the sign of a zero.
    // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
    return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace spinel
