#include "scene/merge.h"

#include <iterator>

#include "scene/material_registry.h"

namespace spinel {
namespace {

template <class T>
void append(std::vector<T>& to, std::vector<T>& from) {
    to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

void shift(kernels::uint& index, std::size_t by) {
    if (index != kernels::NONE) index += kernels::uint(by);
}

void shift(int& index, std::size_t by) {
    if (index >= 0) index += int(by);
}

}  // namespace

std::vector<Object> merge_model(Scene& scene, Scene model) {
    for (Material& material : model.materials) {
        kernels::Material& m = material.values;
        for (const auto member : material_texture_members) shift(m.*member, scene.textures.size());
        shift(m.interior, scene.media.size());
    }
    for (Medium& medium : model.media)
        for (int* grid : {&medium.grid, &medium.albedo, &medium.temperature}) shift(*grid, scene.grids.size());
    for (Geometry& geometry : model.geometries)
        if (auto* volume = std::get_if<VolumeGeometry>(&geometry.data)) shift(volume->grid, scene.grids.size());
    for (Object& object : model.objects) {
        shift(object.geometry, scene.geometries.size());
        for (int& material : object.materials) shift(material, scene.materials.size());
        shift(object.interior, scene.media.size());
    }
    append(scene.textures, model.textures);
    append(scene.materials, model.materials);
    append(scene.grids, model.grids);
    append(scene.media, model.media);
    append(scene.geometries, model.geometries);
    append(scene.notes, model.notes);
    return std::move(model.objects);
}

mat4x3 compose(const mat4x3& a, const mat4x3& b) {
    const mat3 linear = mat3(a[0], a[1], a[2]);
    return mat4x3(linear * b[0], linear * b[1], linear * b[2], linear * b[3] + a[3]);
}

}  // namespace spinel
