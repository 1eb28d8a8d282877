#pragma once
// The plain 3D-DDA over a dense grid of voxels: every cell is visited. It is what the walk over the sparse tree
// (kernels/voxels.h) has to equal bit for bit, and the baseline that benchmarks compare with.

#include <cstdint>
#include <vector>

#include "kernels/voxels.h"
#include "spinel/voxels.h"

namespace spinel {

struct DenseVoxels {
    ivec3 size;
    std::vector<std::uint8_t> cells;  // palette indices, x fastest, then y, then z
};

// Of a tree whose palette indices fit a byte.
inline DenseVoxels dense_voxels(const VoxelTree& tree) {
    const glm::u64vec3 size(tree.size());
    DenseVoxels dense{tree.size(), std::vector<std::uint8_t>(size.x * size.y * size.z, 0)};
    tree.for_each([&](ivec3 cell, std::uint16_t palette) {
        dense.cells[std::size_t(cell.x) + size.x * (std::size_t(cell.y) + size.y * std::size_t(cell.z))] =
            std::uint8_t(palette);
    });
    return dense;
}

// As kernels::voxels_closest.
inline void dense_closest(const kernels::SceneView& scene, const DenseVoxels& grid, kernels::uint slot_first,
                          const kernels::Ray& ray, kernels::Hit& hit) {
    using namespace kernels;
    const ivec3 size = grid.size;
    const VoxelRay r = voxel_ray(size, ray);
    if (!(r.enter < r.leave) || r.enter >= hit.t) return;
    ivec3 cell = voxel_first_cell(size, ray, r);
    const std::ptrdiff_t strides[3] = {1, size.x, std::ptrdiff_t(size.x) * size.y};
    std::ptrdiff_t index = cell.x + strides[1] * cell.y + strides[2] * cell.z;
    std::uint8_t palette = grid.cells[std::size_t(index)];
    const uint medium = voxel_class(scene, slot_first, palette);
    if (voxel_first_hit(ray, r, cell, palette, medium, hit)) return;

    const auto plane = [&](int axis) {
        return r.still[axis] ? INFINITE : voxel_plane(cell[axis] + r.positive[axis], ray.origin[axis], r.inverse[axis]);
    };
    vec3 next(plane(0), plane(1), plane(2));
    for (;;) {  // ends: each step leaves a cell for good along one axis
        const int axis = next.x <= next.y && next.x <= next.z ? 0 : next.y <= next.z ? 1 : 2;
        const float t = next[axis];
        if (t >= hit.t) return;
        const ivec3 left = cell;
        const int step = 2 * r.positive[axis] - 1;
        cell[axis] += step;
        index += step * strides[axis];
        next[axis] = plane(axis);
        const bool inside = cell[axis] >= 0 && cell[axis] < size[axis];
        const std::uint8_t entered_palette = inside ? grid.cells[std::size_t(index)] : std::uint8_t(0);
        if (entered_palette != palette) {
            const uint entered = voxel_class(scene, slot_first, entered_palette);
            if (entered != medium) {
                const bool forward = step > 0;
                if (entered == VOXEL_AIR) voxel_hit(ray, t, left, palette, uint(axis), forward, hit);
                else voxel_hit(ray, t, cell, entered_palette, uint(axis), !forward, hit);
                return;
            }
            palette = entered_palette;
        }
        if (!inside) return;
    }
}

}  // namespace spinel
