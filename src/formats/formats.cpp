#include "spinel/formats.h"

#include <algorithm>

#include "formats/anvil.h"
#include "formats/colored_voxels.h"
#include "formats/file_bytes.h"
#include "formats/heightmap.h"
#include "formats/image_stack.h"
#include "formats/mesh_assimp.h"
#include "formats/mesh_writer.h"
#include "formats/mitsuba_volume.h"
#include "formats/mts.h"
#include "formats/named_raw.h"
#include "formats/nifti.h"
#include "formats/nrrd.h"
#include "formats/nvdb.h"
#include "formats/raw_volume.h"
#include "formats/schematic.h"
#include "formats/vdb.h"
#include "formats/vox.h"
#include "formats/vox_writer.h"

namespace spinel {
namespace {

std::string lower_case(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
}

std::string extension_of(const std::filesystem::path& path) { return lower_case(path.extension().string()); }

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
        {"vox",
         {".vox"},
         "MagicaVoxel: models, scene graph, materials, light, a frame of animations",
         load_vox,
         save_vox,
         Representation::voxels,
         true},
        {"anvil", {".mca"}, "Minecraft world: a region of chunks, 1.2 and later", load_anvil, nullptr},
        {"schem", {".schem"}, "Minecraft structure: Sponge schematic, versions 1 to 3", load_sponge_schematic, nullptr},
        {"schematic", {".schematic"}, "Minecraft structure: MCEdit, numeric ids", load_mcedit_schematic, nullptr},
        {"litematic",
         {".litematic"},
         "Minecraft structure: Litematica, one or several regions",
         load_litematic,
         nullptr},
        {"structure", {".nbt"}, "Minecraft structure: the game's own", load_structure, nullptr},
        {"mts", {".mts"}, "Luanti schematic", load_mts, nullptr},
        {"qubicle", {".qb"}, "Qubicle: matrices of coloured voxels", load_qubicle, nullptr},
        {"kv6", {".kv6"}, "Voxlap and SLAB6: coloured voxels", load_kv6, nullptr},
        {"binvox", {".binvox"}, "solid voxels without colours", load_binvox, nullptr},
        {"hgt",
         {".hgt", ".hgt.gz"},
         "heights of the SRTM's tiles, as terrain of voxels",
         load_hgt,
         nullptr,
         Representation::any,
         false,
         true},
        {"heightmap",
         {".png", ".tif", ".tiff", ".exr", ".pgm"},
         "picture of heights, as terrain of voxels (--heightmap)",
         load_heightmap,
         nullptr,
         Representation::any,
         false,
         true},
        {"gltf", {".gltf", ".glb"}, "glTF 2.0: meshes, materials with textures, cameras, lights", load_gltf, nullptr},
        {"obj", {".obj"}, "Wavefront OBJ with MTL materials", load_mesh, save_obj, Representation::meshes},
        {"ply", {".ply"}, "Stanford polygons, text or binary", load_mesh, save_ply, Representation::meshes},
        {"stl", {".stl"}, "stereolithography triangles, text or binary", load_mesh, nullptr},
        {"off", {".off"}, "object file format of polygons", load_mesh, nullptr},
        {"vdb",
         {".vdb"},
         "OpenVDB: volumes of floats and vectors; sparse voxels, the value is the palette index",
         load_vdb,
         save_vdb,
         Representation::voxels,
         false,
         false,
         true,
         true},
        {"nifti",
         {".nii", ".nii.gz"},
         "NIfTI-1 and 2: scans, in their own units, oriented as the file says",
         load_nifti,
         nullptr,
         Representation::any,
         true},
        {"nvdb",
         {".nvdb"},
         "NanoVDB: volumes of floats, quantised floats and vectors",
         load_nvdb,
         nullptr,
         Representation::any,
         false,
         false,
         false,
         true},
        {"nrrd", {".nrrd", ".nhdr"}, "NRRD: scans, in their own units, raw or by gzip", load_nrrd, nullptr},
        {"metaimage", {".mha"}, "MetaImage: scans, in their own units", load_metaimage, nullptr},
        {"mitsuba", {".vol"}, "Mitsuba's volumes of floats, one or three channels", load_mitsuba_volume, nullptr},
        {"raw",
         {".raw", ".raw.gz"},
         "samples alone, size and type in the name: engine_256x256x128_uint8.raw",
         load_named_raw,
         nullptr},
        {"svol", {".svol"}, "dense volume: a text header and raw samples", load_svol, save_svol},
        {"bits", {".bits"}, "32x32x32 bit volume", load_bits, nullptr},
    };
    return table;
}

const Format* format_of(const std::filesystem::path& path) {
    const std::string name = lower_case(path.filename().string());
    const Format* best = nullptr;
    std::size_t longest = 0;
    for (const Format& format : formats()) {
        for (const std::string_view extension : format.extensions) {
            if (name.size() <= extension.size() || extension.size() <= longest || !name.ends_with(extension)) continue;
            best = &format;
            longest = extension.size();
        }
    }
    return best;
}

Result<Scene> load_model(const std::filesystem::path& path, const LoadOptions& options) {
    if (options.fps > 0) return cannot_read(path, "--fps is of a scene file's \"animation\"; a model has none");
    if (is_image_stack(path)) return load_image_stack(path);
    if (const Format* format = format_of(path)) {
        if (options.frame && !format->animated)
            return cannot_read(path,
                               "files of the format " + std::string(format->name) + " have no frames to choose from");
        if (options.heightmap && !format->heights)
            return cannot_read(path, "files of the format " + std::string(format->name) + " hold no heights");
        if (options.voxels && !format->volumes)
            return cannot_read(path, "files of the format " + std::string(format->name) +
                                         " need no --voxels: `spinel convert` makes voxels of meshes and volumes");
        if (!options.grid.empty() && !format->grids)
            return cannot_read(path,
                               "files of the format " + std::string(format->name) + " have no grids to choose from");
        return format->load(path, options);
    }
    std::error_code unread;
    if (extension_of(path).empty() && !std::filesystem::exists(path, unread))
        return cannot_read(path, "there is no such file");
    return cannot_read(path, "unknown extension '" + extension_of(path) +
                                 "'; readable: " + extension_list([](const Format&) { return true; }));
}

Result<Notes> save_model(const Scene& scene, const std::filesystem::path& path) {
    const Format* format = format_of(path);
    if (format && format->save) return format->save(scene, path);
    return Error{"cannot write '" + path.string() + "': unknown extension '" + extension_of(path) +
                 "'; writable: " + extension_list([](const Format& row) { return row.save != nullptr; })};
}

}  // namespace spinel
