#pragma once
// What a glTF 2.0 file says that Assimp 5.2 does not hand on, or not exactly, read from the file's own JSON.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

// How a material uses a picture; v grows upwards, as in ImageTexture.
struct GltfTexturePlace {
    unsigned uv_set = 0;
    vec2 scale = {1, 1};
    float rotation = 0;  // degrees
    vec2 offset = {0, 0};
};

struct GltfExtras {
    struct MaterialExtras {
        float ior = 1.5f;                                  // KHR_materials_ior, by which light is bent
        bool reflects_all = false;                         // … 0, which bends as the default does, but reflects all
        float specular = 1;                                // KHR_materials_specular: factor of F0
        float reflection_ior = 1.5f;                       // index of F0 with both of these, at most 3
        float emissive_strength = 1.0f;                    // KHR_materials_emissive_strength
        bool unlit = false;                                // KHR_materials_unlit
        float coat = 0, coat_roughness = 0;                // KHR_materials_clearcoat
        float transmission = 0;                            // KHR_materials_transmission
        float thickness = 0;                               // KHR_materials_volume; 0: a thin wall
        float attenuation_distance = 0;                    // … 0: nothing is absorbed
        vec3 attenuation_color = {1, 1, 1};                // … of white light after that distance
        std::map<std::string, GltfTexturePlace> textures;  // by their keys: "baseColorTexture"
        const GltfTexturePlace* texture(const char* key) const {
            const auto found = textures.find(key);
            return found == textures.end() ? nullptr : &found->second;
        }
    };
    struct CameraExtras {
        float yfov = 0;  // radians, of a perspective camera
        float ymag = 0;  // half the height of the picture, of an orthographic one
    };
    std::map<unsigned, MaterialExtras> materials;  // by the file's index; absent: the defaults
    std::vector<CameraExtras> cameras;
    std::vector<std::string> notes;  // what the file has that is left out
};

// Fails with the extension's name where the file requires one that would be needed to read it right.
Result<GltfExtras> read_gltf_extras(const std::filesystem::path& path);

}  // namespace spinel
