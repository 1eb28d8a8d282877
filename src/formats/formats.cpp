#include "spinel/formats.h"

#include <algorithm>

#include "formats/file_bytes.h"
#include "formats/mesh_assimp.h"
#include "formats/raw_volume.h"
#include "formats/vox.h"

namespace spinel {
namespace {

std::string lower_case_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    return extension;
}

template <class Keep>
std::string extension_list(Keep keep) {
    std::string list;
    for (const Format& format : formats()) {
        if (!keep(format)) continue;
        for (const std::string_view extension : format.extensions) {
            if (!list.empty()) list += ", ";
            list += extension;
        }
    }
    return list;
}

}  // namespace

std::span<const Format> formats() {
    static const Format table[] = {
        {"vox", {".vox"}, "MagicaVoxel: models, scene graph, palette and materials", load_vox, nullptr},
        {"gltf", {".gltf", ".glb"}, "glTF 2.0: meshes, materials with textures, cameras, lights", load_gltf, nullptr},
        {"obj", {".obj"}, "Wavefront OBJ with MTL materials", load_mesh, nullptr},
        {"ply", {".ply"}, "Stanford polygons, text or binary", load_mesh, nullptr},
        {"stl", {".stl"}, "stereolithography triangles, text or binary", load_mesh, nullptr},
        {"off", {".off"}, "object file format of polygons", load_mesh, nullptr},
        {"svol", {".svol"}, "dense volume: a text header and raw samples", load_svol, save_svol},
        {"bits", {".bits"}, "32x32x32 bit volume", load_bits, nullptr},
    };
    return table;
}

const Format* format_of(const std::filesystem::path& path) {
    const std::string extension = lower_case_extension(path);
    for (const Format& format : formats()) {
        if (std::find(format.extensions.begin(), format.extensions.end(), extension) != format.extensions.end())
            return &format;
    }
    return nullptr;
}

Result<Scene> load_model(const std::filesystem::path& path) {
    if (const Format* format = format_of(path)) return format->load(path);
    return cannot_read(path, "unknown extension '" + lower_case_extension(path) +
                                 "'; readable: " + extension_list([](const Format&) { return true; }));
}

Result<void> save_model(const Scene& scene, const std::filesystem::path& path) {
    const Format* format = format_of(path);
    if (format && format->save) return format->save(scene, path);
    return Error{"cannot write '" + path.string() + "': unknown extension '" + lower_case_extension(path) +
                 "'; writable: " + extension_list([](const Format& row) { return row.save != nullptr; })};
}

}  // namespace spinel
