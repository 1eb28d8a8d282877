#include "formats/vox_material.h"

#include <algorithm>
#include <cmath>

#include "image/tone_map.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel::vox {
namespace {

using Properties = Dictionary;

float vox_fraction(const Properties& properties, const char* key, float otherwise) {
    return std::clamp(number(properties, key, otherwise), 0.0f, 1.0f);
}

// The glow of emissive voxels. The program's "power" (`_flux`, 0 … 4) multiplies by ten a step on the light that
// reaches other voxels, but shows the voxel itself as bright as a display can (`_ldr`). Here both are one radiance, so
// a step is two stops: at 0 a lamp is as bright as its colour in full daylight, at 4 it is 256 times that and still has
// a hue in a picture.
vec3 emitted(const Properties& properties, vec3 color, float weight) {
    const float flux = std::clamp(number(properties, "_flux", 0.0f), 0.0f, 4.0f);
    return color * std::clamp(number(properties, "_emit", weight), 0.0f, 1.0f) * std::pow(4.0f, flux);
}

// `_sp` multiplies the reflectance at normal incidence of what is not a metal.
float index_with_specular(const Properties& properties, float ior) {
    const float root = (ior - 1.0f) / (ior + 1.0f);
    const float scaled = std::sqrt(std::clamp(root * root * number(properties, "_sp", 1.0f), 0.0f, 0.5f));
    return std::clamp((1.0f + scaled) / (1.0f - scaled), 1.0f, 3.0f);
}

// `_ri` is the index itself, `_ior` lies one below it (0 … 1); some writers put the index itself there too.
float index_of_refraction(const Properties& properties) {
    const float above_one = number(properties, "_ior", 0.3f);
    return std::clamp(number(properties, "_ri", above_one > 1.0f ? above_one : 1.0f + above_one), 1.0f, 3.0f);
}

// The palette's colour is that of light scattered once; `_d` is the extinction per voxel.
Medium inner_medium(const Properties& properties, vec3 color) {
    Medium medium;
    const float density = std::clamp(number(properties, "_d", 0.05f), 0.0f, 100.0f);
    const std::string type = word(properties, "_media_type");
    const float legacy_type = number(properties, "_media", 1.0f);
    if (type == "_absorb" || (type.empty() && legacy_type == 0.0f)) {
        medium.absorption = (1.0f - color) * density;
    } else if (type == "_emit" || (type.empty() && legacy_type == 2.0f)) {
        medium.emission = color * density;
        medium.absorption = vec3(density);
    } else {
        medium.scattering = color * density;
        medium.absorption = (1.0f - color) * density;
    }
    medium.g = std::clamp(number(properties, "_g", 0.0f), -0.95f, 0.95f);
    return medium;
}

// MagicaVoxel's glass is tinted without a unit of length. Here the palette's colour is what is left of white
// light after 4 voxels at a transparency of one half, sooner when less transparent, and after 1/_d voxels
// (20) at the latest.
vec3 glass_absorption(const Properties& properties, vec3 color, float transparency) {
    // `_att` is what came before `_d`.
    const float density = std::clamp(number(properties, "_d", number(properties, "_att", 0.05f)), 0.0f, 1.0f);
    const float opaque = (1.0f - transparency) / (4.0f * std::max(transparency, 0.05f));
    return -glm::log(glm::clamp(color, vec3(0.005f), vec3(1.0f))) * std::max(density, opaque);
}

Appearance glass(const Properties& properties, vec3 color, float transparency) {
    Appearance result;
    result.material = default_material(kernels::MATERIAL_DIELECTRIC);
    result.material.ior = index_of_refraction(properties);
    result.material.roughness = vox_fraction(properties, "_rough", 0.0f);
    if (number(properties, "_media", 0.0f) > 0.0f) result.medium = inner_medium(properties, color);
    else result.material.absorption = glass_absorption(properties, color, transparency);
    return result;
}

}  // namespace

Appearance appearance(const std::array<std::uint8_t, 4>& bytes, const Dictionary& properties) {
    vec3 color;
    for (int c = 0; c < 3; ++c) color[c] = srgb_decoded(float(bytes[std::size_t(c)]) / 255.0f);
    const std::string type = word(properties, "_type");
    const float weight = vox_fraction(properties, "_weight", 1.0f);  // how much of the type, before version 0.99.5

    Appearance result;
    if (type == "_media" || type == "_cloud") {
        result.cloud = true;
        result.medium = inner_medium(properties, color);
        return result;
    }
    const float transparency = vox_fraction(properties, "_trans", vox_fraction(properties, "_alpha", 0.0f));
    if (type == "_glass") {
        const bool told = properties.count("_trans") || properties.count("_alpha");
        return glass(properties, color, told ? transparency : weight);
    }
    // A blend is one of its parts where that part is the greater.
    if (type == "_blend" && transparency >= 0.5f) return glass(properties, color, transparency);

    const float roughness = vox_fraction(properties, "_rough", 0.1f);
    if (type == "_metal" || (type == "_blend" && number(properties, "_metal", 0.0f) > 0.0f)) {
        const float metallic = vox_fraction(properties, "_metal", weight);
        const bool coated = number(properties, "_plastic", 0.0f) > 0.0f;
        result.material = default_material(coated             ? kernels::MATERIAL_PLASTIC
                                           : metallic > 0.99f ? kernels::MATERIAL_METAL
                                                              : kernels::MATERIAL_PRINCIPLED);
        result.material.metallic = coated ? 0.0f : metallic;
        result.material.roughness = roughness;
        if (coated) result.material.ior = std::max(index_of_refraction(properties), 1.3f);
        else if (metallic <= 0.99f) result.material.ior = index_with_specular(properties, 1.5f);
    } else if (type == "_plastic") {
        result.material = default_material(kernels::MATERIAL_PLASTIC);
        result.material.roughness = roughness;
        result.material.ior = std::max(index_of_refraction(properties), 1.3f);
    } else {
        result.material = default_material(kernels::MATERIAL_DIFFUSE);
    }
    result.material.color = color;
    if (type == "_emit" || (type == "_blend" && number(properties, "_emit", 0.0f) > 0.0f)) {
        result.material.emission = emitted(properties, color, weight);
    }
    return result;
}

}  // namespace spinel::vox
