#pragma once
// The materials there are, by name, made from the table in kernels/materials.h and the description in each
// material's own file. What reads, lists, documents or tests materials goes through here.

#include <optional>
#include <span>
#include <string_view>

#include "kernels/materials/description.h"

namespace spinel {

using kernels::MaterialParameter;
using kernels::MaterialPreset;

struct MaterialInfo {
    kernels::uint kind;  // MATERIAL_…
    std::string_view name;
    std::string_view doc;
    std::span<const MaterialParameter> parameters;  // of this kind alone, see common_material_parameters()
    std::span<const MaterialPreset> presets;
};

std::span<const MaterialInfo> material_infos();
const MaterialInfo* find_material_info(std::string_view name);  // nullptr: there is none
const MaterialInfo* find_material_info(kernels::uint kind);

// What every kind understands besides its own parameters: emission, opacity, normal map.
std::span<const MaterialParameter> common_material_parameters();

// The members that are textures.
inline constexpr kernels::uint kernels::Material::*material_texture_members[] = {
    &kernels::Material::color_texture,        &kernels::Material::roughness_texture,
    &kernels::Material::metallic_texture,     &kernels::Material::emission_texture,
    &kernels::Material::normal_texture,       &kernels::Material::opacity_texture,
    &kernels::Material::coat_texture,         &kernels::Material::coat_roughness_texture,
    &kernels::Material::transmission_texture,
};

// Defaults of the kind; every texture and the interior NONE.
kernels::Material default_material(kernels::uint kind);

// Bit for bit.
bool same_material(const kernels::Material& a, const kernels::Material& b);

}  // namespace spinel
