#pragma once
// Scenes for tests, put together from kernel records by hand, without files and without compile().

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "accel/bvh_builder.h"
#include "geometry/mesh/mesh_builder.h"
#include "geometry/voxels/voxel_builder.h"
#include "kernels/box.h"
#include "kernels/scene_view.h"
#include "kernels/sdf_ops.h"
#include "spinel/scene.h"

namespace spinel::test {

inline constexpr std::uint32_t NO = kernels::NONE;
inline constexpr kernels::Slot OPAQUE_SLOT = {0, NO};

inline mat4x3 affine(const glm::mat3& linear, vec3 translation) {
    return mat4x3(linear[0], linear[1], linear[2], translation);
}

// All cells, x fastest.
inline VoxelGeometry voxels_of(ivec3 size, const std::vector<std::uint16_t>& cells) {
    Result<VoxelTreePointer> tree = build_voxel_tree(size, cells);
    if (!tree) throw std::runtime_error(tree.error().message);
    return {*tree};
}

class TestScene {
  public:
    // Each returns the geometry's index among its kind.
    std::uint32_t add(const MeshGeometry& mesh, const AcceleratorSettings& accelerator = {}) {
        const auto built = build_mesh(mesh, accelerator);
        if (!built) throw std::runtime_error(built.error().message);
        return add(mesh, *built);
    }
    std::uint32_t add(const MeshGeometry& mesh, const MeshData& built) {
        const auto record = append_mesh(pools_, mesh, built);
        if (!record) throw std::runtime_error(record.error().message);
        meshes_.push_back(*record);
        mesh_bounds_.push_back(built.bounds);
        return count(meshes_) - 1;
    }
    std::uint32_t add(const VoxelGeometry& voxels) {
        grids_.push_back(append_voxels(*voxels.tree, voxel_nodes_, pools_.words));
        return count(grids_) - 1;
    }
    // A sphere as an implicit surface.
    std::uint32_t add_sdf_sphere(float radius) {
        const float r = radius * 1.01f;
        sdfs_.push_back({vec3(-r), count(ops_), vec3(r), 1, 1.0f, 0, kernels::INFINITE});
        ops_.push_back({kernels::SDF_OP_SPHERE, 0, 0, 0, vec4(radius, 0, 0, 0), vec4(0)});
        return count(sdfs_) - 1;
    }

    std::uint32_t place(std::uint32_t kind, std::uint32_t geometry = 0, const mat4x3& transform = mat4x3(1),
                        const std::vector<kernels::Slot>& slots = {OPAQUE_SLOT}, std::uint32_t flags = 0) {
        const glm::dmat3 linear = glm::inverse(glm::dmat3(glm::mat3(transform)));
        const glm::mat3 inverse(linear);
        const mat4x3 to_object = affine(inverse, vec3(-(linear * glm::dvec3(transform[3]))));
        instances_.push_back(
            {transform, to_object, kind, geometry, count(slots_), NO, 0, flags, count(instances_), 0, 0, 0, 0, 0});
        append(slots_, slots);
        return count(instances_) - 1;
    }

    // The view is valid until something is added.
    const kernels::SceneView& view() {
        std::vector<Box> boxes;
        std::vector<std::uint32_t> bounded, unbounded;
        std::uint32_t pass_through = 0;
        for (std::uint32_t i = 0; i < count(instances_); ++i) {
            if (instances_[i].flags & kernels::INSTANCE_PASS_THROUGH) ++pass_through;
            if (instances_[i].geometry_kind == kernels::GEOMETRY_PLANE) {
                unbounded.push_back(i);
            } else {
                bounded.push_back(i);
                boxes.push_back(world_bounds(instances_[i]));
            }
        }
        Bvh bvh = build_bvh(boxes);
        instance_nodes_ = std::move(bvh.nodes);
        order_.clear();
        for (const std::uint32_t i : bvh.order) order_.push_back(bounded[i]);
        append(order_, unbounded);
        view_ = {};
        view_.instances.at = instances_.data();
        view_.instance_nodes.at = instance_nodes_.data();
        view_.instance_order.at = order_.data();
        view_.slots.at = slots_.data();
        view_.nodes.at = pools_.nodes.data();
        view_.kd_nodes.at = pools_.kd_nodes.data();
        view_.wide_units.at = pools_.wide_units.data();
        view_.sphere_nodes.at = pools_.sphere_nodes.data();
        view_.mesh_grids.at = pools_.mesh_grids.data();
        view_.unit_triangles.at = pools_.unit_triangles.data();
        view_.positions.at = pools_.positions.data();
        view_.triangles.at = pools_.triangles.data();
        view_.triangle_infos.at = pools_.triangle_infos.data();
        view_.meshes.at = meshes_.data();
        view_.voxel_grids.at = grids_.data();
        view_.voxel_nodes.at = voxel_nodes_.data();
        view_.sdf_ops.at = ops_.data();
        view_.sdfs.at = sdfs_.data();
        view_.words.at = pools_.words.data();
        view_.instance_count = count(instances_);
        view_.bounded_count = count(bounded);
        view_.unbounded_count = count(unbounded);
        view_.pass_through_count = pass_through;
        return view_;
    }

  private:
    template <class T>
    static std::uint32_t count(const std::vector<T>& v) {
        return static_cast<std::uint32_t>(v.size());
    }
    template <class T>
    static void append(std::vector<T>& to, const std::vector<T>& from) {
        to.insert(to.end(), from.begin(), from.end());
    }
    Box world_bounds(const kernels::Instance& instance) const {
        Box local{vec3(-1), vec3(1)};
        switch (instance.geometry_kind) {
            case kernels::GEOMETRY_MESH: local = mesh_bounds_[instance.geometry]; break;
            case kernels::GEOMETRY_VOXELS: local = {vec3(0), vec3(grids_[instance.geometry].size)}; break;
            case kernels::GEOMETRY_SDF: local = {sdfs_[instance.geometry].lower, sdfs_[instance.geometry].upper}; break;
            case kernels::GEOMETRY_RECTANGLE: local = {vec3(-1, 0, -1), vec3(1, 0, 1)}; break;
        }
        Box world{vec3(1e30f), vec3(-1e30f)};
        for (int corner = 0; corner < 8; ++corner) {
            const vec3 p(corner & 1 ? local.upper.x : local.lower.x, corner & 2 ? local.upper.y : local.lower.y,
                         corner & 4 ? local.upper.z : local.lower.z);
            const vec3 q = instance.object_to_world * vec4(p, 1);
            world.lower = glm::min(world.lower, q);
            world.upper = glm::max(world.upper, q);
        }
        // The ray is rounded on its way into local space, and primitives are by their tests: so much may one seem to
        // stick out.
        const vec3 margin(1.25f * kernels::slab_padding(world.lower, world.upper, vec3(0)));
        return {world.lower - margin, world.upper + margin};
    }

    std::vector<kernels::Instance> instances_;
    struct Pools {
        std::vector<kernels::BvhNode> nodes;
        std::vector<kernels::KdNode> kd_nodes;
        HugeVector<kernels::WideUnit> wide_units;
        std::vector<kernels::SphereNode> sphere_nodes;
        std::vector<kernels::MeshGrid> mesh_grids;
        std::vector<kernels::UnitTriangle> unit_triangles;
        std::vector<kernels::Triangle> triangles;
        std::vector<kernels::TriangleInfo> triangle_infos;
        std::vector<vec3> positions, normals;
        std::vector<vec2> uvs;
        std::vector<vec4> tangents, colors;
        std::vector<std::uint32_t> words;
    } pools_;
    std::vector<kernels::BvhNode> instance_nodes_;
    std::vector<std::uint32_t> order_;
    std::vector<kernels::Slot> slots_;
    std::vector<kernels::Mesh> meshes_;
    std::vector<Box> mesh_bounds_;
    std::vector<kernels::VoxelGrid> grids_;
    std::vector<kernels::VoxelNode> voxel_nodes_;
    std::vector<kernels::SdfOp> ops_;
    std::vector<kernels::Sdf> sdfs_;
    kernels::SceneView view_ = {};
};

// ----------------------------------------------------------------------------------------------------------
// test meshes Icosahedron, each triangle split in four `subdivisions` times, pulled onto the unit sphere.
// Closed.
inline MeshGeometry icosphere(int subdivisions) {
    const float g = 0.5f * (1 + std::sqrt(5.0f));
    MeshGeometry mesh;
    mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (vec3& p : mesh.positions) p = glm::normalize(p);
    for (int level = 0; level < subdivisions; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [it, fresh] = middles.try_emplace(std::minmax(a, b), std::uint32_t(mesh.positions.size()));
            if (fresh) mesh.positions.push_back(glm::normalize(mesh.positions[a] + mesh.positions[b]));
            return it->second;
        };
        std::vector<uvec3> finer;
        for (const uvec3& t : mesh.triangles) {
            const std::uint32_t a = middle(t.x, t.y), b = middle(t.y, t.z), c = middle(t.z, t.x);
            finer.insert(finer.end(), {{t.x, a, c}, {t.y, b, a}, {t.z, c, b}, {a, b, c}});
        }
        mesh.triangles = std::move(finer);
    }
    return mesh;
}

// Around +y, radii 1 and `minor`. Closed.
inline MeshGeometry torus(std::uint32_t around, std::uint32_t across, float minor) {
    MeshGeometry mesh;
    for (std::uint32_t i = 0; i < around; ++i) {
        for (std::uint32_t j = 0; j < across; ++j) {
            const float a = 2 * kernels::PI * float(i) / float(around), b = 2 * kernels::PI * float(j) / float(across);
            const float r = 1 + minor * std::cos(b);
            mesh.positions.push_back({r * std::cos(a), minor * std::sin(b), r * std::sin(a)});
            const std::uint32_t i1 = (i + 1) % around, j1 = (j + 1) % across;
            const std::uint32_t p = i * across + j, q = i1 * across + j, r0 = i * across + j1, s = i1 * across + j1;
            mesh.triangles.push_back({p, r0, q});
            mesh.triangles.push_back({q, r0, s});
        }
    }
    return mesh;
}

// ----------------------------------------------------------------------------------------------------------
// test rays
struct Random {
    std::mt19937 engine;
    explicit Random(std::uint32_t seed) : engine(seed) {}
    float uniform(float a, float b) { return std::uniform_real_distribution<float>(a, b)(engine); }
    std::uint32_t below(std::uint32_t n) { return std::uniform_int_distribution<std::uint32_t>(0, n - 1)(engine); }
    vec3 in_cube(float half = 1) {
        const float x = uniform(-half, half), y = uniform(-half, half), z = uniform(-half, half);
        return {x, y, z};
    }
    vec3 direction() {
        for (;;) {
            const vec3 v = in_cube();
            if (glm::dot(v, v) > 0.01f && glm::dot(v, v) <= 1) return glm::normalize(v);
        }
    }
    // Often with components that are exactly +0 or −0.
    vec3 awkward_direction() {
        for (;;) {
            vec3 v = direction();
            for (int axis = 0; axis < 3; ++axis) {
                const std::uint32_t choice = below(5);
                if (choice < 2) v[axis] = choice == 0 ? 0.0f : -0.0f;
                if (choice == 2) v[axis] *= 1e-6f;
            }
            if (glm::dot(v, v) > 1e-3f) return v;
        }
    }
};

inline kernels::Ray ray(vec3 origin, vec3 direction, float t_min = 0, float t_max = kernels::INFINITE) {
    return {origin, t_min, direction, t_max};
}

inline std::string describe(const kernels::Ray& r) {
    char text[256];
    std::snprintf(text, sizeof text, "ray {%.9g, %.9g, %.9g} t_min %.9g {%.9g, %.9g, %.9g} t_max %.9g",
                  double(r.origin.x), double(r.origin.y), double(r.origin.z), double(r.t_min), double(r.direction.x),
                  double(r.direction.y), double(r.direction.z), double(r.t_max));
    return text;
}

}  // namespace spinel::test
