#pragma once
// Host side only: how a material describes its scene parameters, next to its physics. The JSON reader, its
// schema, `spinel list` and the documentation are made from these tables.

#include <span>
#include <string_view>
#include <variant>

#include "../scene_view.h"

namespace spinel::kernels {

struct MaterialParameter {
    std::string_view name;  // as in a scene file
    std::variant<float Material::*, vec3 Material::*, int Material::*, uint Material::*> member;
    std::variant<float, vec3, int, uint> initial;  // the default, of the member's type
    float minimum;
    float maximum;                      // both inclusive, per component
    uint Material::*texture = nullptr;  // index of a texture that multiplies it, if it takes one
    std::string_view doc;
};

// Named values of a material's parameters, for example measured metals.
struct MaterialPreset {
    std::string_view name;
    vec3 eta;  // complex index of refraction η + iκ at about 630, 532 and 465 nm
    vec3 k;
};

struct MaterialDescription {
    std::string_view doc;
    std::span<const MaterialParameter> parameters;
    std::span<const MaterialPreset> presets;
};

}  // namespace spinel::kernels
