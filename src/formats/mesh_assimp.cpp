#include "formats/mesh_assimp.h"

#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <stdexcept>

#include "formats/file_bytes.h"
#include "formats/gltf_extras.h"
#include "formats/mesh_attributes.h"
#include "formats/mesh_checks.h"
#include "formats/mesh_material.h"
#include "formats/mesh_textures.h"
#include "formats/polygon.h"
#include "image/tone_map.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"

// Debian's Assimp is built with its assertions on: a malformed file would end the program. The library calls
// this function through the dynamic linker, so this definition takes its place; ReadFile() turns the
// exception into an error.
namespace Assimp {
__attribute__((visibility("default"))) void aiAssertViolation(const char* expression, const char*, int) {
    throw std::runtime_error(std::string("the file breaks the rule ") + expression);
}
}  // namespace Assimp

namespace spinel {
namespace {

constexpr std::size_t MAX_CORNERS = std::size_t(1) << 31;
constexpr std::size_t MAX_OBJECTS = std::size_t(1) << 20;
constexpr float CREASE_DEGREES = 60;

vec3 to_vec3(const aiVector3D& v) { return {v.x, v.y, v.z}; }
bool is_finite(vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

mat4x3 to_transform(const aiMatrix4x4& m) {
    return {vec3(m.a1, m.b1, m.c1), vec3(m.a2, m.b2, m.c2), vec3(m.a3, m.b3, m.c3), vec3(m.a4, m.b4, m.c4)};
}

class MeshLoader {
  public:
    MeshLoader(const std::filesystem::path& path, const GltfExtras* gltf) : path_(path), gltf_(gltf) {}

    Result<Scene> load() {
        std::error_code error;
        if (!std::filesystem::is_regular_file(path_, error))
            return cannot_read(
                path_, std::filesystem::exists(path_, error) ? "that is not a plain file" : "there is no such file");
        if (std::filesystem::file_size(path_, error) > MAX_MESH_FILE)
            return cannot_read(path_, "its size is more than the " + std::to_string(MAX_MESH_FILE) + " bytes allowed");
        if (path_extension() == ".ply")
            if (Result<void> sound = check_ply(path_); !sound) return sound.error();
        if (path_extension() == ".off")
            if (Result<void> sound = check_off(path_); !sound) return sound.error();
        // As the file has it: what follows is ours, Assimp's own steps assume sound and unindexed meshes.
        source_ = importer_.ReadFile(path_.string(), 0);
        if (!source_) return library_error();
        if (Result<void> checked = check_meshes(); !checked) return checked.error();
        if (Result<void> made = make_materials(); !made) return made.error();
        if (Result<void> made = make_geometries(); !made) return made.error();
        if (Result<void> placed = place_nodes(); !placed) return placed.error();
        if (scene_.objects.empty()) return cannot_read(path_, "it holds no triangle");
        if (gltf_) {
            make_cameras();
            make_lights();
            scene_.notes.insert(scene_.notes.end(), gltf_->notes.begin(), gltf_->notes.end());
        }
        return std::move(scene_);
    }

  private:
    Error library_error() const {
        std::string text = importer_.GetErrorString();
        text = text.substr(0, text.find('\n'));
        while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
        return cannot_read(path_, text.empty() ? "it holds no mesh" : text);
    }

    Result<void> check_meshes() const {
        std::size_t corners = 0;
        for (unsigned m = 0; m < source_->mNumMeshes; ++m) {
            const aiMesh& mesh = *source_->mMeshes[m];
            const std::string where = "mesh " + std::to_string(m) + " ('" + mesh.mName.C_Str() + "'): ";
            if (!mesh.mVertices && mesh.mNumVertices > 0) return cannot_read(path_, where + "it has no positions");
            for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
                if (!is_finite(to_vec3(mesh.mVertices[v])))
                    return cannot_read(path_, where + "vertex " + std::to_string(v) + " is not finite");
            }
            for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
                const aiFace& face = mesh.mFaces[f];
                corners += face.mNumIndices;
                for (unsigned i = 0; i < face.mNumIndices; ++i) {
                    if (face.mIndices[i] >= mesh.mNumVertices)
                        return cannot_read(path_, where + "face " + std::to_string(f) + " refers to vertex " +
                                                      std::to_string(face.mIndices[i]) + " of " +
                                                      std::to_string(mesh.mNumVertices));
                }
            }
        }
        if (corners > MAX_CORNERS)
            return cannot_read(path_, "its " + std::to_string(corners) + " face corners are more than the " +
                                          std::to_string(MAX_CORNERS) + " allowed");
        return {};
    }

    Result<void> make_materials() {
        MeshTextures textures(path_, *source_, scene_);
        if (!gltf_) textures.allow_missing();  // an MTL is often all that is left of a model's looks
        std::vector<bool> used(source_->mNumMaterials, false);
        for (unsigned m = 0; m < source_->mNumMeshes; ++m)
            if (source_->mMeshes[m]->mMaterialIndex < used.size()) used[source_->mMeshes[m]->mMaterialIndex] = true;
        uv_sets_.assign(used.size(), {0});
        material_of_.assign(used.size(), -1);
        for (unsigned m = 0; m < source_->mNumMaterials; ++m) {
            if (!used[m]) continue;
            const GltfExtras::MaterialExtras* extras = nullptr;
            if (gltf_) {
                const auto found = gltf_->materials.find(m);
                if (found != gltf_->materials.end()) extras = &found->second;
            }
            Result<Material> material = mesh_material(*source_->mMaterials[m], extras, textures, scene_.notes);
            if (!material) return material.error();
            material_of_[m] = int(scene_.materials.size());
            uv_sets_[m] = textures.uv_sets();
            if (uv_sets_[m].empty()) uv_sets_[m] = {0};
            scene_.materials.push_back(std::move(*material));
        }
        if (!textures.missing().empty()) {
            std::string names;
            for (std::size_t i = 0; i < std::min<std::size_t>(textures.missing().size(), 3); ++i)
                names += (i == 0 ? "'" : ", '") + textures.missing()[i] + "'";
            scene_.notes.push_back("textures that are not there are left out (" +
                                   std::to_string(textures.missing().size()) + "): " + names +
                                   (textures.missing().size() > 3 ? ", …" : ""));
        }
        return {};
    }

    Result<void> make_geometries() {
        for (unsigned m = 0; m < source_->mNumMeshes; ++m) {
            const aiMesh& mesh = *source_->mMeshes[m];
            MeshGeometry geometry = attributes(mesh);
            for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
                const aiFace& face = mesh.mFaces[f];
                if (face.mNumIndices >= 3)
                    triangulate(geometry.positions, {face.mIndices, face.mNumIndices}, geometry.triangles);
            }
            geometry_of_.push_back(geometry.triangles.empty() ? -1 : int(scene_.geometries.size()));
            if (geometry.triangles.empty()) continue;

            weld_vertices(geometry);
            if (geometry.normals.empty() && !gltf_) generate_normals(geometry, CREASE_DEGREES);
            if (!geometry.uvs.empty() && !geometry.normals.empty() && geometry.tangents.empty())
                generate_tangents(geometry);
            const std::string name = mesh.mName.C_Str();
            scene_.geometries.push_back({name.empty() ? "mesh " + std::to_string(m) : name, std::move(geometry)});
        }
        return {};
    }

    MeshGeometry attributes(const aiMesh& mesh) const {
        MeshGeometry geometry;
        const std::vector<unsigned> sets =
            mesh.mMaterialIndex < uv_sets_.size() ? uv_sets_[mesh.mMaterialIndex] : std::vector<unsigned>{0};
        const auto has_set = [&](unsigned set) {
            return set < AI_MAX_NUMBER_OF_TEXTURECOORDS && mesh.HasTextureCoords(set);
        };
        const unsigned uv_set = sets[0];
        const bool second_uvs = sets.size() > 1 && has_set(sets[1]);
        const bool normals = mesh.HasNormals() && path_extension() != ".stl";
        const bool uvs = has_set(uv_set);
        const bool tangents = normals && uvs && mesh.HasTangentsAndBitangents();
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
            geometry.positions.push_back(to_vec3(mesh.mVertices[v]));
            // What is not finite among these costs only itself: no normal, the corner of the picture, no
            // tangent.
            const vec3 normal = normals ? unit_or_zero(to_vec3(mesh.mNormals[v])) : vec3(0.0f);
            if (normals) geometry.normals.push_back(normal);
            const auto uv_of = [&](unsigned set) {
                const vec3 uv = to_vec3(mesh.mTextureCoords[set][v]);
                return is_finite(uv) ? vec2(uv) : vec2(0.0f);
            };
            if (uvs) geometry.uvs.push_back(uv_of(uv_set));
            if (second_uvs) geometry.second_uvs.push_back(uv_of(sets[1]));
            if (tangents) {
                const vec3 tangent = unit_or_zero(to_vec3(mesh.mTangents[v]));
                const float side = glm::dot(glm::cross(normal, tangent), to_vec3(mesh.mBitangents[v]));
                geometry.tangents.emplace_back(tangent, tangent == vec3(0.0f) ? 0.0f : (side < 0 ? -1.0f : 1.0f));
            }
            if (mesh.HasVertexColors(0)) {
                const aiColor4D& c = mesh.mColors[0][v];
                vec4 color(c.r, c.g, c.b, c.a);
                // glTF's are linear; the bytes of a scan are what its camera gave.
                for (int i = 0; i < 3; ++i) {
                    if (!gltf_) color[i] = srgb_decoded(color[i]);
                    if (!(color[i] >= 0.0f && color[i] <= 1.0f)) color[i] = color[i] > 1.0f ? 1.0f : 0.0f;
                }
                if (!std::isfinite(color.w)) color.w = 1.0f;
                geometry.colors.push_back(color);
            }
        }
        return geometry;
    }

    static vec3 unit_or_zero(vec3 v) {
        const float length = glm::length(v);
        return length > 0.0f && std::isfinite(length) ? v / length : vec3(0.0f);
    }

    std::string path_extension() const {
        std::string extension = path_.extension().string();
        std::transform(extension.begin(), extension.end(), extension.begin(),
                       [](unsigned char c) { return std::tolower(c); });
        return extension;
    }

    Result<void> place_nodes() {
        std::vector<std::pair<const aiNode*, aiMatrix4x4>> waiting = {{source_->mRootNode, aiMatrix4x4()}};
        while (!waiting.empty()) {
            const auto [node, parent] = waiting.back();
            waiting.pop_back();
            const aiMatrix4x4 to_world = parent * node->mTransformation;
            const mat4x3 transform = to_transform(to_world);
            for (int column = 0; column < 4; ++column) {
                if (!is_finite(transform[column]))
                    return cannot_read(
                        path_, "the transform of node '" + std::string(node->mName.C_Str()) + "' is not finite");
            }
            // A scale of zero along an axis is the usual way to hide a thing.
            const bool visible = glm::determinant(mat3(transform[0], transform[1], transform[2])) != 0.0f;
            for (unsigned i = 0; visible && i < node->mNumMeshes; ++i) {
                const int geometry = geometry_of_[node->mMeshes[i]];
                if (geometry < 0) continue;
                if (scene_.objects.size() >= MAX_OBJECTS)
                    return cannot_read(path_,
                                       "it places more than the " + std::to_string(MAX_OBJECTS) + " objects allowed");
                Object object;
                object.name = node->mName.C_Str();
                object.geometry = geometry;
                object.transform = transform;
                object.materials = {material_of(*source_->mMeshes[node->mMeshes[i]])};
                scene_.objects.push_back(std::move(object));
            }
            for (unsigned i = node->mNumChildren; i > 0; --i) waiting.emplace_back(node->mChildren[i - 1], to_world);
        }
        return {};
    }

    int material_of(const aiMesh& mesh) {
        const int own = mesh.mMaterialIndex < material_of_.size() ? material_of_[mesh.mMaterialIndex] : -1;
        const bool none = own < 0 || scene_.materials[std::size_t(own)].name == "default";
        if (own >= 0 && !(none && mesh.HasVertexColors(0))) return own;
        // Vertex colours without a material are all there is to see: on white.
        if (white_ < 0) {
            white_ = int(scene_.materials.size());
            kernels::Material white = default_material(kernels::MATERIAL_DIFFUSE);
            white.color = vec3(1.0f);
            scene_.materials.push_back({"vertex colors", white});
        }
        return white_;
    }

    aiMatrix4x4 world_transform(const aiString& name) const {
        aiMatrix4x4 result;
        for (const aiNode* node = source_->mRootNode->FindNode(name); node; node = node->mParent)
            result = node->mTransformation * result;
        return result;
    }

    void make_cameras() {
        for (unsigned c = 0; c < source_->mNumCameras; ++c) {
            if (c >= gltf_->cameras.size()) break;
            const GltfExtras::CameraExtras lens = gltf_->cameras[c];
            if (lens.yfov <= 0 && lens.ymag <= 0) continue;
            const mat4x3 to_world = to_transform(world_transform(source_->mCameras[c]->mName));
            Camera camera;
            camera.name = source_->mCameras[c]->mName.C_Str();
            camera.from = to_world[3];
            camera.at = to_world[3] - glm::normalize(to_world[2]);  // looks along its −z
            camera.up = glm::normalize(to_world[1]);
            if (lens.yfov > 0) {
                camera.fov = glm::degrees(lens.yfov);
            } else {
                camera.kind = Camera::Kind::orthographic;
                camera.height = 2 * lens.ymag;
            }
            if (is_finite(camera.from) && is_finite(camera.at) && is_finite(camera.up))
                scene_.cameras.push_back(camera);
        }
    }

    // Numbers as they stand: candela and lux are taken for W/sr and W/m².
    void make_lights() {
        for (unsigned i = 0; i < source_->mNumLights; ++i) {
            const aiLight& source = *source_->mLights[i];
            const mat4x3 to_world = to_transform(world_transform(source.mName));
            const vec3 direction = -glm::normalize(to_world[2]);
            const vec3 color(source.mColorDiffuse.r, source.mColorDiffuse.g, source.mColorDiffuse.b);
            if (!is_finite(to_world[3]) || !is_finite(direction) || !is_finite(color)) continue;
            Light light;
            light.name = source.mName.C_Str();
            if (source.mType == aiLightSource_POINT) {
                light.data = PointLight{to_world[3], color};
            } else if (source.mType == aiLightSource_SPOT) {
                light.data = SpotLight{to_world[3], direction, color, glm::degrees(source.mAngleInnerCone),
                                       glm::degrees(source.mAngleOuterCone)};
            } else if (source.mType == aiLightSource_DIRECTIONAL) {
                light.data = DirectionalLight{direction, color, 0};
            } else {
                continue;
            }
            scene_.lights.push_back(std::move(light));
        }
    }

    const std::filesystem::path& path_;
    const GltfExtras* gltf_;  // null: another format
    Assimp::Importer importer_;
    const aiScene* source_ = nullptr;  // the importer's
    Scene scene_;
    std::vector<std::vector<unsigned>> uv_sets_;  // of each of the file's materials, one or two
    std::vector<int> material_of_;                // of each of the file's materials; −1: no mesh uses it
    std::vector<int> geometry_of_;                // of each of the file's meshes; −1: it has no triangle
    int white_ = -1;
};

// Assimp reports most of what is wrong by itself; what escapes it (memory, above all) is caught here.
Result<Scene> load(const std::filesystem::path& path, const GltfExtras* gltf) {
    try {
        return MeshLoader(path, gltf).load();
    } catch (const std::exception& exception) { return cannot_read(path, exception.what()); }
}

}  // namespace

Result<Scene> load_mesh(const std::filesystem::path& path, const LoadOptions&) { return load(path, nullptr); }

Result<Scene> load_gltf(const std::filesystem::path& path, const LoadOptions&) {
    const Result<GltfExtras> extras = read_gltf_extras(path);
    if (!extras) return extras.error();
    return load(path, &*extras);
}

}  // namespace spinel
