#include "formats/voxel_geometry.h"

namespace spinel {

Result<Geometry> voxel_geometry(std::string name, ivec3 size, std::vector<VoxelPoint> points) {
    Result<VoxelTreePointer> tree = build_voxel_tree(size, std::move(points));
    if (!tree) return tree.error();
    return Geometry{std::move(name), VoxelGeometry{std::move(*tree)}};
}

std::vector<VoxelPoint> voxel_points(const VoxelGeometry& geometry) {
    std::vector<VoxelPoint> points;
    points.reserve(std::size_t(geometry.tree->voxel_count()));
    geometry.tree->for_each([&](ivec3 cell, std::uint16_t palette) { points.push_back({cell, palette}); });
    return points;
}

}  // namespace spinel
