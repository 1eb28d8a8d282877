#include "geometry/mesh/mesh_builder.h"

#include <cmath>
#include <cstddef>
#include <string>

namespace spinel {
namespace {

bool is_finite(const vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

Result<void> check_size(const char* name, std::size_t size, const char* unit, std::size_t expected) {
    if (size == 0 || size == expected) return {};
    return Error{"mesh has " + std::to_string(size) + " " + name + " for " + std::to_string(expected) + " " + unit +
                 "; allowed: none, or one for each"};
}

}  // namespace

Result<void> validate_mesh(const MeshGeometry& mesh) {
    const std::size_t vertex_count = mesh.positions.size();
    if (mesh.triangles.empty()) return Error{"mesh has no triangles"};
    if (vertex_count > kernels::NONE || mesh.triangles.size() > kernels::BVH_MAX_PRIMITIVES) {
        return Error{"mesh is too large: at most " + std::to_string(kernels::BVH_MAX_PRIMITIVES) + " triangles"};
    }
    for (std::size_t i = 0; i < vertex_count; ++i) {
        if (!is_finite(mesh.positions[i]))
            return Error{"mesh vertex " + std::to_string(i) + " has a position that is not finite"};
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        for (int corner = 0; corner < 3; ++corner) {
            const std::uint32_t vertex = mesh.triangles[i][corner];
            if (vertex < vertex_count) continue;
            return Error{"mesh triangle " + std::to_string(i) + " refers to vertex " + std::to_string(vertex) +
                         ", but there are only " + std::to_string(vertex_count)};
        }
    }
    if (auto r = check_size("normals", mesh.normals.size(), "vertices", vertex_count); !r) return r;
    if (auto r = check_size("texture coordinates", mesh.uvs.size(), "vertices", vertex_count); !r) return r;
    if (auto r = check_size("tangents", mesh.tangents.size(), "vertices", vertex_count); !r) return r;
    if (auto r = check_size("colours", mesh.colors.size(), "vertices", vertex_count); !r) return r;
    return check_size("material slots", mesh.slots.size(), "triangles", mesh.triangles.size());
}

Result<MeshData> build_mesh(const MeshGeometry& mesh, const BvhOptions& options) {
    if (auto valid = validate_mesh(mesh); !valid) return valid.error();
    MeshData data;

    std::vector<std::uint32_t> kept;  // triangles with an area
    std::vector<Box> boxes;
    kept.reserve(mesh.triangles.size());
    boxes.reserve(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const vec3 a = mesh.positions[mesh.triangles[i].x];
        const vec3 b = mesh.positions[mesh.triangles[i].y];
        const vec3 c = mesh.positions[mesh.triangles[i].z];
        const vec3 normal = glm::cross(b - a, c - a);
        if (!(glm::dot(normal, normal) > 0)) continue;  // also where the square underflows: no direction to be had
        kept.push_back(static_cast<std::uint32_t>(i));
        boxes.push_back({glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))});
    }

    Bvh bvh = build_bvh(boxes, options);
    data.nodes = std::move(bvh.nodes);
    data.statistics = bvh.statistics;
    data.triangles.reserve(kept.size());
    data.infos.reserve(kept.size());
    for (const std::uint32_t box : bvh.order) {
        const std::uint32_t primitive = kept[box];
        const uvec3 vertices = mesh.triangles[primitive];
        data.triangles.push_back({mesh.positions[vertices.x], mesh.positions[vertices.y], mesh.positions[vertices.z]});
        data.infos.push_back({vertices, mesh.slots.empty() ? 0u : mesh.slots[primitive], primitive});
    }

    data.bounds = {mesh.positions[0], mesh.positions[0]};
    for (const vec3& position : mesh.positions) {
        data.bounds.lower = glm::min(data.bounds.lower, position);
        data.bounds.upper = glm::max(data.bounds.upper, position);
    }
    return data;
}

}  // namespace spinel
