#include "geometry/mesh/mesh_builder.h"

#include <chrono>
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

// What the triangle test reads, and how much memory all that a ray may read takes.
void add_test_data(const MeshGeometry& mesh, MeshData& data) {
    const auto size = [](const auto& v) { return v.size() * sizeof(v[0]); };
    std::size_t bytes = size(data.triangles);
    if (data.triangle_test == kernels::TRIANGLE_UNIT) {
        for (const kernels::Triangle& triangle : data.triangles) data.unit_triangles.push_back(unit_triangle(triangle));
        bytes = size(data.unit_triangles);
    }
    if (data.triangle_test == kernels::TRIANGLE_INDEXED) {
        data.positions_needed = true;
        bytes = size(mesh.positions) + data.triangles.size() * sizeof(uvec3);
    }
    const bool in_blocks = (data.walk == kernels::MESH_WALK_WIDE || data.walk == kernels::MESH_WALK_COMPACT) &&
                           data.triangle_test == kernels::TRIANGLE_WATERTIGHT;
    if (in_blocks) bytes = 0;  // vertices stand in the hierarchy
    const MeshArrays& s = data.structure;
    data.statistics.bytes = bytes + size(s.nodes) + size(s.kd_nodes) + size(s.sphere_nodes) + size(s.grids) +
                            size(s.references) + size(s.wide_units);
}

}  // namespace

kernels::UnitTriangle unit_triangle(const kernels::Triangle& t) {
    const glm::dvec3 a(t.a), ab = glm::dvec3(t.b) - a, ac = glm::dvec3(t.c) - a, normal = glm::cross(ab, ac);
    const glm::dmat3 to_triangle(ab, ac, normal / std::sqrt(glm::length(normal)));
    const glm::dmat3 rows = glm::transpose(glm::inverse(to_triangle));
    const auto row = [&](int i) { return vec4(vec3(rows[i]), float(-glm::dot(rows[i], a))); };
    return {row(0), row(1), row(2)};
}

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
    if (auto r = check_size("second texture coordinates", mesh.second_uvs.size(), "vertices", vertex_count); !r)
        return r;
    if (auto r = check_size("tangents", mesh.tangents.size(), "vertices", vertex_count); !r) return r;
    if (auto r = check_size("colours", mesh.colors.size(), "vertices", vertex_count); !r) return r;
    return check_size("material slots", mesh.slots.size(), "triangles", mesh.triangles.size());
}

Result<AcceleratorChoice> choose_accelerator(const AcceleratorSettings& settings) {
    const Result<const MeshStructure*> structure = find_mesh_structure(settings.structure);
    if (!structure) return structure.error();
    const Result<const TriangleTest*> test = find_triangle_test(settings.triangle_test);
    if (!test) return test.error();
    const Result<const WidePreset*> preset = find_preset(**structure, settings.preset);
    if (!preset) return preset.error();
    return AcceleratorChoice{*structure, *test, *preset};
}

Result<MeshData> read_mesh(const MeshGeometry& mesh, const AcceleratorChoice& choice) {
    if (auto valid = validate_mesh(mesh); !valid) return valid.error();
    MeshData data;
    data.walk = choice.structure->walk;
    data.triangle_test = choice.test->test;
    data.bounds = {mesh.positions[0], mesh.positions[0]};
    for (const vec3& position : mesh.positions) {
        data.bounds.lower = glm::min(data.bounds.lower, position);
        data.bounds.upper = glm::max(data.bounds.upper, position);
    }
    data.triangles.reserve(mesh.triangles.size());
    data.infos.reserve(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const vec3 a = mesh.positions[mesh.triangles[i].x];
        const vec3 b = mesh.positions[mesh.triangles[i].y];
        const vec3 c = mesh.positions[mesh.triangles[i].z];
        const vec3 normal = glm::cross(b - a, c - a);
        if (!(glm::dot(normal, normal) > 0)) continue;  // also where the square underflows: no direction to be had
        if (data.triangles.empty()) data.triangle_bounds = {a, a};
        data.triangle_bounds.lower = glm::min(data.triangle_bounds.lower, glm::min(a, glm::min(b, c)));
        data.triangle_bounds.upper = glm::max(data.triangle_bounds.upper, glm::max(a, glm::max(b, c)));
        data.triangles.push_back({a, b, c});
        data.infos.push_back({mesh.triangles[i], mesh.slots.empty() ? 0u : mesh.slots[i], std::uint32_t(i)});
    }
    return data;
}

Result<MeshStructureData> build_structure(std::span<const kernels::Triangle> triangles,
                                          const AcceleratorChoice& choice) {
    MeshStructureData out;
    const auto start = std::chrono::steady_clock::now();
    const Result<void> built = choice.structure->build({triangles, choice.preset}, out.arrays, out.statistics);
    if (!built) return built.error();
    out.statistics.build_ms = 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return out;
}

Result<MeshData> build_mesh(const MeshGeometry& mesh, const AcceleratorSettings& accelerator) {
    const Result<AcceleratorChoice> choice = choose_accelerator(accelerator);
    if (!choice) return choice.error();
    Result<MeshData> data = read_mesh(mesh, *choice);
    if (!data || data->triangles.empty()) return data;
    Result<MeshStructureData> built = build_structure(data->triangles, *choice);
    if (!built) return built.error();
    data->structure = std::move(built->arrays);
    data->statistics = built->statistics;
    const std::vector<std::uint32_t>& order = data->structure.order;
    std::vector<kernels::Triangle> triangles;
    std::vector<kernels::TriangleInfo> infos;
    triangles.reserve(order.size());
    infos.reserve(order.size());
    for (const std::uint32_t i : order) {
        triangles.push_back(data->triangles[i]);
        infos.push_back(data->infos[i]);
    }
    data->triangles = std::move(triangles);
    data->infos = std::move(infos);
    add_test_data(mesh, *data);
    return data;
}

Result<bool> refit_mesh(const MeshGeometry& moved, const AcceleratorChoice& choice, MeshData& data) {
    Result<MeshData> read = read_mesh(moved, choice);
    if (!read) return read.error();
    const std::vector<std::uint32_t>& order = data.structure.order;
    if (!choice.structure->refit || read->infos.size() != order.size()) return false;
    if (choice.structure->walk != data.walk || choice.test->test != data.triangle_test) return false;
    std::vector<kernels::Triangle> triangles;
    triangles.reserve(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const kernels::TriangleInfo &now = read->infos[order[i]], &before = data.infos[i];
        if (now.vertices != before.vertices || now.slot != before.slot || now.primitive != before.primitive)
            return false;
        triangles.push_back(read->triangles[order[i]]);
    }
    data.triangles = std::move(triangles);
    data.bounds = read->bounds;
    data.triangle_bounds = read->triangle_bounds;
    if (!order.empty()) choice.structure->refit(data.triangles, data.structure);
    for (std::size_t i = 0; i < data.unit_triangles.size(); ++i)
        data.unit_triangles[i] = unit_triangle(data.triangles[i]);
    return true;
}

}  // namespace spinel
