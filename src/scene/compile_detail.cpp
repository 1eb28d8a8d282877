// How fine a voxel set has to be: finer than `level_of_detail` pixels of the picture is not kept where all is opaque.
// The set itself is made coarser before anything is built of it, so rays of every kind and every device meet the same.

#include <algorithm>
#include <cmath>

#include "geometry/voxels/voxel_detail.h"
#include "kernels/materials.h"
#include "scene/compilation.h"

namespace spinel {
namespace {

// Edge of a pixel at a distance from the camera, at least.
float pixel_edge(const kernels::Camera& camera, float distance) {
    const float edge = 2 * camera.half_height / float(camera.resolution.y);
    if (camera.kind == kernels::CAMERA_ORTHOGRAPHIC) return edge;
    // Depth along the axis is what counts; in the picture's corner it is the least part of a distance.
    const float aspect = float(camera.resolution.x) / float(camera.resolution.y);
    const float corner = camera.half_height * std::sqrt(1 + aspect * aspect);
    return edge * std::max(distance - camera.lens_radius, 0.0f) / std::sqrt(1 + corner * corner);
}

float distance_to_box(const Box& box, vec3 p) {
    return glm::length(glm::max(glm::max(box.lower - p, p - box.upper), vec3(0)));
}

// Opaque for every object that is made of the set, and dark: glass and lamps would change with their size.
bool is_plain(const Scene& scene, const std::vector<const Object*>& objects, std::uint16_t palette) {
    for (const Object* object : objects) {
        if (object->interior >= 0 || object->materials.empty()) return false;
        const int material = object->materials.size() == 1 ? object->materials[0] : object->materials[palette - 1u];
        if (material < 0) return false;
        const kernels::Material& m = scene.materials[std::size_t(material)].values;
        if (m.kind == kernels::MATERIAL_DIELECTRIC || m.interior != kernels::NONE || m.opacity < 1 ||
            m.opacity_texture != kernels::NONE || !kernels::is_black(m.emission))
            return false;
    }
    return true;
}

}  // namespace

VoxelTreePointer detailed_voxels(const Scene& scene, std::size_t geometry, const kernels::Camera* camera) {
    const VoxelGeometry& voxels = std::get<VoxelGeometry>(scene.geometries[geometry].data);
    if (!(voxels.level_of_detail > 0) || !camera) return voxels.tree;
    std::vector<const Object*> objects;
    std::vector<float> stretches;  // of a cell's longest edge
    for (const Object& object : scene.objects) {
        if (object.geometry != int(geometry)) continue;
        objects.push_back(&object);
        const mat4x3& m = object.transform;
        stretches.push_back(std::max({glm::length(m[0]), glm::length(m[1]), glm::length(m[2])}));
    }
    std::vector<bool> plain(std::size_t(voxels.tree->palette_maximum()) + 1, false);
    for (std::size_t p = 1; p < plain.size(); ++p) plain[p] = is_plain(scene, objects, std::uint16_t(p));
    const vec3 eye = camera->camera_to_world[3];
    const auto coarse = [&](ivec3 lower, int edge) {
        for (std::size_t i = 0; i < objects.size(); ++i) {
            const Box box = world_bounds(objects[i]->transform, vec3(lower), vec3(lower + edge));
            if (!(float(edge) * stretches[i] < voxels.level_of_detail * pixel_edge(*camera, distance_to_box(box, eye))))
                return false;
        }
        return true;
    };
    return with_less_detail(*voxels.tree, {coarse, [&](std::uint16_t p) { return bool(plain[p]); }});
}

}  // namespace spinel
