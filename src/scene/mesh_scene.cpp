#include <fmt/format.h>

#include "geometry/voxels/greedy_mesh.h"
#include "kernels/materials.h"
#include "scene/convert.h"
#include "scene/validate.h"

namespace spinel {
namespace {

// What no light passes hides what is behind it, and so does more of the same.
HidesFace hides_face(const Scene& scene, const Object& object) {
    std::vector<int> materials = object.materials;
    std::vector<bool> opaque;
    for (const int m : materials) {
        if (m < 0) {
            opaque.push_back(false);
            continue;
        }
        const kernels::Material& values = scene.materials[std::size_t(m)].values;
        opaque.push_back(values.kind != kernels::MATERIAL_DIELECTRIC && values.opacity >= 1 &&
                         values.opacity_texture == kernels::NONE);
    }
    return [materials = std::move(materials), opaque = std::move(opaque)](std::uint16_t own, std::uint16_t neighbour) {
        if (neighbour == 0) return false;
        if (materials.size() <= 1) return true;
        return opaque[neighbour - 1u] || materials[own - 1u] == materials[neighbour - 1u];
    };
}

}  // namespace

Result<Scene> mesh_scene(const Scene& scene) {
    Scene out = scene;
    std::vector<bool> done(scene.geometries.size(), false);
    for (const Object& object : scene.objects) {
        const auto index = std::size_t(object.geometry);
        const Geometry& geometry = scene.geometries[index];
        if (std::holds_alternative<MeshGeometry>(geometry.data) || done[index]) continue;
        const auto* voxels = std::get_if<VoxelGeometry>(&geometry.data);
        if (!voxels)
            return Error{
                fmt::format("object '{}': a geometry of type \"{}\" becomes a mesh by way of voxels: convert it "
                            "to a file of voxels first",
                            object.name, kind_name(geometry))};
        // Objects that share a geometry share its mesh; what hides what is told by the first one's materials.
        Result<MeshGeometry> mesh = greedy_mesh(*voxels->tree, hides_face(scene, object));
        if (!mesh) return Error{fmt::format("object '{}': {}", object.name, mesh.error().message)};
        out.geometries[index].data = std::move(*mesh);
        done[index] = true;
    }
    return out;
}

}  // namespace spinel
