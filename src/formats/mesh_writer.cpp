#include "formats/mesh_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <set>
#include <unordered_map>

#include "core/atomic_file.h"
#include "formats/left_out.h"
#include "image/palette.h"
#include "kernels/materials.h"

namespace spinel {
namespace {

Error cannot_write(const std::filesystem::path& path, const std::string& why) {
    return {fmt::format("cannot write '{}': {}", path.string(), why)};
}

Result<void> check(const Scene& scene, const std::filesystem::path& path) {
    if (scene.objects.empty()) return cannot_write(path, "the scene is empty");
    for (const Object& object : scene.objects) {
        if (!std::holds_alternative<MeshGeometry>(scene.geometries[std::size_t(object.geometry)].data))
            return cannot_write(path, fmt::format("object '{}' is not a mesh", object.name));
        for (const int m : object.materials) {
            if (m < 0) continue;
            const kernels::Material& v = scene.materials[std::size_t(m)].values;
            for (const std::uint32_t texture : {v.color_texture, v.roughness_texture, v.metallic_texture,
                                                v.emission_texture, v.normal_texture, v.opacity_texture})
                if (texture != kernels::NONE)
                    return cannot_write(path, fmt::format("textures, as material '{}' has them, cannot be written",
                                                          scene.materials[std::size_t(m)].name));
        }
    }
    return {};
}

// −1: none.
int material_of(const Object& object, const MeshGeometry& mesh, std::size_t triangle) {
    if (object.materials.empty()) return -1;
    if (object.materials.size() == 1) return object.materials[0];
    return object.materials[mesh.slots.empty() ? 0 : mesh.slots[triangle]];
}

// A transform that mirrors turns triangles inside out.
uvec3 outwards(const Object& object, uvec3 t) {
    return glm::determinant(mat3(object.transform)) < 0 ? uvec3(t.x, t.z, t.y) : t;
}

mat3 normal_matrix(const Object& object) { return glm::transpose(glm::inverse(mat3(object.transform))); }

// Names of materials without space, each its own.
std::vector<std::string> mtl_names(const Scene& scene) {
    std::vector<std::string> names;
    std::set<std::string> taken;
    for (const Material& material : scene.materials) {
        std::string name = material.name.empty() ? "material" : material.name;
        std::replace_if(
            name.begin(), name.end(), [](unsigned char c) { return c <= ' '; }, '_');
        if (!taken.insert(name).second) {
            name += fmt::format("_{}", names.size());
            taken.insert(name);
        }
        names.push_back(name);
    }
    return names;
}

std::string mtl_text(const Scene& scene, const std::vector<std::string>& names) {
    std::string text;
    const auto out = std::back_inserter(text);
    for (std::size_t i = 0; i < names.size(); ++i) {
        const kernels::Material& m = scene.materials[i].values;
        const bool glass = m.kind == kernels::MATERIAL_DIELECTRIC;
        const bool metal = m.kind == kernels::MATERIAL_METAL;
        const vec3 color = glass ? vec3(1) : m.color;
        fmt::format_to(out, "newmtl {}\nKd {} {} {}\n", names[i], color.x, color.y, color.z);
        if (m.emission != vec3(0)) fmt::format_to(out, "Ke {} {} {}\n", m.emission.x, m.emission.y, m.emission.z);
        if (m.opacity < 1) fmt::format_to(out, "d {}\n", m.opacity);
        if (glass) fmt::format_to(out, "Ni {}\nillum 7\n", m.ior);
        if (metal || m.metallic > 0) fmt::format_to(out, "Pr {}\nPm {}\n", m.roughness, metal ? 1.0f : m.metallic);
    }
    return text;
}

Notes left_out_of_mesh(const Scene& scene) {
    LeftOut left_out;
    if (!scene.textures.empty()) left_out.add("textures");
    left_out.add_light_and_cameras(scene);
    return left_out.notes();
}

template <class T>
void put(std::string& bytes, const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

Result<Notes> save_obj(const Scene& scene, const std::filesystem::path& path) {
    if (Result<void> fit = check(scene, path); !fit) return fit.error();
    const std::vector<std::string> names = mtl_names(scene);
    std::filesystem::path library = path;
    library.replace_extension(".mtl");
    std::string text;
    const auto out = std::back_inserter(text);
    if (!names.empty()) fmt::format_to(out, "mtllib {}\n", library.filename().string());
    std::size_t positions = 1, uvs = 1, normals = 1;  // OBJ counts from 1 through the whole file
    for (const Object& object : scene.objects) {
        const auto& mesh = std::get<MeshGeometry>(scene.geometries[std::size_t(object.geometry)].data);
        fmt::format_to(out, "o {}\n", object.name.empty() ? "mesh" : object.name);
        for (const vec3& local : mesh.positions) {
            const vec3 p = object.transform * vec4(local, 1);
            fmt::format_to(out, "v {} {} {}\n", p.x, p.y, p.z);
        }
        for (const vec2& uv : mesh.uvs) fmt::format_to(out, "vt {} {}\n", uv.x, uv.y);
        const mat3 turn = normal_matrix(object);
        for (const vec3& local : mesh.normals) {
            const vec3 n = turn * local;
            const float length = glm::length(n);
            fmt::format_to(out, "vn {} {} {}\n", n.x / length, n.y / length, n.z / length);
        }
        int current = -1;
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            const int material = material_of(object, mesh, i);
            if (material >= 0 && material != current) {
                fmt::format_to(out, "usemtl {}\n", names[std::size_t(material)]);
                current = material;
            }
            const uvec3 t = outwards(object, mesh.triangles[i]);
            text += 'f';
            for (int k = 0; k < 3; ++k) {
                fmt::format_to(out, " {}", positions + t[k]);
                if (!mesh.uvs.empty()) fmt::format_to(out, "/{}", uvs + t[k]);
                if (!mesh.normals.empty()) fmt::format_to(out, "{}{}", mesh.uvs.empty() ? "//" : "/", normals + t[k]);
            }
            text += '\n';
        }
        positions += mesh.positions.size();
        uvs += mesh.uvs.size();
        normals += mesh.normals.size();
    }
    if (!names.empty())
        if (Result<void> written = write_file_atomically(library, mtl_text(scene, names)); !written)
            return written.error();
    if (Result<void> written = write_file_atomically(path, text); !written) return written.error();
    return left_out_of_mesh(scene);
}

Result<Notes> save_ply(const Scene& scene, const std::filesystem::path& path) {
    if (Result<void> fit = check(scene, path); !fit) return fit.error();
    std::string vertices, faces;
    std::uint32_t vertex_count = 0, face_count = 0;
    const auto meshes_have = [&](const auto member) {
        return std::all_of(scene.objects.begin(), scene.objects.end(), [&](const Object& object) {
            return !(std::get<MeshGeometry>(scene.geometries[std::size_t(object.geometry)].data).*member).empty();
        });
    };
    const bool has_normals = meshes_have(&MeshGeometry::normals), has_uvs = meshes_have(&MeshGeometry::uvs);
    for (const Object& object : scene.objects) {
        const auto& mesh = std::get<MeshGeometry>(scene.geometries[std::size_t(object.geometry)].data);
        const mat3 turn = normal_matrix(object);
        std::unordered_map<std::uint64_t, std::uint32_t> made;  // by vertex and material
        const auto vertex = [&](std::uint32_t v, int material) {
            const auto [found, is_new] = made.emplace(std::uint64_t(v) << 32 | std::uint32_t(material), vertex_count);
            if (!is_new) return found->second;
            ++vertex_count;
            put(vertices, vec3(object.transform * vec4(mesh.positions[v], 1)));
            if (has_normals) {
                const vec3 n = turn * mesh.normals[v];
                put(vertices, n / glm::length(n));
            }
            if (has_uvs) put(vertices, mesh.uvs[v]);
            vec3 color = material >= 0 ? scene.materials[std::size_t(material)].values.color : vec3(1);
            if (!mesh.colors.empty()) color *= vec3(mesh.colors[v]);
            const std::uint32_t packed = srgb8(color);
            vertices.append(reinterpret_cast<const char*>(&packed), 3);
            return found->second;
        };
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i, ++face_count) {
            const uvec3 t = outwards(object, mesh.triangles[i]);
            const int material = material_of(object, mesh, i);
            faces += char(3);
            for (int k = 0; k < 3; ++k) put(faces, vertex(t[k], material));
        }
    }
    std::string bytes = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", vertex_count);
    bytes += "property float x\nproperty float y\nproperty float z\n";
    if (has_normals) bytes += "property float nx\nproperty float ny\nproperty float nz\n";
    if (has_uvs) bytes += "property float s\nproperty float t\n";
    bytes += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    bytes += fmt::format("element face {}\nproperty list uchar uint vertex_indices\nend_header\n", face_count);
    if (Result<void> written = write_file_atomically(path, bytes + vertices + faces); !written) return written.error();
    return left_out_of_mesh(scene);
}

}  // namespace spinel
