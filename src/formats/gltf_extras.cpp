#include "formats/gltf_extras.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/byte_reader.h"
#include "formats/file_bytes.h"

namespace spinel {
namespace {

using Json = nlohmann::json;

// Those that change nothing that is read here, or that are read.
constexpr const char* UNDERSTOOD[] = {
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_materials_transmission",
    "KHR_texture_transform",
    "KHR_materials_pbrSpecularGlossiness",
};

const Json& member(const Json& object, const char* key) {
    static const Json nothing;
    if (!object.is_object()) return nothing;
    const auto found = object.find(key);
    return found == object.end() ? nothing : *found;
}

float number(const Json& object, const char* key, float otherwise) {
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

}  // namespace

Result<GltfExtras> read_gltf_extras(const std::filesystem::path& path) {
    const Result<std::string> bytes = read_file_bytes(path, std::uintmax_t(1) << 31);
    if (!bytes) return bytes.error();
    const Result<std::string_view> text = json_text(path, *bytes);
    if (!text) return text.error();
    const Json json = Json::parse(*text, nullptr, false);
    if (json.is_discarded() || !json.is_object()) return cannot_read(path, "its JSON is damaged");

    for (const Json& extension : member(json, "extensionsRequired")) {
        if (!extension.is_string()) return cannot_read(path, "extensionsRequired holds something that is no name");
        const std::string name = extension.get<std::string>();
        if (std::find(std::begin(UNDERSTOOD), std::end(UNDERSTOOD), name) == std::end(UNDERSTOOD))
            return cannot_read(path, "it requires the extension " + name + ", which is not supported");
    }

    GltfExtras extras;
    unsigned index = 0;
    for (const Json& material : member(json, "materials")) {
        const Json& extensions = member(material, "extensions");
        GltfExtras::MaterialExtras& entry = extras.materials[index++];
        entry.ior = number(member(extensions, "KHR_materials_ior"), "ior", 1.5f);
        entry.emissive_strength =
            number(member(extensions, "KHR_materials_emissive_strength"), "emissiveStrength", 1.0f);
    }
    index = 0;
    for (const Json& camera : member(json, "cameras")) {
        const float yfov = number(member(camera, "perspective"), "yfov", 0.0f);
        if (yfov > 0.0f) extras.camera_yfov[index] = yfov;
        ++index;
    }
    return extras;
}

}  // namespace spinel
