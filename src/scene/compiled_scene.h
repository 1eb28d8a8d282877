#pragma once
// A scene frozen for rendering: flat arrays of kernel records. Immutable once compiled; share it freely between
// threads.

#include <cstdint>
#include <string>
#include <vector>

#include "core/result.h"
#include "geometry/mesh/mesh_structures.h"
#include "kernels/path_settings.h"
#include "spinel/scene.h"

namespace spinel {

struct CompiledScene {
    std::vector<kernels::Instance> instances;
    std::vector<kernels::BvhNode> instance_nodes;
    std::vector<std::uint32_t> instance_order;
    std::vector<kernels::Contact> contacts;
    std::vector<kernels::Slot> slots;
    std::vector<kernels::BvhNode> nodes;
    std::vector<kernels::KdNode> kd_nodes;
    std::vector<kernels::SphereNode> sphere_nodes;
    std::vector<kernels::MeshGrid> mesh_grids;
    HugeVector<kernels::WideUnit> wide_units;
    std::vector<kernels::UnitTriangle> unit_triangles;
    std::vector<vec3> positions;
    std::vector<kernels::Triangle> triangles;
    std::vector<kernels::TriangleInfo> triangle_infos;
    std::vector<vec3> normals;
    std::vector<vec2> uvs;
    std::vector<vec4> tangents;
    std::vector<vec4> colors;
    std::vector<kernels::Mesh> meshes;
    std::vector<kernels::VoxelGrid> voxel_grids;
    std::vector<kernels::VoxelNode> voxel_nodes;
    std::vector<kernels::VoxelMip> voxel_mips;
    std::vector<kernels::SdfOp> sdf_ops;
    std::vector<kernels::Sdf> sdfs;
    std::vector<kernels::Interior> interiors;
    std::vector<kernels::Medium> media;
    std::vector<kernels::DensityGrid> grids;
    std::vector<kernels::Material> materials;
    std::vector<kernels::Texture> textures;
    std::vector<kernels::Light> lights;
    std::vector<kernels::AliasEntry> light_table;
    std::vector<std::uint32_t> words;
    std::vector<float> floats;
    kernels::Environment environment = {};
    kernels::PreviewLight preview_light = {};
    kernels::Camera camera = {};
    std::uint32_t bounded_count = 0;
    std::uint32_t pass_through_count = 0;
    std::uint32_t infinite_light_count = 0;
    std::uint32_t camera_inside_first = 0;
    std::uint32_t camera_inside_count = 0;
    std::uint32_t microfacet_first = 0;
    std::uint32_t mip_first = kernels::NONE;
    float mip_edge = 0;
    vec3 lower = {0, 0, 0};  // of all that is bounded, in world space
    vec3 upper = {0, 0, 0};

    Film film;
    IntegratorSettings integrator;
    kernels::DvrSettings dvr = {};  // its table is in `floats`
    std::vector<std::string> object_names;
    std::vector<MeshStatistics> mesh_statistics;  // parallel to meshes

    // Addresses into this object, valid as long as it lives and is not moved.
    kernels::SceneView view() const;
};

struct CompileOptions {
    std::string camera = {};                     // name; empty: the scene's first
    ivec2 size = {0, 0};                         // of the film; (0, 0): the scene's
    std::string integrator = {};                 // what it will be rendered by; empty: the scene's
    AcceleratorSettings accelerator = {"", ""};  // empty names: the scene's; with a structure: its default preset
    bool join_meshes = true;  // meshes in one local space are walked as one where that is no different
};

// Validates, builds acceleration structures, majorants and light tables. Errors name the thing and what is allowed.
Result<CompiledScene> compile(const Scene& scene, const CompileOptions& options = {});

// Largest scale of a transform is within a factor 1 + 1e-4 of its smallest, and it keeps right angles.
bool is_similarity(const mat4x3& transform);

}  // namespace spinel
