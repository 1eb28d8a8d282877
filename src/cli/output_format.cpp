#include "cli/output_format.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace spinel::cli {

Result<const Format*> output_format(const std::string& path, bool voxels) {
    const Format* format = format_of(path);
    const auto writes = [&](const Format& row) {
        return row.save != nullptr && (!voxels || row.saves == Representation::voxels);
    };
    if (format && writes(*format)) return format;
    std::string list;
    for (const Format& row : formats())
        if (writes(row)) list += fmt::format("{}{}", list.empty() ? "" : ", ", row.extensions[0]);
    return Error{fmt::format("-o '{}': {} written as {}", path, voxels ? "voxels are" : "models are", list)};
}

void report_saved(const Scene& scene, const Notes& left_out, const std::string& path, double seconds,
                  const CommonOptions& common) {
    std::uint64_t voxels = 0, triangles = 0;
    VoxelTreeMemory memory;
    ivec3 size(0);
    for (const Geometry& geometry : scene.geometries) {
        if (const auto* mesh = std::get_if<MeshGeometry>(&geometry.data)) triangles += mesh->triangles.size();
        const auto* set = std::get_if<VoxelGeometry>(&geometry.data);
        if (!set) continue;
        const VoxelTreeMemory m = set->tree->memory();
        voxels += set->tree->voxel_count();
        memory.node_bytes += m.node_bytes + m.reference_bytes;
        memory.palette_bytes += m.palette_bytes;
        size = glm::max(size, set->tree->size());
    }
    for (const std::string& note : scene.notes)
        if (!common.quiet) fmt::print(stderr, "{}: {}\n", path, note);
    for (const std::string& note : left_out)
        if (!common.quiet) fmt::print(stderr, "spinel: warning: {}: {}\n", path, note);
    if (common.json) {
        const nlohmann::ordered_json json = {{"output", path},
                                             {"size", {size.x, size.y, size.z}},
                                             {"voxels", voxels},
                                             {"triangles", triangles},
                                             {"materials", scene.materials.size()},
                                             {"tree_bytes", memory.node_bytes},
                                             {"palette_bytes", memory.palette_bytes},
                                             {"left_out", left_out},
                                             {"seconds", seconds}};
        fmt::print("{}\n", json_text(json, -1));
    } else if (!common.quiet) {
        std::string what;
        if (voxels > 0) what += fmt::format("{} voxels in {}x{}x{}, ", voxels, size.x, size.y, size.z);
        if (triangles > 0) what += fmt::format("{} triangles, ", triangles);
        fmt::print(stderr, "{}: {}{} materials, made in {:.2f} s\n", path, what, scene.materials.size(), seconds);
    }
}

}  // namespace spinel::cli
