#include "formats/mesh_material.h"

#include <assimp/GltfMaterial.h>
#include <assimp/ObjMaterial.h>
#include <assimp/material.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "kernels/constants.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel {
namespace {

std::optional<float> number(const aiMaterial& source, const char* key, unsigned type, unsigned index) {
    float value = 0;
    if (source.Get(key, type, index, value) != AI_SUCCESS || !std::isfinite(value)) return std::nullopt;
    return value;
}

std::optional<float> fraction(const aiMaterial& source, const char* key, unsigned type, unsigned index) {
    const auto value = number(source, key, type, index);
    return value ? std::optional(std::clamp(*value, 0.0f, 1.0f)) : std::nullopt;
}

// Not negative, finite.
std::optional<vec4> color(const aiMaterial& source, const char* key, unsigned type, unsigned index) {
    aiColor4D value(0, 0, 0, 1);
    if (source.Get(key, type, index, value) != AI_SUCCESS) return std::nullopt;
    const vec4 result(value.r, value.g, value.b, value.a);
    for (int c = 0; c < 4; ++c)
        if (!std::isfinite(result[c])) return std::nullopt;
    return glm::max(result, 0.0f);
}

vec3 reflectance(vec4 c) { return glm::min(vec3(c), 1.0f); }

// One material in the making; the first texture that fails is the error of all.
struct Maker {
    const aiMaterial& source;
    MeshTextures& textures;
    kernels::Material values{};
    std::optional<Error> error{};

    std::uint32_t texture(aiTextureType type, TextureRole role, float cutoff = 0) {
        Result<std::uint32_t> added = textures.add(source, type, role, cutoff);
        if (added) return *added;
        if (!error) error = added.error();
        return kernels::NONE;
    }

    void emission(float strength) {
        const auto emitted = color(source, AI_MATKEY_COLOR_EMISSIVE);
        if (!emitted) return;
        values.emission = vec3(*emitted) * std::max(strength, 0.0f);
        int two_sided = 0;
        source.Get(AI_MATKEY_TWOSIDED, two_sided);
        values.emission_two_sided = two_sided ? 1u : 0u;
        if (values.emission != vec3(0.0f))
            values.emission_texture = texture(aiTextureType_EMISSIVE, TextureRole::color);
    }

    // glTF keeps roughness and metallic in one picture; a format with two keeps them apart.
    bool packed() const { return source.GetTextureCount(aiTextureType_UNKNOWN) > 0; }
    std::uint32_t roughness_map() {
        return texture(packed() ? aiTextureType_UNKNOWN : aiTextureType_DIFFUSE_ROUGHNESS, TextureRole::data);
    }

    void normal_map() {
        values.normal_texture = texture(aiTextureType_NORMALS, TextureRole::data);
        values.normal_scale = number(source, AI_MATKEY_GLTF_TEXTURE_SCALE(aiTextureType_NORMALS, 0)).value_or(1.0f);
    }

    void glass(float ior) {
        values = default_material(kernels::MATERIAL_DIELECTRIC);
        values.ior = std::clamp(ior, 1.0f, 3.0f);
    }
};

aiTextureType base_color_type(const aiMaterial& source) {
    return source.GetTextureCount(aiTextureType_BASE_COLOR) > 0 ? aiTextureType_BASE_COLOR : aiTextureType_DIFFUSE;
}

void make_metallic_roughness(Maker& maker, const GltfExtras::MaterialExtras& extras) {
    const aiMaterial& source = maker.source;
    auto base = color(source, AI_MATKEY_BASE_COLOR);
    if (!base) base = color(source, AI_MATKEY_COLOR_DIFFUSE).value_or(vec4(1.0f));
    const float roughness = fraction(source, AI_MATKEY_ROUGHNESS_FACTOR).value_or(1.0f);

    if (fraction(source, AI_MATKEY_TRANSMISSION_FACTOR).value_or(0.0f) >= 0.5f) {
        maker.glass(extras.ior);
        maker.values.color = reflectance(*base);
        maker.values.color_texture = maker.texture(base_color_type(source), TextureRole::color);
        maker.values.roughness = roughness;
        maker.values.roughness_texture = maker.roughness_map();
        const float distance = number(source, AI_MATKEY_VOLUME_ATTENUATION_DISTANCE).value_or(0.0f);
        const auto attenuation = color(source, AI_MATKEY_VOLUME_ATTENUATION_COLOR);
        if (distance > 0 && attenuation)  // the colour that white light has after the distance
            maker.values.absorption = -glm::log(glm::clamp(vec3(*attenuation), vec3(1e-4f), vec3(1.0f))) / distance;
        maker.normal_map();
        return;
    }
    maker.values = default_material(kernels::MATERIAL_PRINCIPLED);
    maker.values.color = reflectance(*base);
    maker.values.roughness = roughness;
    maker.values.metallic = fraction(source, AI_MATKEY_METALLIC_FACTOR).value_or(1.0f);
    maker.values.ior = std::clamp(extras.ior, 1.0f, 3.0f);
    maker.values.color_texture = maker.texture(base_color_type(source), TextureRole::color);
    maker.values.roughness_texture = maker.roughness_map();
    maker.values.metallic_texture =
        maker.texture(maker.packed() ? aiTextureType_UNKNOWN : aiTextureType_METALNESS, TextureRole::data);
    maker.normal_map();
    maker.emission(extras.emissive_strength);

    aiString mode;
    if (source.Get(AI_MATKEY_GLTF_ALPHAMODE, mode) != AI_SUCCESS) {
        maker.values.opacity = fraction(source, AI_MATKEY_OPACITY).value_or(1.0f);
    } else if (mode == aiString("BLEND")) {
        maker.values.opacity = std::min(base->w, 1.0f);
        maker.values.opacity_texture = maker.texture(base_color_type(source), TextureRole::alpha);
    } else if (mode == aiString("MASK")) {
        const float cutoff = number(source, AI_MATKEY_GLTF_ALPHACUTOFF).value_or(0.5f);
        maker.values.opacity_texture =
            base->w > 0 ? maker.texture(base_color_type(source), TextureRole::mask, cutoff / base->w) : kernels::NONE;
        if (maker.values.opacity_texture == kernels::NONE) maker.values.opacity = base->w >= cutoff ? 1.0f : 0.0f;
    }
}

// Phong's exponent as the perceptual roughness of a microfacet lobe of the same width: α² = 2 / (n + 2).
float roughness_of_exponent(float exponent) { return std::pow(2.0f / (std::max(exponent, 0.0f) + 2.0f), 0.25f); }

void make_phong(Maker& maker) {
    const aiMaterial& source = maker.source;
    const vec4 diffuse = color(source, AI_MATKEY_COLOR_DIFFUSE).value_or(vec4(0.8f));
    const vec4 specular = color(source, AI_MATKEY_COLOR_SPECULAR).value_or(vec4(0.0f));
    const float exponent = number(source, AI_MATKEY_SHININESS).value_or(0.0f);
    const float ior = number(source, AI_MATKEY_REFRACTI).value_or(1.0f);
    const float opacity = fraction(source, AI_MATKEY_OPACITY).value_or(1.0f);
    int illumination = -1;
    source.Get(AI_MATKEY_OBJ_ILLUM, illumination);

    const bool glass = illumination == 4 || illumination == 6 || illumination == 7 || illumination == 9;
    const bool mirror = illumination == 3 || illumination == 5;
    if (glass) {
        maker.glass(ior > 1.0f ? ior : 1.5f);
        return;
    }
    if (mirror && specular != vec4(0, 0, 0, specular.w)) {
        maker.values = default_material(kernels::MATERIAL_METAL);
        maker.values.color = reflectance(specular);
        maker.values.roughness = 0;
    } else {
        const bool shiny = std::max({specular.x, specular.y, specular.z}) > 0.05f && exponent > 1.0f;
        maker.values = default_material(shiny ? kernels::MATERIAL_PLASTIC : kernels::MATERIAL_DIFFUSE);
        maker.values.color = reflectance(diffuse);
        if (shiny) maker.values.roughness = roughness_of_exponent(exponent);
        if (shiny && ior > 1.0f) maker.values.ior = std::clamp(ior, 1.2f, 3.0f);
        maker.values.color_texture = maker.texture(aiTextureType_DIFFUSE, TextureRole::color);
        // Many exporters write Kd 0 beside a map.
        if (maker.values.color_texture != kernels::NONE && maker.values.color == vec3(0.0f))
            maker.values.color = vec3(1.0f);
    }
    maker.normal_map();
    maker.emission(1.0f);
    maker.values.opacity = opacity;
    maker.values.opacity_texture = maker.texture(aiTextureType_OPACITY, TextureRole::coverage);
}

}  // namespace

Result<Material> mesh_material(const aiMaterial& source, const GltfExtras::MaterialExtras* extras,
                               MeshTextures& textures) {
    Material material;
    material.name = source.GetName().C_Str();
    textures.begin_material();
    if (material.name == AI_DEFAULT_MATERIAL_NAME || (extras == nullptr && material.name.empty())) {
        material.name = "default";
        material.values = default_material(kernels::MATERIAL_DIFFUSE);
        return material;
    }
    Maker maker{source, textures};
    if (extras) make_metallic_roughness(maker, *extras);
    else if (number(source, AI_MATKEY_METALLIC_FACTOR) || number(source, AI_MATKEY_ROUGHNESS_FACTOR))
        make_metallic_roughness(maker, {});
    else make_phong(maker);
    if (maker.error) return *maker.error;
    material.values = maker.values;
    return material;
}

}  // namespace spinel
