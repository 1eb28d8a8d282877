#include "formats/volume_scene.h"

#include <algorithm>
#include <set>

#include "geometry/volume/level_set_fog.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel {

Scene volume_scene(std::vector<Grid> grids, const BareVolume& look) {
    Scene scene;
    for (Grid& grid : grids) {
        const int index = int(scene.grids.size());
        Object object;
        object.name = grid.name;
        object.geometry = index;
        object.materials = {-1};
        // What is nowhere inside, or flat, has no surface.
        if (grid.level_set && (!(grid.samples->minimum() < 0) || glm::any(glm::equal(grid.samples->size(), ivec3(1)))))
            grid = fog_of_level_set(grid);
        if (grid.level_set) {
            // A B-spline has no edges between samples that a highlight would show.
            grid.filter = Filter::cubic;
            object.materials = {int(scene.materials.size())};
            scene.materials.push_back({grid.name, default_material(kernels::MATERIAL_DIFFUSE)});
        } else if (grid.samples->channels() == 1) {
            const vec3 size(grid.samples->size());
            float longest = 0;
            for (int axis = 0; axis < 3; ++axis)
                longest = std::max(longest, glm::length(grid.index_to_local[axis]) * size[axis]);
            Medium medium;
            medium.name = grid.name;
            medium.scattering = vec3(look.optical_depth / longest);
            medium.absorption = vec3(0.01f * look.optical_depth / longest);
            medium.grid = index;
            medium.density_range = look.density_range;
            object.interior = int(scene.media.size());
            scene.media.push_back(std::move(medium));
        }
        scene.geometries.push_back({grid.name, VolumeGeometry{.grid = index, .surface = grid.level_set}});
        scene.objects.push_back(std::move(object));
        scene.grids.push_back(std::move(grid));
    }
    return scene;
}

BareVolume look_of_scan(const Grid& grid) {
    const float low = grid.samples->minimum(), high = grid.samples->maximum();
    if (!(low < high)) return {{low - 1, low}, 10};
    return {{low + 0.2f * (high - low), high}, 60};
}

void tell_apart(std::vector<Grid>& grids) {
    std::set<std::string> known;
    for (Grid& grid : grids) {
        std::string name = grid.name;
        for (int i = 1; !known.insert(name).second; ++i) name = grid.name + "[" + std::to_string(i) + "]";
        grid.name = name;
    }
}

}  // namespace spinel
