// What `dvr` shows: the first volume of the scene, through the transfer function that was asked for.

#include <algorithm>
#include <cmath>

#include "kernels/density.h"
#include "kernels/transfer.h"
#include "scene/compilation.h"
#include "scene/transfer.h"

namespace spinel {
namespace {

using kernels::uint;

// What the data holds, but for one in a thousand at either end: a look at no more than some hundred thousand samples.
vec2 usual_range(const kernels::SceneView& view, const kernels::DensityGrid& grid) {
    const double count = double(grid.size.x) * grid.size.y * grid.size.z;
    const int stride = std::max(1, int(std::cbrt(count / 3e5)));
    std::vector<float> values;
    for (int z = 0; z < grid.size.z; z += stride)
        for (int y = 0; y < grid.size.y; y += stride)
            for (int x = 0; x < grid.size.x; x += stride)
                values.push_back(kernels::grid_density(view, grid, vec3(ivec3(x, y, z)) + 0.5f));
    const auto part = [&](double share) {
        const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
        std::nth_element(values.begin(), at, values.end());
        return *at;
    };
    return {part(0.001), part(0.999)};
}

kernels::uint kernel_mode(DvrOptions::Mode mode) {
    switch (mode) {
        case DvrOptions::Mode::maximum: return kernels::DVR_MAXIMUM;
        case DvrOptions::Mode::average: return kernels::DVR_AVERAGE;
        case DvrOptions::Mode::isosurface: return kernels::DVR_ISOSURFACE;
        case DvrOptions::Mode::composite: break;
    }
    return kernels::DVR_COMPOSITE;
}

}  // namespace

Result<void> add_dvr(Compilation& c) {
    const DvrOptions& o = c.scene.integrator.dvr;
    kernels::DvrSettings& s = c.out.dvr;
    s.medium = kernels::NONE;
    s.mode = kernel_mode(o.mode);
    s.background = o.background;
    s.ambient = o.ambient;
    s.diffuse = o.diffuse;
    s.headlight = o.light == DvrOptions::Light::camera;
    s.to_light = c.out.preview_light.to_sun;
    for (const Object& object : c.scene.objects) {
        const auto* volume = std::get_if<VolumeGeometry>(&c.scene.geometries[std::size_t(object.geometry)].data);
        if (!volume || volume->surface) continue;
        const Result<uint> medium = add_scene_medium(c, object.interior, object.transform);
        if (!medium) return medium.error();
        if (*medium == kernels::NONE || c.out.media[*medium].grid == kernels::NONE) continue;
        s.medium = *medium;
        break;
    }
    if (s.medium == kernels::NONE) return Error{"the scene has no volume that the integrator 'dvr' could show"};
    const kernels::Medium& medium = c.out.media[s.medium];
    const kernels::DensityGrid grid = c.out.grids[medium.grid];
    const mat4x3 to_world = affine_inverse(medium.world_to_grid);
    s.voxel = std::min({glm::length(to_world[0]), glm::length(to_world[1]), glm::length(to_world[2])});
    s.step = o.step * s.voxel;
    s.iso = o.iso;
    s.iso_color = o.iso_color;
    s.shaded = o.shaded;
    s.specular = o.specular;
    s.shininess = o.shininess;
    s.shadow = o.shadow;
    s.shadow_reach = o.shadow_reach * s.voxel;
    s.clip_lower = o.clip_lower * vec3(grid.size);
    s.clip_upper = o.clip_upper * vec3(grid.size);
    s.plane_count = uint(o.clip_planes.size());
    for (std::size_t i = 0; i < o.clip_planes.size(); ++i) s.planes[i] = o.clip_planes[i];
    s.jitter = o.jitter;
    s.shortcuts = o.shortcuts;
    const vec2 usual = usual_range(c.out.view(), grid);
    const TransferTable table = transfer_table(transfer_points(o, usual.x, usual.y), o.unit * s.voxel, o.opacity);
    const Result<uint> first = append_pool(c.out.floats, table.values, NUMBERS);
    if (!first) return first.error();
    s.table_first = *first;
    s.table_size = transfer_size;
    s.low = table.low;
    s.scale = table.scale;
    return {};
}

}  // namespace spinel
