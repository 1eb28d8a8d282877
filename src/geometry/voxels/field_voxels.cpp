#include "geometry/voxels/field_voxels.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "kernels/sdf.h"

namespace spinel {
namespace {

using glm::dmat3;
using glm::dmat4x3;
using glm::dvec3;

// Half the longest diagonal of the parallelepiped that a cube of edge 1 becomes.
double half_diagonal(const dmat4x3& m) {
    double longest = 0;
    for (int i = 0; i < 4; ++i)
        longest = std::max(longest, glm::length(m[0] + (i & 1 ? 1.0 : -1.0) * m[1] + (i & 2 ? 1.0 : -1.0) * m[2]));
    return 0.5 * longest;
}

dvec3 transformed(const dmat4x3& m, dvec3 p) { return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3]; }

// From cells to the object.
dmat4x3 cells_to_object(const VoxelFrame& frame, const mat4x3& world_to_object) {
    const dmat4x3 m(world_to_object);
    return dmat4x3(m[0] * frame.cell, m[1] * frame.cell, m[2] * frame.cell, transformed(m, frame.origin));
}

}  // namespace

VoxelFunction sdf_voxels(const SdfData& data, const VoxelFrame& frame, const mat4x3& world_to_object,
                         std::uint16_t palette) {
    const dmat4x3 to_object = cells_to_object(frame, world_to_object);
    const double reach = half_diagonal(to_object) * double(data.sdf.lipschitz);
    const dvec3 lower(data.sdf.lower), upper(data.sdf.upper);
    kernels::SceneView view = {};
    view.sdf_ops.at = data.ops.data();
    view.sdfs.at = &data.sdf;
    const auto at = [=](ivec3 cell) {
        const dvec3 p = transformed(to_object, dvec3(cell) + 0.5);
        if (glm::any(glm::lessThan(p, lower)) || glm::any(glm::greaterThan(p, upper))) return std::uint16_t(0);
        return kernels::sdf_distance(view, 0, vec3(p)) < 0 ? palette : std::uint16_t(0);
    };
    const auto box = [=](ivec3 first, ivec3 last) -> std::optional<std::uint16_t> {
        const ivec3 extent = last - first;
        const double edge = std::max({extent.x, extent.y, extent.z});
        const dvec3 centre = transformed(to_object, dvec3(first) + 0.5 * edge);
        dvec3 half(0);
        for (int i = 0; i < 3; ++i) half += 0.5 * edge * glm::abs(to_object[i]);
        if (glm::any(glm::lessThan(centre + half, lower)) || glm::any(glm::greaterThan(centre - half, upper)))
            return std::uint16_t(0);
        // Beyond the bounds neither is f what it should be, nor its slope.
        if (glm::any(glm::lessThan(centre - half, lower)) || glm::any(glm::greaterThan(centre + half, upper)))
            return std::nullopt;
        const double f = kernels::sdf_distance(view, 0, vec3(centre));
        // The tape computes in floats: a little more than the bound.
        if (!(std::abs(f) > 1.0001 * reach * edge + 1e-5 * glm::length(centre))) return std::nullopt;
        return f < 0 ? palette : std::uint16_t(0);
    };
    return {at, box};
}

namespace {

// Cells at whose centre the grid's linear or nearest value is what `solid` accepts.
template <class Solid>
VoxelFunction cells_where(const Grid& grid, const VoxelFrame& frame, const mat4x3& world_to_object,
                          std::uint16_t palette, const Solid& solid) {
    const glm::dmat4 to_index = glm::inverse(glm::dmat4(glm::mat4(grid.index_to_local)));
    const dmat4x3 to_object = cells_to_object(frame, world_to_object);
    dmat4x3 to_grid;
    for (int i = 0; i < 4; ++i) to_grid[i] = dvec3(to_index * glm::dvec4(to_object[i], i == 3 ? 1 : 0));
    const auto value = [&grid](ivec3 i) {
        return double(grid.samples->at(glm::clamp(i, ivec3(0), grid.samples->size() - 1)));
    };
    const auto at = [=, &grid](ivec3 cell) {
        const dvec3 p = transformed(to_grid, dvec3(cell) + 0.5);
        if (glm::any(glm::lessThan(p, dvec3(0))) || glm::any(glm::greaterThanEqual(p, dvec3(grid.samples->size()))))
            return std::uint16_t(0);
        if (grid.filter == Filter::nearest) return solid(value(ivec3(p))) ? palette : std::uint16_t(0);
        const dvec3 q = p - 0.5, base = glm::floor(q), w = q - base;
        double sum = 0;
        for (int i = 0; i < 8; ++i) {
            const ivec3 corner(i & 1, i >> 1 & 1, i >> 2);
            const dvec3 part = glm::mix(1.0 - w, w, dvec3(corner));
            sum += part.x * part.y * part.z * value(ivec3(base) + corner);
        }
        return solid(sum) ? palette : std::uint16_t(0);
    };
    return {at, {}};
}

}  // namespace

VoxelFunction volume_voxels(const Grid& grid, const VoxelFrame& frame, const mat4x3& world_to_object, float threshold,
                            std::uint16_t palette) {
    return cells_where(grid, frame, world_to_object, palette, [=](double value) { return value >= double(threshold); });
}

VoxelFunction solid_voxels(const Grid& grid, const VoxelFrame& frame, const mat4x3& world_to_object, float level,
                           bool above, std::uint16_t palette) {
    return cells_where(grid, frame, world_to_object, palette,
                       [=](double value) { return above ? value > double(level) : value < double(level); });
}

}  // namespace spinel
