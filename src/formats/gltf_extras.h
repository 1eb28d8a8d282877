#pragma once
// What a glTF 2.0 file says that Assimp 5.2 does not hand on, read from the file's own JSON.

#include <filesystem>
#include <map>

#include "core/result.h"

namespace spinel {

struct GltfExtras {
    struct MaterialExtras {
        float ior = 1.5f;                // KHR_materials_ior
        float emissive_strength = 1.0f;  // KHR_materials_emissive_strength
    };
    std::map<unsigned, MaterialExtras> materials;  // by the file's index; absent: the defaults
    std::map<unsigned, float> camera_yfov;         // of perspective cameras, radians, by the file's index
};

// Fails with the extension's name where the file requires one that would be needed to read it right.
Result<GltfExtras> read_gltf_extras(const std::filesystem::path& path);

}  // namespace spinel
