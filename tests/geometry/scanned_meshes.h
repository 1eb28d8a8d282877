#pragma once
// Meshes of scanners and modellers, from shared/data beside the source tree, for tests that skip without them.

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel::test {

inline const std::filesystem::path mesh_folder = SPINEL_SOURCE_DIR "/../shared/data/mesh";

// An ASCII .ply.gz of Stanford's: vertices x y z first, then faces of three.
inline std::optional<MeshGeometry> read_gzipped_ply(const std::filesystem::path& path) {
    if (!std::filesystem::exists(path)) return {};
    FILE* pipe = popen(("gzip -dc '" + path.string() + "'").c_str(), "r");
    if (!pipe) return {};
    MeshGeometry mesh;
    char line[512];
    std::size_t vertices = 0, faces = 0;
    while (std::fgets(line, sizeof line, pipe) && std::strncmp(line, "end_header", 10) != 0) {
        std::sscanf(line, "element vertex %zu", &vertices);
        std::sscanf(line, "element face %zu", &faces);
    }
    for (std::size_t i = 0; i < vertices && std::fgets(line, sizeof line, pipe); ++i) {
        vec3 p(0);
        std::sscanf(line, "%f %f %f", &p.x, &p.y, &p.z);
        mesh.positions.push_back(p);
    }
    for (std::size_t i = 0; i < faces && std::fgets(line, sizeof line, pipe); ++i) {
        uvec3 t(0);
        std::sscanf(line, "3 %u %u %u", &t.x, &t.y, &t.z);
        mesh.triangles.push_back(t);
    }
    pclose(pipe);
    return mesh;
}

// The first mesh of a file of any other format.
inline std::optional<MeshGeometry> read_mesh(const std::filesystem::path& path) {
    if (!std::filesystem::exists(path)) return {};
    const Result<Scene> scene = load_model(path.string());
    if (!scene) return {};
    for (const Geometry& geometry : scene->geometries)
        if (const auto* mesh = std::get_if<MeshGeometry>(&geometry.data)) return *mesh;
    return {};
}

// The same surface without a hole: vertices in one place are one, and every edge that lacks its opposite is joined to
// one point by a triangle. So no chain of triangles has an edge left over, and space is divided by winding numbers.
inline MeshGeometry closed(const MeshGeometry& open) {
    MeshGeometry mesh;
    struct Less {
        bool operator()(const vec3& a, const vec3& b) const {
            return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
        }
    };
    std::map<vec3, std::uint32_t, Less> places;
    const auto place = [&](const vec3& p) {
        const auto [at, added] = places.try_emplace(p + 0.0f, std::uint32_t(mesh.positions.size()));
        if (added) mesh.positions.push_back(p);
        return at->second;
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> surplus;  // of edges from the lower to the higher vertex
    for (const uvec3& t : open.triangles) {
        const uvec3 w(place(open.positions[t.x]), place(open.positions[t.y]), place(open.positions[t.z]));
        if (w.x == w.y || w.y == w.z || w.z == w.x) continue;
        mesh.triangles.push_back(w);
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = w[k], b = w[(k + 1) % 3];
            surplus[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    }
    glm::dvec3 sum(0);
    int count = 0;
    for (const auto& [edge, times] : surplus)
        if (times != 0) sum += glm::dvec3(mesh.positions[edge.first]), ++count;
    if (count == 0) return mesh;
    const auto apex = std::uint32_t(mesh.positions.size());
    mesh.positions.push_back(vec3(sum / double(count)));
    for (const auto& [edge, times] : surplus)
        for (int i = 0; i < std::abs(times); ++i)
            mesh.triangles.push_back(times > 0 ? uvec3(edge.second, edge.first, apex)
                                               : uvec3(edge.first, edge.second, apex));
    return mesh;
}

}  // namespace spinel::test
