#include "formats/mesh_attributes.h"

#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>

namespace spinel {
namespace {

constexpr std::uint32_t EMPTY = std::numeric_limits<std::uint32_t>::max();

std::uint64_t mixed(std::uint64_t hash, const void* bytes, std::size_t size) {
    const char* at = static_cast<const char*>(bytes);
    for (std::size_t i = 0; i < size; i += 4) {  // all attributes are arrays of floats
        std::uint32_t word;
        std::memcpy(&word, at + i, 4);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15ull;
        hash ^= hash >> 29;
    }
    return hash;
}

// Numbers the classes of equal things among 0 … count − 1 in the order of their first appearance.
// Returns each thing's class; `firsts` gets the first thing of each class.
template <class Hash, class Equal>
std::vector<std::uint32_t> classes(std::size_t count, Hash hash, Equal equal, std::vector<std::uint32_t>& firsts) {
    std::size_t capacity = 16;
    while (capacity < 2 * count) capacity *= 2;
    std::vector<std::uint32_t> table(capacity, EMPTY), result(count);
    for (std::size_t i = 0; i < count; ++i) {
        std::size_t slot = std::size_t(hash(i)) & (capacity - 1);
        while (table[slot] != EMPTY && !equal(firsts[table[slot]], i)) slot = (slot + 1) & (capacity - 1);
        if (table[slot] == EMPTY) {
            table[slot] = std::uint32_t(firsts.size());
            firsts.push_back(std::uint32_t(i));
        }
        result[i] = table[slot];
    }
    return result;
}

template <class T>
void gather(std::vector<T>& values, const std::vector<std::uint32_t>& from) {
    if (values.empty()) return;
    std::vector<T> gathered(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) gathered[i] = values[from[i]];
    values = std::move(gathered);
}

void gather_vertices(MeshGeometry& mesh, const std::vector<std::uint32_t>& from) {
    gather(mesh.positions, from);
    gather(mesh.normals, from);
    gather(mesh.uvs, from);
    gather(mesh.second_uvs, from);
    gather(mesh.tangents, from);
    gather(mesh.colors, from);
}

// Zero instead of NaN for what has no direction. In double: the coordinates of a scan may be tiny.
vec3 unit(glm::dvec3 v) {
    const double length = glm::length(v);
    return length > 0.0 && std::isfinite(length) ? vec3(v / length) : vec3(0.0f);
}

float angle_between(glm::dvec3 a, glm::dvec3 b) {
    return float(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

float corner_angle(const MeshGeometry& mesh, uvec3 triangle, int corner) {
    const glm::dvec3 at(mesh.positions[triangle[corner]]);
    return angle_between(glm::dvec3(mesh.positions[triangle[(corner + 1) % 3]]) - at,
                         glm::dvec3(mesh.positions[triangle[(corner + 2) % 3]]) - at);
}

}  // namespace

void weld_vertices(MeshGeometry& mesh) {
    const auto hash = [&](std::size_t i) {
        std::uint64_t h = mixed(0x51ed270b, &mesh.positions[i], sizeof(vec3));
        if (!mesh.normals.empty()) h = mixed(h, &mesh.normals[i], sizeof(vec3));
        if (!mesh.uvs.empty()) h = mixed(h, &mesh.uvs[i], sizeof(vec2));
        if (!mesh.second_uvs.empty()) h = mixed(h, &mesh.second_uvs[i], sizeof(vec2));
        if (!mesh.tangents.empty()) h = mixed(h, &mesh.tangents[i], sizeof(vec4));
        if (!mesh.colors.empty()) h = mixed(h, &mesh.colors[i], sizeof(vec4));
        return h;
    };
    const auto same = [](const auto& values, std::size_t a, std::size_t b) {
        // Vectors of floats have no padding; bit for bit, as they were hashed: −0 is not 0 here, and NaN is NaN.
        // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
        return values.empty() || std::memcmp(&values[a], &values[b], sizeof values[a]) == 0;
    };
    const auto equal = [&](std::size_t a, std::size_t b) {
        return same(mesh.positions, a, b) && same(mesh.normals, a, b) && same(mesh.uvs, a, b) &&
               same(mesh.second_uvs, a, b) && same(mesh.tangents, a, b) && same(mesh.colors, a, b);
    };
    std::vector<std::uint32_t> firsts;
    const std::vector<std::uint32_t> vertex = classes(mesh.positions.size(), hash, equal, firsts);
    for (uvec3& triangle : mesh.triangles)
        for (int c = 0; c < 3; ++c) triangle[c] = vertex[triangle[c]];
    gather_vertices(mesh, firsts);
}

void generate_normals(MeshGeometry& mesh, float crease_degrees) {
    const float smooth_cosine = std::cos(glm::radians(crease_degrees));
    const std::size_t corner_count = mesh.triangles.size() * 3;

    // Places: vertices at the same position, where −0 equals 0.
    std::vector<std::uint32_t> firsts;
    const std::vector<std::uint32_t> place = classes(
        mesh.positions.size(),
        [&](std::size_t i) {
            const vec3 position = mesh.positions[i] + 0.0f;
            return mixed(0x2545f491, &position, sizeof position);
        },
        [&](std::size_t a, std::size_t b) { return mesh.positions[a] == mesh.positions[b]; }, firsts);

    // Corners by place.
    std::vector<std::uint32_t> begin(firsts.size() + 1, 0), corners(corner_count);
    for (const uvec3& triangle : mesh.triangles)
        for (int c = 0; c < 3; ++c) ++begin[place[triangle[c]] + 1];
    for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    std::vector<vec3> face_normals(mesh.triangles.size());
    std::vector<float> angles(corner_count);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const uvec3 triangle = mesh.triangles[t];
        const glm::dvec3 a(mesh.positions[triangle.x]), b(mesh.positions[triangle.y]), c(mesh.positions[triangle.z]);
        face_normals[t] = unit(glm::cross(b - a, c - a));
        for (int k = 0; k < 3; ++k) {
            angles[3 * t + std::size_t(k)] = corner_angle(mesh, triangle, k);
            corners[next[place[triangle[k]]]++] = std::uint32_t(3 * t) + std::uint32_t(k);
        }
    }

    // The tip of a huge fan would cost the square of its faces; there all faces are averaged, creases or not.
    constexpr std::uint32_t largest_fan = 4096;
    std::vector<vec3> corner_normals(corner_count);
    for (std::size_t p = 0; p + 1 < begin.size(); ++p) {
        const bool huge = begin[p + 1] - begin[p] > largest_fan;
        vec3 shared(0.0f);
        for (std::uint32_t i = begin[p]; i < begin[p + 1]; ++i) {
            const vec3 own = face_normals[corners[i] / 3];
            if (!huge || i == begin[p]) {
                shared = vec3(0.0f);
                for (std::uint32_t j = begin[p]; j < begin[p + 1]; ++j) {
                    const vec3 other = face_normals[corners[j] / 3];
                    const bool degenerate = own == vec3(0.0f);
                    if (huge || degenerate || glm::dot(own, other) >= smooth_cosine)
                        shared += angles[corners[j]] * other;
                }
                shared = unit(shared);
            }
            corner_normals[corners[i]] = shared;
        }
    }

    // One vertex a corner, then equal ones merge again.
    std::vector<std::uint32_t> from(corner_count);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const std::size_t corner = 3 * t + std::size_t(c);
            from[corner] = mesh.triangles[t][c];
            mesh.triangles[t][c] = std::uint32_t(corner);
        }
    }
    mesh.normals.clear();
    gather_vertices(mesh, from);
    mesh.normals = std::move(corner_normals);
    weld_vertices(mesh);
}

void generate_tangents(MeshGeometry& mesh) {
    assert(mesh.normals.size() == mesh.positions.size() && mesh.uvs.size() == mesh.positions.size());
    mesh.tangents.clear();

    // ∂p/∂u and ∂p/∂v of each triangle. Which way round its uvs run decides which copy of a vertex it uses.
    struct Frame {
        vec3 u, v;
        bool mirrored;
    };
    std::vector<Frame> frames(mesh.triangles.size());
    std::vector<std::uint8_t> plain_use(mesh.positions.size(), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const uvec3 triangle = mesh.triangles[t];
        const vec3 p = mesh.positions[triangle.x];
        const glm::dvec3 e1(mesh.positions[triangle.y] - p), e2(mesh.positions[triangle.z] - p);
        const glm::dvec2 d1(mesh.uvs[triangle.y] - mesh.uvs[triangle.x]),
            d2(mesh.uvs[triangle.z] - mesh.uvs[triangle.x]);
        const double determinant = d1.x * d2.y - d2.x * d1.y;
        const double sign = determinant < 0 ? -1 : (determinant > 0 ? 1 : 0);
        frames[t] = {unit(sign * (d2.y * e1 - d1.y * e2)), unit(sign * (d1.x * e2 - d2.x * e1)), determinant < 0};
        if (!frames[t].mirrored)
            for (int c = 0; c < 3; ++c) plain_use[triangle[c]] = 1;
    }
    std::vector<std::uint32_t> from(mesh.positions.size());
    for (std::size_t i = 0; i < from.size(); ++i) from[i] = std::uint32_t(i);
    std::vector<std::uint32_t> mirrored_copy(mesh.positions.size(), EMPTY);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int c = 0; frames[t].mirrored && c < 3; ++c) {
            const std::uint32_t vertex = mesh.triangles[t][c];
            if (!plain_use[vertex]) continue;
            if (mirrored_copy[vertex] == EMPTY) {
                mirrored_copy[vertex] = std::uint32_t(from.size());
                from.push_back(vertex);
            }
            mesh.triangles[t][c] = mirrored_copy[vertex];
        }
    }
    if (from.size() > mesh.positions.size()) gather_vertices(mesh, from);

    std::vector<vec3> along_u(from.size(), vec3(0.0f)), along_v(from.size(), vec3(0.0f));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const std::uint32_t vertex = mesh.triangles[t][c];
            const float angle = corner_angle(mesh, mesh.triangles[t], c);
            along_u[vertex] += angle * frames[t].u;
            along_v[vertex] += angle * frames[t].v;
        }
    }
    mesh.tangents.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) {
        const vec3 normal = mesh.normals[i];
        const vec3 tangent = unit(along_u[i] - normal * glm::dot(normal, along_u[i]));
        const float side = glm::dot(glm::cross(normal, tangent), along_v[i]);
        mesh.tangents[i] = tangent == vec3(0.0f) ? vec4(0.0f) : vec4(tangent, side < 0 ? -1.0f : 1.0f);
    }
}

}  // namespace spinel
