#include "formats/gltf_extras.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/byte_reader.h"
#include "formats/file_bytes.h"
#include "formats/mesh_checks.h"

namespace spinel {
namespace {

using Json = nlohmann::json;

constexpr int MAX_NESTING = 256;              // of JSON; glTF itself needs about ten
constexpr std::size_t MAX_GLTF_DEPTH = 1000;  // of nodes below nodes
constexpr float MOST_IOR = 3;

// Those that are read, and those that change nothing that is.
constexpr const char* UNDERSTOOD[] = {
    "KHR_lights_punctual", "KHR_materials_clearcoat", "KHR_materials_emissive_strength",
    "KHR_materials_ior",   "KHR_materials_specular",  "KHR_materials_transmission",
    "KHR_materials_unlit", "KHR_materials_volume",    "KHR_texture_transform",
    "KHR_xmp_json_ld",
};

const Json& member(const Json& object, const char* key) {
    static const Json nothing;
    if (!object.is_object()) return nothing;
    const auto found = object.find(key);
    return found == object.end() ? nothing : *found;
}

float json_number(const Json& object, const char* key, float otherwise) {
    const Json& value = member(object, key);
    if (!value.is_number()) return otherwise;
    const float result = value.get<float>();
    return std::isfinite(result) ? result : otherwise;
}

// The JSON text: the file itself, or the first chunk of a binary one.
Result<std::string_view> json_text(const std::filesystem::path& path, std::string_view bytes) {
    if (bytes.substr(0, 4) != "glTF") return bytes;
    ByteReader reader(bytes);
    reader.take(4);
    const std::uint32_t version = reader.u32();
    reader.u32();  // length of the file
    const std::uint32_t length = reader.u32();
    const std::string_view type = reader.take(4);
    const std::string_view text = reader.take(length);
    if (!reader.ok())
        return cannot_read(path, "byte " + std::to_string(reader.offset()) + ": the file ends in its JSON");
    if (version != 2) return cannot_read(path, "its version is " + std::to_string(version) + ", readable is 2");
    if (type != "JSON") return cannot_read(path, "byte 16: the first chunk is not JSON");
    return text;
}

vec3 json_color(const Json& object, const char* key, vec3 otherwise) {
    const Json& value = member(object, key);
    if (!value.is_array() || value.size() != 3) return otherwise;
    vec3 result;
    for (int i = 0; i < 3; ++i) {
        const Json& component = value[std::size_t(i)];
        result[i] = component.is_number() ? component.get<float>() : NAN;
        if (!(result[i] >= 0 && std::isfinite(result[i]))) return otherwise;
    }
    return result;
}

vec2 pair(const Json& object, const char* key, vec2 otherwise) {
    const Json& value = member(object, key);
    if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number()) return otherwise;
    const vec2 result(value[0].get<float>(), value[1].get<float>());
    return std::isfinite(result.x) && std::isfinite(result.y) ? result : otherwise;
}

float json_fraction(const Json& object, const char* key) { return std::clamp(json_number(object, key, 0), 0.0f, 1.0f); }

bool understood(const std::string& name) {
    return std::find(std::begin(UNDERSTOOD), std::end(UNDERSTOOD), name) != std::end(UNDERSTOOD);
}

// KHR_texture_transform: uv is scaled, turned counter-clockwise and moved, with v downwards.
GltfTexturePlace texture_place(const Json& use) {
    const Json& transform = member(member(use, "extensions"), "KHR_texture_transform");
    const float set = json_number(transform, "texCoord", json_number(use, "texCoord", 0));
    GltfTexturePlace place;
    place.uv_set = set >= 0 && set < 1000 ? unsigned(set) : 1000;
    place.scale = pair(transform, "scale", {1, 1});
    const float angle = json_number(transform, "rotation", 0);
    const vec2 offset = pair(transform, "offset", {0, 0});
    place.rotation = glm::degrees(angle);
    place.offset = {offset.x + std::sin(angle) * place.scale.y, 1 - std::cos(angle) * place.scale.y - offset.y};
    return place;
}

GltfExtras::MaterialExtras material_extras(const Json& material) {
    const Json& extensions = member(material, "extensions");
    const Json& coat = member(extensions, "KHR_materials_clearcoat");
    const Json& transmission = member(extensions, "KHR_materials_transmission");
    const Json& volume = member(extensions, "KHR_materials_volume");
    const Json& specular = member(extensions, "KHR_materials_specular");
    GltfExtras::MaterialExtras extras;
    const float ior = json_number(member(extensions, "KHR_materials_ior"), "ior", 1.5f);
    extras.reflects_all = ior == 0;
    if (!extras.reflects_all) extras.ior = std::clamp(ior, 1.0f, MOST_IOR);
    if (specular.is_object()) {
        const vec3 tint = json_color(specular, "specularColorFactor", vec3(1));
        extras.specular =
            std::clamp(json_number(specular, "specularFactor", 1), 0.0f, 1.0f) * (tint.x + tint.y + tint.z) / 3;
    }
    extras.reflection_ior = extras.ior;
    if (extras.reflects_all || extras.specular != 1) {
        const float whole = extras.reflects_all ? 1.0f : (extras.ior - 1) / (extras.ior + 1);
        const float root = std::min(whole * std::sqrt(extras.specular), (MOST_IOR - 1) / (MOST_IOR + 1));
        extras.reflection_ior = (1 + root) / (1 - root);
    }
    extras.emissive_strength =
        json_number(member(extensions, "KHR_materials_emissive_strength"), "emissiveStrength", 1.0f);
    extras.unlit = member(extensions, "KHR_materials_unlit").is_object();
    extras.coat = json_fraction(coat, "clearcoatFactor");
    extras.coat_roughness = json_fraction(coat, "clearcoatRoughnessFactor");
    extras.transmission = json_fraction(transmission, "transmissionFactor");
    extras.thickness = std::max(json_number(volume, "thicknessFactor", 0), 0.0f);
    extras.attenuation_distance = std::max(json_number(volume, "attenuationDistance", 0), 0.0f);
    extras.attenuation_color = json_color(volume, "attenuationColor", vec3(1));
    for (const Json* group : {&material, &member(material, "pbrMetallicRoughness"), &coat, &transmission})
        for (const char* key : {"baseColorTexture", "metallicRoughnessTexture", "normalTexture", "emissiveTexture",
                                "clearcoatTexture", "clearcoatRoughnessTexture", "transmissionTexture"})
            if (member(*group, key).is_object()) extras.textures[key] = texture_place(member(*group, key));
    return extras;
}

// Nodes are trees: none has two parents, none is its own, and none lies too deep for those who follow by recursion.
Result<void> check_nodes(const std::filesystem::path& path, const Json& json) {
    const Json& nodes = member(json, "nodes");
    if (!nodes.is_array()) return {};
    constexpr std::size_t none = std::size_t(-1);
    std::vector<std::size_t> parent(nodes.size(), none);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        for (const Json& child : member(nodes[i], "children")) {
            if (!child.is_number_unsigned()) continue;
            const auto c = child.get<std::size_t>();
            if (c >= nodes.size()) continue;
            if (parent[c] != none)
                return cannot_read(path, "node " + std::to_string(c) + " has two parents, nodes must form trees");
            parent[c] = i;
        }
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        std::size_t above = 0;
        for (std::size_t at = i; parent[at] != none; at = parent[at])
            if (++above > MAX_GLTF_DEPTH)
                return cannot_read(path, "node " + std::to_string(i) + " lies below more than the " +
                                             std::to_string(MAX_GLTF_DEPTH) + " nodes allowed, or below itself");
    }
    return {};
}

// Names in a row: "a, b".
void add_name(std::string& names, const std::string& name) { names += (names.empty() ? "" : ", ") + name; }

// What is in the file and does not come into the scene.
std::vector<std::string> left_out_of_gltf(const Json& json) {
    std::vector<std::string> notes;
    std::string extensions;
    for (const Json& extension : member(json, "extensionsUsed"))
        if (extension.is_string() && !understood(extension.get<std::string>()))
            add_name(extensions, extension.get<std::string>());
    if (!extensions.empty()) notes.push_back("extensions that are not read are left out: " + extensions);
    std::string coat_normals, turned_normals, tints;
    for (const Json& material : member(json, "materials")) {
        const Json& name = member(material, "name");
        const std::string called = name.is_string() ? name.get<std::string>() : "without a name";
        const Json& used = member(material, "extensions");
        if (member(member(used, "KHR_materials_clearcoat"), "clearcoatNormalTexture").is_object())
            add_name(coat_normals, called);
        if (texture_place(member(material, "normalTexture")).rotation != 0) add_name(turned_normals, called);
        const Json& specular = member(used, "KHR_materials_specular");
        const vec3 tint = json_color(specular, "specularColorFactor", vec3(1));
        if (member(specular, "specularTexture").is_object() || member(specular, "specularColorTexture").is_object() ||
            tint.x != tint.y || tint.y != tint.z)
            add_name(tints, called);
    }
    if (!coat_normals.empty()) notes.push_back("normal maps of clear coats are left out: " + coat_normals);
    if (!turned_normals.empty())
        notes.push_back("normal maps are turned with their pictures, their relief is not: " + turned_normals);
    if (!tints.empty()) notes.push_back("tints and textures of KHR_materials_specular are left out: " + tints);
    std::string moving;
    for (const char* key : {"animations", "skins"})
        if (!member(json, key).empty()) add_name(moving, key);
    for (const Json& mesh : member(json, "meshes"))
        for (const Json& primitive : member(mesh, "primitives"))
            if (!member(primitive, "targets").empty() && moving.find("morph") == std::string::npos)
                add_name(moving, "morph targets");
    if (!moving.empty()) notes.push_back("the model stands still: " + moving + " are left out");
    return notes;
}

}  // namespace

Result<GltfExtras> read_gltf_extras(const std::filesystem::path& path) {
    const Result<std::string> bytes = read_file_bytes(path, std::uintmax_t(1) << 31);
    if (!bytes) return bytes.error();
    const Result<std::string_view> text = json_text(path, *bytes);
    if (!text) return text.error();
    if (is_nested_deeper(*text, MAX_NESTING))
        return cannot_read(path,
                           "its JSON is nested deeper than the " + std::to_string(MAX_NESTING) + " levels allowed");
    const Json json = Json::parse(*text, nullptr, false);
    if (json.is_discarded() || !json.is_object()) return cannot_read(path, "its JSON is damaged");

    for (const Json& extension : member(json, "extensionsRequired")) {
        if (!extension.is_string()) return cannot_read(path, "extensionsRequired holds something that is no name");
        const std::string name = extension.get<std::string>();
        if (!understood(name))
            return cannot_read(path, "it requires the extension " + name + ", which is not supported");
    }

    if (Result<void> tree = check_nodes(path, json); !tree) return tree.error();
    GltfExtras extras;
    unsigned index = 0;
    for (const Json& material : member(json, "materials")) extras.materials[index++] = material_extras(material);
    for (const Json& camera : member(json, "cameras"))
        extras.cameras.push_back({std::max(json_number(member(camera, "perspective"), "yfov", 0.0f), 0.0f),
                                  std::max(json_number(member(camera, "orthographic"), "ymag", 0.0f), 0.0f)});
    extras.notes = left_out_of_gltf(json);
    return extras;
}

}  // namespace spinel
