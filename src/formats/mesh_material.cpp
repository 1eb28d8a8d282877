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

std::optional<float> number_of(const aiMaterial& source, const char* key, unsigned type, unsigned index) {
    float value = 0;
    if (source.Get(key, type, index, value) != AI_SUCCESS || !std::isfinite(value)) return std::nullopt;
    return value;
}

std::optional<float> fraction_of(const aiMaterial& source, const char* key, unsigned type, unsigned index) {
    const auto value = number_of(source, key, type, index);
    return value ? std::optional(std::clamp(*value, 0.0f, 1.0f)) : std::nullopt;
}

// Not negative, finite.
std::optional<vec4> color_of(const aiMaterial& source, const char* key, unsigned type, unsigned index) {
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
    bool gltf;
    const GltfExtras::MaterialExtras& extras;  // the defaults where the file is no glTF
    std::vector<std::string>& notes;
    kernels::Material values{};
    std::optional<Error> error{};

    std::uint32_t texture(const MeshTextures::Use& use) {
        Result<std::uint32_t> added = textures.add(source, use);
        if (added) return *added;
        if (!error) error = added.error();
        return kernels::NONE;
    }

    std::uint32_t color_map(TextureRole role = TextureRole::color, float cutoff = 0) {
        const bool base = source.GetTextureCount(aiTextureType_BASE_COLOR) > 0;
        return texture({.type = base ? aiTextureType_BASE_COLOR : aiTextureType_DIFFUSE,
                        .role = role,
                        .amount = cutoff,
                        .place = extras.texture("baseColorTexture")});
    }

    void emission(float strength) {
        auto emitted = color_of(source, AI_MATKEY_COLOR_EMISSIVE);
        if (!emitted) return;
        // Many exporters write Ke 0 beside a map.
        if (!gltf && vec3(*emitted) == vec3(0.0f) && source.GetTextureCount(aiTextureType_EMISSIVE) > 0)
            emitted = vec4(1.0f);
        values.emission = vec3(*emitted) * std::max(strength, 0.0f);
        int two_sided = 0;
        source.Get(AI_MATKEY_TWOSIDED, two_sided);
        values.emission_two_sided = two_sided ? 1u : 0u;
        if (values.emission != vec3(0.0f))
            values.emission_texture =
                texture({.type = aiTextureType_EMISSIVE, .place = extras.texture("emissiveTexture")});
    }

    // glTF keeps roughness and metallic in one picture; a format with two keeps them apart.
    std::uint32_t metallic_roughness_map(aiTextureType apart) {
        const bool packed = source.GetTextureCount(aiTextureType_UNKNOWN) > 0;
        return texture({.type = packed ? aiTextureType_UNKNOWN : apart,
                        .role = TextureRole::data,
                        .place = extras.texture("metallicRoughnessTexture")});
    }
    std::uint32_t roughness_map() { return metallic_roughness_map(aiTextureType_DIFFUSE_ROUGHNESS); }

    // Its uv set must be the material's first, since tangents run along that.
    void normal_map() {
        if (source.GetTextureCount(aiTextureType_NORMALS) == 0 && source.GetTextureCount(aiTextureType_HEIGHT) > 0) {
            values.normal_texture =
                texture({.type = aiTextureType_HEIGHT,
                         .role = TextureRole::relief,
                         .amount = number_of(source, AI_MATKEY_OBJ_BUMPMULT_HEIGHT(0)).value_or(1.0f)});
            values.normal_scale = 1.0f;
            return;
        }
        values.normal_texture = texture(
            {.type = aiTextureType_NORMALS, .role = TextureRole::data, .place = extras.texture("normalTexture")});
        values.normal_scale = number_of(source, AI_MATKEY_GLTF_TEXTURE_SCALE(aiTextureType_NORMALS, 0)).value_or(1.0f);
    }

    void begin(kernels::uint kind) {
        const kernels::Material before = values;
        values = default_material(kind);
        values.normal_texture = before.normal_texture;
        values.normal_scale = before.normal_scale;
    }

    void note(const std::string& what) {
        notes.push_back("material '" + std::string(source.GetName().C_Str()) + "': " + what);
    }
};

// Solid glass: what has a thickness in the file is a closed shape, and the ray finds how thick it is.
void make_solid_glass(Maker& maker, vec4 base, float roughness) {
    const GltfExtras::MaterialExtras& extras = maker.extras;
    maker.begin(kernels::MATERIAL_DIELECTRIC);
    maker.values.ior = extras.ior;
    maker.values.color = reflectance(base);
    maker.values.color_texture = maker.color_map();
    maker.values.roughness = roughness;
    maker.values.roughness_texture = maker.roughness_map();
    if (extras.attenuation_distance > 0)
        maker.values.absorption =
            -glm::log(glm::clamp(extras.attenuation_color, vec3(1e-4f), vec3(1.0f))) / extras.attenuation_distance;
    if (extras.transmission < 1 || extras.texture("transmissionTexture"))
        maker.note("a solid transmits or does not; its transmission is taken for whole");
    if (extras.coat > 0) maker.note("the clear coat of solid glass is left out");
    if (extras.specular != 1)
        maker.note("the specular factor of solid glass is left out, its index bends and reflects");
    if (extras.reflects_all) maker.note("an index of refraction of 0 cannot bend light, solid glass takes 1.5");
}

void make_opacity(Maker& maker, vec4 base) {
    aiString mode;
    if (maker.source.Get(AI_MATKEY_GLTF_ALPHAMODE, mode) != AI_SUCCESS) {
        maker.values.opacity = fraction_of(maker.source, AI_MATKEY_OPACITY).value_or(1.0f);
        maker.values.opacity_texture = maker.texture({.type = aiTextureType_OPACITY, .role = TextureRole::coverage});
    } else if (mode == aiString("BLEND")) {
        maker.values.opacity = std::min(base.w, 1.0f);
        maker.values.opacity_texture = maker.color_map(TextureRole::alpha);
    } else if (mode == aiString("MASK")) {
        const float cutoff = number_of(maker.source, AI_MATKEY_GLTF_ALPHACUTOFF).value_or(0.5f);
        maker.values.opacity_texture = base.w > 0 ? maker.color_map(TextureRole::mask, cutoff / base.w) : kernels::NONE;
        if (maker.values.opacity_texture == kernels::NONE) maker.values.opacity = base.w >= cutoff ? 1.0f : 0.0f;
    }
}

void make_metallic_roughness(Maker& maker) {
    const aiMaterial& source = maker.source;
    const GltfExtras::MaterialExtras& extras = maker.extras;
    auto base = color_of(source, AI_MATKEY_BASE_COLOR);
    if (!base) base = color_of(source, AI_MATKEY_COLOR_DIFFUSE).value_or(vec4(1.0f));
    if (extras.unlit) {  // a surface of its own light
        maker.begin(kernels::MATERIAL_DIFFUSE);
        maker.values.color = vec3(0.0f);
        maker.values.emission = vec3(*base);
        maker.values.emission_two_sided = 1;
        maker.values.emission_texture = maker.color_map();
        make_opacity(maker, *base);
        return;
    }
    maker.normal_map();
    const float roughness = fraction_of(source, AI_MATKEY_ROUGHNESS_FACTOR).value_or(1.0f);
    if (extras.thickness > 0 && extras.transmission >= 0.5f) {
        make_solid_glass(maker, *base, roughness);
        return;
    }
    maker.begin(kernels::MATERIAL_PRINCIPLED);
    kernels::Material& values = maker.values;
    values.color = reflectance(*base);
    values.roughness = roughness;
    values.metallic = fraction_of(source, AI_MATKEY_METALLIC_FACTOR).value_or(1.0f);
    values.ior = extras.reflection_ior;
    if (extras.reflects_all) maker.note("an index of refraction of 0, which reflects all, is held to 3");
    values.color_texture = maker.color_map();
    values.roughness_texture = maker.roughness_map();
    values.metallic_texture = maker.metallic_roughness_map(aiTextureType_METALNESS);
    // An MTL has Pc and Pcr.
    values.coat = maker.gltf ? extras.coat : fraction_of(source, AI_MATKEY_CLEARCOAT_FACTOR).value_or(0.0f);
    values.coat_roughness =
        maker.gltf ? extras.coat_roughness : fraction_of(source, AI_MATKEY_CLEARCOAT_ROUGHNESS_FACTOR).value_or(0.0f);
    values.transmission = extras.transmission;
    if (extras.coat > 0) {
        values.coat_texture = maker.texture(
            {.type = aiTextureType_CLEARCOAT, .role = TextureRole::data, .place = extras.texture("clearcoatTexture")});
        values.coat_roughness_texture = maker.texture({.type = aiTextureType_CLEARCOAT,
                                                       .number = 1,
                                                       .role = TextureRole::data,
                                                       .place = extras.texture("clearcoatRoughnessTexture")});
    }
    if (extras.transmission > 0) {
        values.transmission_texture = maker.texture({.type = aiTextureType_TRANSMISSION,
                                                     .role = TextureRole::data,
                                                     .place = extras.texture("transmissionTexture")});
        if (extras.thickness > 0) maker.note("a solid that transmits less than half is taken for a thin wall");
    }
    maker.emission(extras.emissive_strength);
    if (extras.coat > 0 && values.emission != vec3(0.0f)) maker.note("the clear coat does not darken the emission");
    make_opacity(maker, *base);
}

// Phong's exponent as the perceptual roughness of a microfacet lobe of the same width: α² = 2 / (n + 2).
float roughness_of_exponent(float exponent) { return std::pow(2.0f / (std::max(exponent, 0.0f) + 2.0f), 0.25f); }

void make_phong(Maker& maker) {
    const aiMaterial& source = maker.source;
    const vec4 diffuse = color_of(source, AI_MATKEY_COLOR_DIFFUSE).value_or(vec4(0.8f));
    const vec4 specular = color_of(source, AI_MATKEY_COLOR_SPECULAR).value_or(vec4(0.0f));
    const float exponent = number_of(source, AI_MATKEY_SHININESS).value_or(0.0f);
    const float ior = number_of(source, AI_MATKEY_REFRACTI).value_or(1.0f);
    const float opacity = fraction_of(source, AI_MATKEY_OPACITY).value_or(1.0f);
    int illumination = -1;
    source.Get(AI_MATKEY_OBJ_ILLUM, illumination);

    const bool glass = illumination == 4 || illumination == 6 || illumination == 7 || illumination == 9;
    const bool mirror = illumination == 3 || illumination == 5;
    maker.normal_map();
    if (glass) {
        maker.begin(kernels::MATERIAL_DIELECTRIC);
        maker.values.ior = std::clamp(ior > 1.0f ? ior : 1.5f, 1.0f, 3.0f);
        return;
    }
    if (mirror && specular != vec4(0, 0, 0, specular.w)) {
        maker.begin(kernels::MATERIAL_METAL);
        maker.values.color = reflectance(specular);
        maker.values.roughness = 0;
    } else {
        const bool shiny = std::max({specular.x, specular.y, specular.z}) > 0.05f && exponent > 1.0f;
        maker.begin(shiny ? kernels::MATERIAL_PLASTIC : kernels::MATERIAL_DIFFUSE);
        maker.values.color = reflectance(diffuse);
        if (shiny) maker.values.roughness = roughness_of_exponent(exponent);
        if (shiny && ior > 1.0f) maker.values.ior = std::clamp(ior, 1.2f, 3.0f);
        maker.values.color_texture = maker.texture({.type = aiTextureType_DIFFUSE});
        // Many exporters write Kd 0 beside a map.
        if (maker.values.color_texture != kernels::NONE && maker.values.color == vec3(0.0f))
            maker.values.color = vec3(1.0f);
    }
    maker.emission(1.0f);
    maker.values.opacity = opacity;
    maker.values.opacity_texture = maker.texture({.type = aiTextureType_OPACITY, .role = TextureRole::coverage});
}

}  // namespace

Result<Material> mesh_material(const aiMaterial& source, const GltfExtras::MaterialExtras* extras,
                               MeshTextures& textures, std::vector<std::string>& notes) {
    Material material;
    material.name = source.GetName().C_Str();
    textures.begin_material();
    if (material.name == AI_DEFAULT_MATERIAL_NAME || (extras == nullptr && material.name.empty())) {
        material.name = "default";
        material.values = default_material(kernels::MATERIAL_DIFFUSE);
        return material;
    }
    static const GltfExtras::MaterialExtras none;
    Maker maker{source, textures, extras != nullptr, extras ? *extras : none, notes};
    if (extras || number_of(source, AI_MATKEY_METALLIC_FACTOR) || number_of(source, AI_MATKEY_ROUGHNESS_FACTOR))
        make_metallic_roughness(maker);
    else make_phong(maker);
    if (maker.error) return *maker.error;
    material.values = maker.values;
    return material;
}

}  // namespace spinel
