#pragma once
// The workbench of compile(): the scene being read, the flat arrays being filled, and what is already there.
// One file for each kind of thing; compile.cpp calls them in order.

#include <map>
#include <vector>

#include "accel/bvh_builder.h"
#include "core/pool.h"
#include "geometry/mesh/mesh_builder.h"
#include "scene/compiled_scene.h"

namespace spinel {

struct Compilation {
    const Scene& scene;
    CompiledScene out = {};
    AcceleratorSettings accelerator = {};
    std::map<kernels::uint, Bvh> mesh_bounds =
        {};                                   // of triangles, for meshes whose structure is no BVH; made when asked
    std::vector<kernels::uint> grid_of = {};  // Scene::grids → DensityGrids, NONE until used
    float emission_rate = 0;  // for emissive media, per unit length: some collisions on the way through the scene
    std::map<int, kernels::Medium> majorants = {};    // of Scene::media: where their bounds stand
    std::map<std::string, kernels::uint> media = {};  // records by their bytes, so that equals share one
    std::map<std::string, kernels::uint> interiors = {};

    // A geometry compiled once, however often it is placed.
    struct Shape {
        kernels::uint kind = kernels::NONE;
        kernels::uint index = 0;
        mat4x3 bake = mat4x3(1);  // the kernel's unit shape to the user's local space
        vec3 lower = {0, 0, 0};   // bounds in the kernel's local space
        vec3 upper = {0, 0, 0};
        bool bounded = true;
        std::size_t slot_count = 1;
    };
    std::vector<Shape> shapes = {};            // parallel to Scene::geometries
    std::vector<VoxelTreePointer> trees = {};  // of voxel sets, as they are rendered; parallel to Scene::geometries

    // Meshes that rays walk as one.
    struct Join {
        std::vector<kernels::uint> objects;  // in order; the first leads
        kernels::uint mesh = 0;              // of all their triangles
    };
    std::vector<Join> joins = {};
    std::vector<bool> joined = {};  // parallel to Scene::objects
};

// What the pools that several things share hold, for messages.
constexpr const char* WORDS = "words of voxels, volumes, textures and tables";
constexpr const char* NUMBERS = "numbers of volumes and environment";

// compile.cpp: whether nothing of an object lets light pass, or has an inside; and whether any of it may have one.
bool is_shell(const Scene& scene, const Object& object);
bool may_have_inside(const Scene& scene, const Object& object);
// The record of a mesh in the pools, with its statistics; `data` may be an error, which is then told of the geometry.
Result<Compilation::Shape> add_mesh(Compilation& c, const std::string& name, const MeshGeometry& mesh,
                                    const Result<MeshData>& data);

// compile_joins.cpp: which meshes are joined, after all other shapes are known; their records, shapes and the structure
// over them; and, after the instances, what leads them.
void find_joins(Compilation& c, const AcceleratorChoice& choice);
Result<void> build_join(Compilation& c, Compilation::Join& join, const AcceleratorChoice& choice);
Result<void> name_leaders(Compilation& c);

// compile_textures.cpp
Result<void> add_textures(Compilation& c);
// Mean linear rgb of a texture, on one face of a cube where it differs by face; 1 for NONE.
vec3 mean_color(const CompiledScene& out, kernels::uint texture, kernels::uint face);

// compile_media.cpp: an index into grids, of one of Scene::grids (−1: NONE).
Result<kernels::uint> add_grid(Compilation& c, int index);
// An index into media or interiors, shared among equals.
kernels::uint add_medium(Compilation& c, const kernels::Medium& medium);
Result<kernels::uint> add_scene_medium(Compilation& c, int medium, const mat4x3& object_to_world);
kernels::uint add_interior(Compilation& c, const kernels::Interior& interior);

// compile_contacts.cpp: bound of the rounding error of positions on a surface within bounds in local space.
float bounded_position_error(const mat4x3& object_to_world, vec3 lower, vec3 upper);
// Where surfaces of two instances may lie in the same place; after the top-level BVH is built.
Result<void> find_contacts(Compilation& c);

// compile_environment.cpp: the environment image with its sampling tables, and its light.
Result<void> add_environment(Compilation& c);

// compile_lights.cpp: lights without a surface, emitters of the instances, the alias table.
void add_infinite_and_point_lights(Compilation& c);
Result<void> add_surface_lights(Compilation& c);
void build_light_table(CompiledScene& out);

// compile_preview.cpp: what only the preview integrators look at; after materials, instances and lights.
void add_preview_light(Compilation& c);
bool wants_voxel_mips(const IntegratorSettings& settings, const std::string& integrator);
Result<void> add_voxel_mips(Compilation& c);

// compile_detail.cpp: the voxel set of a geometry as the camera needs it, by its level of detail.
VoxelTreePointer detailed_voxels(const Scene& scene, std::size_t geometry, const kernels::Camera* camera);

// compile_dvr.cpp: the transfer function and what `dvr` needs besides; after the instances.
Result<void> add_dvr(Compilation& c);

mat4x3 affine_product(const mat4x3& a, const mat4x3& b);
mat4x3 affine_inverse(const mat4x3& m);
// World bounds of a local box under an affine transform (Arvo 1990), padded by rounding.
Box world_bounds(const mat4x3& m, vec3 lower, vec3 upper);

}  // namespace spinel
