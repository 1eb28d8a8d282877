#pragma once
// Rows of the scene file for materials, made from the material registry.

#include "scene/scene_fields.h"

namespace spinel {

// Each material is a record over kernels::Material, in the order of material_infos(). By hand are read:
// "preset" where there are presets, "interior" of dielectrics, "normal_map".
const Family& material_family();

// Whether every material has this row, besides its own.
bool is_common_material_field(std::string_view name);

}  // namespace spinel
