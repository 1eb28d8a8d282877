#include "geometry/voxels/voxelise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/parallel.h"

namespace spinel {
namespace {

using glm::dvec2;
using glm::dvec3;

// Triangle against unit cells: the plane must cut the cell, and in each of the three projections every edge must leave
// part of it inside. Schwarz, Seidel, "Fast Parallel Surface and Solid Voxelization on GPUs", SIGGRAPH Asia 2010.
// Widened by far more than the rounding of doubles and far less than a cell, so that what merely touches counts.
class TriangleOverlap {
  public:
    TriangleOverlap(const dvec3& a, const dvec3& b, const dvec3& c) : normal_(glm::cross(b - a, c - a)) {
        const double length = glm::length(normal_);
        if (length > 0) normal_ /= length;
        dvec3 far_corner, near_corner;
        for (int i = 0; i < 3; ++i) {
            far_corner[i] = normal_[i] > 0 ? 1 : 0;
            near_corner[i] = 1 - far_corner[i];
        }
        upper_ = glm::dot(normal_, far_corner - a) + slack;
        lower_ = glm::dot(normal_, near_corner - a) - slack;
        const dvec3 vertices[3] = {a, b, c};
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            const double sign = normal_[axis] >= 0 ? 1 : -1;
            for (int i = 0; i < 3; ++i) {
                const dvec3 from = vertices[i], edge = vertices[(i + 1) % 3] - from;
                dvec2 n = sign * dvec2(-edge[v], edge[u]);
                const double size = glm::length(n);
                if (size > 0) n /= size;
                edges_[axis][i] = {
                    n, -glm::dot(n, dvec2(from[u], from[v])) + std::max(0.0, n.x) + std::max(0.0, n.y) + slack};
            }
        }
    }
    bool meets(ivec3 cell) const {
        const dvec3 p(cell);
        const double d = glm::dot(normal_, p);
        if (d + upper_ < 0 || d + lower_ > 0) return false;
        for (int axis = 0; axis < 3; ++axis) {
            const dvec2 q(p[(axis + 1) % 3], p[(axis + 2) % 3]);
            for (const Edge& edge : edges_[axis])
                if (glm::dot(edge.normal, q) + edge.offset < 0) return false;
        }
        return true;
    }

  private:
    static constexpr double slack = 1e-7;
    struct Edge {
        dvec2 normal;
        double offset;
    };
    dvec3 normal_;
    double lower_, upper_;
    Edge edges_[3][3];
};

}  // namespace

Result<VoxelisedMesh> voxelise_surface(const MeshGeometry& mesh, int resolution, const VoxelTreeOptions& options) {
    if (resolution < 1 || resolution > VoxelTree::max_edge)
        return Error{"a mesh cannot be voxelised at " + std::to_string(resolution) + " cells an edge; allowed: 1 … " +
                     std::to_string(VoxelTree::max_edge)};
    for (const std::uint32_t slot : mesh.slots)
        if (slot >= 65535)
            return Error{"a mesh with material slot " + std::to_string(slot) + " cannot be voxelised: at most 65534"};
    dvec3 lower(std::numeric_limits<double>::infinity()), upper = -lower;
    for (const uvec3& triangle : mesh.triangles)
        for (int i = 0; i < 3; ++i) {
            lower = glm::min(lower, dvec3(mesh.positions[triangle[i]]));
            upper = glm::max(upper, dvec3(mesh.positions[triangle[i]]));
        }
    const dvec3 extent = upper - lower;
    const double longest = std::max({extent.x, extent.y, extent.z});
    if (!(longest > 0 && std::isfinite(longest))) return Error{"a mesh without extent cannot be voxelised"};
    const double scale = resolution / longest;
    const ivec3 size = glm::clamp(ivec3(glm::ceil(extent * scale - 1e-6)), ivec3(1), ivec3(resolution));

    constexpr std::size_t batch = 1024;
    std::vector<std::vector<VoxelPoint>> found((mesh.triangles.size() + batch - 1) / batch);
    parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin * batch; i < std::min(end * batch, mesh.triangles.size()); ++i) {
            dvec3 v[3];
            for (int k = 0; k < 3; ++k) v[k] = (dvec3(mesh.positions[mesh.triangles[i][k]]) - lower) * scale;
            const TriangleOverlap overlap(v[0], v[1], v[2]);
            const auto palette = std::uint16_t(mesh.slots.empty() ? 1 : mesh.slots[i] + 1);
            const ivec3 last = size - 1;
            const ivec3 from =
                glm::clamp(ivec3(glm::floor(glm::min(v[0], glm::min(v[1], v[2])) - 1e-7)), ivec3(0), last);
            const ivec3 to = glm::clamp(ivec3(glm::floor(glm::max(v[0], glm::max(v[1], v[2])) + 1e-7)), ivec3(0), last);
            for (int z = from.z; z <= to.z; ++z)
                for (int y = from.y; y <= to.y; ++y)
                    for (int x = from.x; x <= to.x; ++x)
                        if (overlap.meets({x, y, z})) found[i / batch].push_back({{x, y, z}, palette});
        }
    });
    std::vector<VoxelPoint> points;
    for (std::vector<VoxelPoint>& part : found) {
        points.insert(points.end(), part.begin(), part.end());
        part = {};
    }
    Result<VoxelTreePointer> tree = build_voxel_tree(size, std::move(points), options);
    if (!tree) return tree.error();
    const float cell = float(1 / scale);
    return VoxelisedMesh{*tree, mat4x3(vec3(cell, 0, 0), vec3(0, cell, 0), vec3(0, 0, cell), vec3(lower))};
}

}  // namespace spinel
