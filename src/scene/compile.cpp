#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>

#include "accel/bvh_builder.h"
#include "geometry/mesh/mesh_builder.h"
#include "geometry/sdf/sdf_builder.h"
#include "geometry/volume/surface_builder.h"
#include "geometry/voxels/voxel_builder.h"
#include "kernels/camera.h"
#include "kernels/locate.h"
#include "kernels/microfacet_tables.h"
#include "kernels/traverse.h"
#include "scene/compilation.h"
#include "scene/validate.h"

namespace spinel {

using kernels::NONE;
using kernels::uint;

mat4x3 affine_product(const mat4x3& a, const mat4x3& b) { return mat4x3(glm::mat4(a) * glm::mat4(b)); }

mat4x3 affine_inverse(const mat4x3& m) {
    // In double precision: instances may sit far from the origin.
    return mat4x3(glm::dmat4x3(glm::inverse(glm::dmat4(glm::dmat4x3(m)))));
}

bool is_similarity(const mat4x3& t) {
    const float xx = glm::dot(t[0], t[0]), yy = glm::dot(t[1], t[1]), zz = glm::dot(t[2], t[2]);
    const float tolerance = 2e-4f * xx;
    return std::abs(yy - xx) <= tolerance && std::abs(zz - xx) <= tolerance &&
           std::abs(glm::dot(t[0], t[1])) <= tolerance && std::abs(glm::dot(t[0], t[2])) <= tolerance &&
           std::abs(glm::dot(t[1], t[2])) <= tolerance;
}

kernels::SceneView CompiledScene::view() const {
    kernels::SceneView v = {};
    v.instances.at = instances.data();
    v.instance_nodes.at = instance_nodes.data();
    v.instance_order.at = instance_order.data();
    v.contacts.at = contacts.data();
    v.slots.at = slots.data();
    v.nodes.at = nodes.data();
    v.kd_nodes.at = kd_nodes.data();
    v.sphere_nodes.at = sphere_nodes.data();
    v.mesh_grids.at = mesh_grids.data();
    v.wide_units.at = wide_units.data();
    v.unit_triangles.at = unit_triangles.data();
    v.positions.at = positions.data();
    v.triangles.at = triangles.data();
    v.triangle_infos.at = triangle_infos.data();
    v.normals.at = normals.data();
    v.uvs.at = uvs.data();
    v.tangents.at = tangents.data();
    v.colors.at = colors.data();
    v.meshes.at = meshes.data();
    v.voxel_grids.at = voxel_grids.data();
    v.voxel_nodes.at = voxel_nodes.data();
    v.voxel_mips.at = voxel_mips.data();
    v.sdf_ops.at = sdf_ops.data();
    v.sdfs.at = sdfs.data();
    v.interiors.at = interiors.data();
    v.media.at = media.data();
    v.grids.at = grids.data();
    v.materials.at = materials.data();
    v.textures.at = textures.data();
    v.lights.at = lights.data();
    v.light_table.at = light_table.data();
    v.words.at = words.data();
    v.floats.at = floats.data();
    v.environment = environment;
    v.preview_light = preview_light;
    v.camera = camera;
    v.instance_count = uint(instances.size());
    v.bounded_count = bounded_count;
    v.unbounded_count = uint(instance_order.size()) - bounded_count;
    v.light_count = uint(light_table.size());
    v.infinite_light_count = infinite_light_count;
    v.pass_through_count = pass_through_count;
    v.camera_inside_count = camera_inside_count;
    v.camera_inside_first = camera_inside_first;
    v.microfacet_first = microfacet_first;
    v.mip_first = mip_first;
    v.mip_edge = mip_edge;
    return v;
}

Box world_bounds(const mat4x3& m, vec3 lower, vec3 upper) {
    const vec3 center = m * vec4(0.5f * (lower + upper), 1), half = 0.5f * (upper - lower);
    const vec3 extent = glm::abs(m[0]) * half.x + glm::abs(m[1]) * half.y + glm::abs(m[2]) * half.z;
    const vec3 pad = 4e-7f * (glm::abs(center) + extent + glm::abs(m[3]));
    return {center - extent - pad, center + extent + pad};
}

namespace {

using Shape = Compilation::Shape;

Error of_geometry(const std::string& name, const Error& error) {
    return {fmt::format("geometry '{}': {}", name, error.message)};
}

// Whether every ray that meets the material is stopped by it.
bool is_solid(const Scene& scene, int material) {
    if (material < 0) return false;
    const kernels::Material& m = scene.materials[std::size_t(material)].values;
    return m.opacity >= 1 && m.opacity_texture == NONE;
}

}  // namespace

bool is_shell(const Scene& scene, const Object& object) {
    return !object.materials.empty() && std::all_of(object.materials.begin(), object.materials.end(), [&](int m) {
        return is_solid(scene, m) && scene.materials[std::size_t(m)].values.kind != kernels::MATERIAL_DIELECTRIC;
    });
}

bool may_have_inside(const Scene& scene, const Object& object) {
    if (object.materials.empty()) return object.interior >= 0;
    const bool voxels = std::holds_alternative<VoxelGeometry>(scene.geometries[std::size_t(object.geometry)].data) ||
                        std::holds_alternative<SdfVoxelGeometry>(scene.geometries[std::size_t(object.geometry)].data);
    return std::any_of(object.materials.begin(), object.materials.end(), [&](int material) {
        if (material < 0) return object.interior >= 0;
        const kernels::Material& m = scene.materials[std::size_t(material)].values;
        return m.kind == kernels::MATERIAL_DIELECTRIC ||
               (!is_solid(scene, material) && (voxels || object.interior >= 0 || m.interior != NONE));
    });
}

Result<Compilation::Shape> add_mesh(Compilation& c, const std::string& name, const MeshGeometry& mesh,
                                    const Result<MeshData>& data) {
    if (!data) return of_geometry(name, data.error());
    if (data->triangles.empty()) return Error{fmt::format("geometry '{}' has no triangle with an area", name)};
    const Result<kernels::Mesh> record = append_mesh(c.out, mesh, *data);
    if (!record) return of_geometry(name, record.error());
    Shape shape;
    shape.kind = kernels::GEOMETRY_MESH;
    shape.index = uint(c.out.meshes.size());
    shape.lower = data->bounds.lower;
    shape.upper = data->bounds.upper;
    c.out.meshes.push_back(*record);
    c.out.mesh_statistics.push_back(data->statistics);
    return shape;
}

namespace {

mat4x3 scaling(vec3 s) { return mat4x3(vec3(s.x, 0, 0), vec3(0, s.y, 0), vec3(0, 0, s.z), vec3(0)); }

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

Shape unit_shape(uint kind, const mat4x3& bake, vec3 upper = vec3(1)) {
    Shape shape;
    shape.kind = kind;
    shape.bake = bake;
    shape.lower = -upper;
    shape.upper = upper;
    return shape;
}

struct ShapeBuilder {
    Compilation& c;
    const std::string& name;
    std::size_t geometry;

    Error fail(const Error& error) const { return of_geometry(name, error); }

    Result<uint> append_sdf(SdfData& data) const {
        const Result<uint> first = append_pool(c.out.sdf_ops, data.ops, "operations of implicit surfaces");
        if (!first) return first.error();
        data.sdf.op_first = *first;
        c.out.sdfs.push_back(data.sdf);
        return uint(c.out.sdfs.size() - 1);
    }

    Result<Shape> operator()(const MeshGeometry& mesh) const {
        return add_mesh(c, name, mesh, build_mesh(mesh, c.accelerator));
    }
    Result<Shape> operator()(const VoxelGeometry& voxels) const {
        const VoxelTree& tree = *c.trees[geometry];
        Shape shape;
        shape.kind = kernels::GEOMETRY_VOXELS;
        shape.index = uint(c.out.voxel_grids.size());
        const VoxelTree::Arrays& arrays = tree.arrays();
        for (const auto& place :
             {pool_place(c.out.voxel_nodes.size(), arrays.nodes.size(), "nodes of voxels"),
              pool_place(c.out.words.size(), arrays.palettes.size() + arrays.references.size(), WORDS)})
            if (!place) return fail(place.error());
        kernels::VoxelGrid grid = append_voxels(tree, c.out.voxel_nodes, c.out.words);
        append_shapes(voxels, grid, c.out.floats);
        if (voxels.outlines) append_outlines(*voxels.outlines, grid, c.out.floats);
        if (const Result<uint> end = pool_place(c.out.floats.size(), 0, NUMBERS); !end) return fail(end.error());
        c.out.voxel_grids.push_back(grid);
        shape.upper = vec3(tree.size());
        return shape;
    }
    Result<Shape> operator()(const SdfGeometry& sdf) const {
        Result<SdfData> data = build_sdf(sdf);
        return data ? sdf_shape(*data) : fail(data.error());
    }
    Result<Shape> sdf_shape(SdfData& data) const {
        const Result<uint> index = append_sdf(data);
        if (!index) return fail(index.error());
        Shape shape;
        shape.kind = kernels::GEOMETRY_SDF;
        shape.index = *index;
        shape.lower = data.sdf.lower;
        shape.upper = data.sdf.upper;
        return shape;
    }
    Result<Shape> surface_of(const VolumeGeometry& volume, const Grid& grid) const {
        const Result<uint> index = add_grid(c, volume.grid);
        if (!index) return index.error();
        Result<SdfData> data = build_surface(volume, c.out.grids[*index], *index, c.out.words, c.out.floats);
        if (!data) return Error{fmt::format("volume '{}' {}", name, data.error().message)};
        Result<Shape> shape = sdf_shape(*data);
        if (shape) shape->bake = grid.index_to_local;
        return shape;
    }
    Result<Shape> operator()(const SdfVoxelGeometry& voxels) const {
        Result<SdfData> data = build_sdf(voxels.sdf);
        if (!data) return fail(data.error());
        const Result<uint> sdf = append_sdf(*data);
        if (!sdf) return fail(sdf.error());
        Result<kernels::VoxelGrid> grid = append_sdf_voxels(voxels, data->sdf, *sdf, c.out.floats);
        if (!grid) return Error{fmt::format("geometry '{}' {}", name, grid.error().message)};
        if (voxels.outlines) append_outlines(*voxels.outlines, *grid, c.out.floats);
        if (const Result<uint> end = pool_place(c.out.floats.size(), 0, NUMBERS); !end) return fail(end.error());
        Shape shape;
        shape.kind = kernels::GEOMETRY_VOXELS;
        shape.index = uint(c.out.voxel_grids.size());
        shape.bake = scaling(vec3(voxels.cell));
        shape.bake[3] = grid->sdf_origin;
        shape.upper = vec3(grid->size);
        c.out.voxel_grids.push_back(*grid);
        return shape;
    }
    // The box of a grid; what is in it comes from the object's interior medium.
    Result<Shape> operator()(const VolumeGeometry& volume) const {
        const Grid& grid = c.scene.grids[std::size_t(volume.grid)];
        if (volume.surface) return surface_of(volume, grid);
        const vec3 half = 0.5f * vec3(grid.samples->size());
        mat4x3 box = scaling(half);
        box[3] = half;
        return unit_shape(kernels::GEOMETRY_BOX, affine_product(grid.index_to_local, box));
    }
    Result<Shape> operator()(const SphereGeometry& sphere) const {
        return unit_shape(kernels::GEOMETRY_SPHERE, scaling(vec3(sphere.radius)));
    }
    Result<Shape> operator()(const BoxGeometry& box) const {
        return unit_shape(kernels::GEOMETRY_BOX, scaling(0.5f * box.size));
    }
    Result<Shape> operator()(const RectangleGeometry& rectangle) const {
        return unit_shape(kernels::GEOMETRY_RECTANGLE, scaling({0.5f * rectangle.size.x, 1, 0.5f * rectangle.size.y}),
                          {1, 0, 1});
    }
    Result<Shape> operator()(const PlaneGeometry&) const {
        Shape shape = unit_shape(kernels::GEOMETRY_PLANE, mat4x3(1));
        shape.bounded = false;
        return shape;
    }
};

// All geometries that are used. Meshes come last: which of them are joined depends on what lies among them.
Result<void> add_shapes(Compilation& c, bool has_camera, bool join_meshes) {
    const Scene& scene = c.scene;
    c.trees.resize(scene.geometries.size());
    c.shapes.resize(scene.geometries.size());
    std::vector<bool> due(scene.geometries.size(), false);
    for (const Object& object : scene.objects) due[std::size_t(object.geometry)] = true;
    const auto add = [&](std::size_t i) -> Result<void> {
        const Geometry& geometry = scene.geometries[i];
        if (std::holds_alternative<VoxelGeometry>(geometry.data))
            c.trees[i] = detailed_voxels(scene, i, has_camera ? &c.out.camera : nullptr);
        const Result<Shape> shape = std::visit(ShapeBuilder{c, geometry.name, i}, geometry.data);
        if (!shape) return shape.error();
        c.shapes[i] = *shape;
        due[i] = false;
        return {};
    };
    for (std::size_t i = 0; i < scene.geometries.size(); ++i)
        if (due[i] && !std::holds_alternative<MeshGeometry>(scene.geometries[i].data))
            if (Result<void> added = add(i); !added) return added;
    c.joined.assign(scene.objects.size(), false);
    const Result<AcceleratorChoice> choice = choose_accelerator(c.accelerator);
    if (choice && join_meshes) find_joins(c, *choice);  // without a choice the first mesh tells why
    for (Compilation::Join& join : c.joins) {
        if (Result<void> built = build_join(c, join, *choice); !built) return built;
        for (const uint object : join.objects) due[std::size_t(scene.objects[object].geometry)] = false;
    }
    for (std::size_t i = 0; i < scene.geometries.size(); ++i)
        if (due[i])
            if (Result<void> added = add(i); !added) return added;
    for (std::size_t i = 0; i < scene.geometries.size(); ++i)
        c.shapes[i].slot_count = std::max<std::size_t>(slot_count(scene.geometries[i]), 1);
    return {};
}

// What is inside a slot of an object: the object's own interior before the material's.
Result<uint> slot_interior(Compilation& c, const Object& object, const Shape& shape, int material) {
    kernels::Interior interior;
    std::memset(&interior, 0, sizeof interior);
    interior.medium = NONE;
    int medium = object.interior;
    vec3 absorption(0);
    if (material >= 0) {
        const kernels::Material& m = c.scene.materials[std::size_t(material)].values;
        if (m.kind == kernels::MATERIAL_DIELECTRIC) {
            interior.ior = m.ior;
            interior.priority = m.priority;
            absorption = m.absorption;
        }
        if (medium < 0 && m.interior != NONE) medium = int(m.interior);
        if (interior.ior == 0 && is_solid(c.scene, material)) return NONE;  // nothing ever gets inside
    }
    if (medium >= 0) {
        const Result<uint> added = add_scene_medium(c, medium, object.transform);
        if (!added) return added.error();
        interior.medium = *added;
    } else if (!kernels::is_black(absorption)) {
        kernels::Medium beer;
        std::memset(&beer, 0, sizeof beer);
        beer.absorption = absorption;
        beer.grid = NONE;
        beer.world_to_grid = mat4x3(1);
        beer.density_scale = 1;
        beer.albedo_grid = NONE;
        beer.world_to_albedo = mat4x3(1);
        beer.temperature_grid = NONE;
        beer.world_to_temperature = mat4x3(1);
        beer.flags = kernels::MEDIUM_ABSORBS_ONLY;
        interior.medium = add_medium(c, beer);
    }
    if (interior.medium == NONE && interior.ior == 0) {
        // A voxel that lets rays pass is a region of its own: a ray that begins in it must not meet it again.
        if (shape.kind != kernels::GEOMETRY_VOXELS || material < 0) return NONE;
        interior.priority = -1 - material;
    }
    return add_interior(c, interior);
}

// Emission of heterogeneous media is found at collisions; where a medium does not scatter or absorb, null collisions at
// this rate find it: about eight on the way through all that is bounded.
float emission_rate(const Compilation& c) {
    vec3 lower(1e30f), upper(-1e30f);
    for (const Object& object : c.scene.objects) {
        const Shape& shape = c.shapes[std::size_t(object.geometry)];
        if (!shape.bounded) continue;
        const Box box = world_bounds(affine_product(object.transform, shape.bake), shape.lower, shape.upper);
        lower = glm::min(lower, box.lower);
        upper = glm::max(upper, box.upper);
    }
    const float extent = glm::length(upper - lower);
    return lower.x <= upper.x && extent > 0 ? 8 / extent : 0;
}

Result<void> add_instance(Compilation& c, std::size_t index) {
    const Object& object = c.scene.objects[index];
    const Shape& shape = c.shapes[std::size_t(object.geometry)];
    kernels::Instance instance = {};
    instance.object_to_world = affine_product(object.transform, shape.bake);
    instance.world_to_object = affine_inverse(instance.object_to_world);
    instance.geometry_kind = shape.kind;
    instance.geometry = shape.index;
    const Result<uint> first = pool_place(c.out.slots.size(), shape.slot_count, "slots of objects for materials");
    if (!first) return first.error();
    instance.slot_first = *first;
    instance.light_first = NONE;
    instance.object = uint(index);
    for (std::size_t s = 0; s < shape.slot_count; ++s) {
        const int material = object.materials.empty()       ? -1
                             : object.materials.size() == 1 ? object.materials[0]
                                                            : object.materials[s];
        const Result<uint> interior = slot_interior(c, object, shape, material);
        if (!interior) return interior.error();
        const kernels::Slot slot{material < 0 ? NONE : uint(material), *interior};
        c.out.slots.push_back(slot);
        if (!is_solid(c.scene, material)) instance.flags |= kernels::INSTANCE_PASS_THROUGH;
        if (slot.interior != NONE && shape.kind != kernels::GEOMETRY_VOXELS)
            instance.flags |= kernels::INSTANCE_ENCLOSES;
    }
    if (instance.flags & kernels::INSTANCE_PASS_THROUGH) ++c.out.pass_through_count;
    c.out.instances.push_back(instance);
    return {};
}

// Bounded instances under a BVH, the others behind them in the order; of joined ones those that lead. Objects keep
// their indices.
void build_top_level(Compilation& c) {
    CompiledScene& out = c.out;
    std::vector<Box> boxes;
    std::vector<uint> bounded, unbounded;
    for (uint i = 0; i < out.instances.size(); ++i) {
        const Shape& shape = c.shapes[std::size_t(c.scene.objects[i].geometry)];
        if (!shape.bounded) {
            unbounded.push_back(i);
            continue;
        }
        if (c.joined[i]) continue;
        bounded.push_back(i);
        boxes.push_back(world_bounds(out.instances[i].object_to_world, shape.lower, shape.upper));
    }
    for (const Compilation::Join& join : c.joins) {
        const kernels::Mesh& mesh = out.meshes[join.mesh];
        bounded.push_back(join.objects[0]);
        boxes.push_back(world_bounds(out.instances[join.objects[0]].object_to_world, mesh.lower, mesh.upper));
    }
    std::vector<Box> widened = boxes;  // as kernels::instance_slab_ray() has it
    for (Box& box : widened) {
        const vec3 pad(kernels::slab_padding(box.lower, box.upper, vec3(0)));
        box = {box.lower - pad, box.upper + pad};
    }
    const Bvh bvh = build_bvh(widened, {.max_leaf = 1});
    out.instance_nodes = bvh.nodes;
    for (const uint i : bvh.order) out.instance_order.push_back(bounded[i]);
    out.bounded_count = uint(bvh.order.size());
    append(out.instance_order, unbounded);
    if (!boxes.empty()) {
        out.lower = boxes[0].lower;
        out.upper = boxes[0].upper;
        for (const Box& box : boxes) {
            out.lower = glm::min(out.lower, box.lower);
            out.upper = glm::max(out.upper, box.upper);
        }
    }
}

uint kernel_filter(PixelFilter filter) {
    switch (filter) {
        case PixelFilter::box: return kernels::PIXEL_FILTER_BOX;
        case PixelFilter::tent: return kernels::PIXEL_FILTER_TENT;
        case PixelFilter::gaussian: return kernels::PIXEL_FILTER_GAUSSIAN;
        case PixelFilter::blackman_harris: break;
    }
    return kernels::PIXEL_FILTER_BLACKMAN_HARRIS;
}

kernels::Camera kernel_camera(const Camera& camera, const Film& film) {
    kernels::Camera k = {};
    k.kind = camera.kind == Camera::Kind::orthographic ? kernels::CAMERA_ORTHOGRAPHIC : kernels::CAMERA_PERSPECTIVE;
    const vec3 z = glm::normalize(camera.from - camera.at);
    const vec3 x = glm::normalize(glm::cross(camera.up, z));
    const vec3 y = glm::cross(z, x);
    k.camera_to_world = mat4x3(camera.mirrored ? -x : x, y, z, camera.from);
    k.half_height =
        camera.kind == Camera::Kind::orthographic ? 0.5f * camera.height : std::tan(0.5f * glm::radians(camera.fov));
    k.lens_radius = camera.lens_radius;
    k.focus_distance = camera.focus_distance > 0 ? camera.focus_distance : glm::length(camera.at - camera.from);
    k.resolution = {film.size.x, film.size.y};
    k.filter_radius = film.filter_radius;
    k.filter_kind = kernel_filter(film.filter);
    return k;
}

// What the camera's rays start inside of: found once, or, where the ends of a lens or the corners of an orthographic
// picture disagree, ray by ray.
Result<void> place_camera_inside(Compilation& c, const Camera& camera) {
    CompiledScene& out = c.out;
    const kernels::Inside inside = kernels::interiors_at(out.view(), camera.from);
    if (inside.dropped > 0)
        return Error{fmt::format("the camera lies in more than {} nested objects", kernels::MAX_INSIDE)};
    const kernels::Camera& k = out.camera;
    const bool flat = k.kind == kernels::CAMERA_ORTHOGRAPHIC;
    const float y = flat ? k.half_height : k.lens_radius;
    const float x = flat ? k.half_height * float(k.resolution.x) / float(k.resolution.y) : k.lens_radius;
    if (flat || k.lens_radius > 0)
        for (int i = 0; i < 9; ++i) {
            const int column = i % 3 - 1, row = i / 3 - 1;
            const vec3 p = k.camera_to_world * vec4(x * float(column), y * float(row), 0, 1);
            const kernels::Inside there = kernels::interiors_at(out.view(), p);
            if (there.count != inside.count || !std::equal(there.entries, there.entries + there.count, inside.entries))
                out.camera.locate_rays = 1;
        }
    const Result<uint> first = append_pool(out.words, std::span(inside.entries, inside.count), WORDS);
    if (!first) return first.error();
    out.camera_inside_first = *first;
    out.camera_inside_count = inside.count;
    return {};
}

Result<Camera> choose_camera(const Scene& scene, const std::string& name) {
    if (scene.cameras.empty()) return Error{"the scene has no camera"};
    if (name.empty()) return scene.cameras.front();
    std::string available;
    for (const Camera& camera : scene.cameras) {
        if (camera.name == name) return camera;
        if (!camera.name.empty()) available += (available.empty() ? "'" : ", '") + camera.name + "'";
    }
    if (available.empty())
        return Error{fmt::format("no camera '{}': the scene's cameras have no names, and the first is the one", name)};
    return Error{fmt::format("no camera '{}'; available: {}", name, available)};
}

}  // namespace

Result<CompiledScene> compile(const Scene& scene, const CompileOptions& options) {
    if (Result<void> valid = validate(scene); !valid) return valid.error();
    Compilation c{.scene = scene};
    c.grid_of.assign(scene.grids.size(), NONE);
    CompiledScene& out = c.out;
    out.film = scene.film;
    if (options.size.x > 0 && options.size.y > 0) out.film.size = options.size;
    out.integrator = scene.integrator;
    c.accelerator = scene.accelerator;
    if (!options.accelerator.structure.empty()) {
        c.accelerator.structure = options.accelerator.structure;
        c.accelerator.preset.clear();
    }
    if (!options.accelerator.preset.empty()) c.accelerator.preset = options.accelerator.preset;
    if (!options.accelerator.triangle_test.empty()) c.accelerator.triangle_test = options.accelerator.triangle_test;

    std::optional<Camera> camera;
    if (!scene.cameras.empty() || !options.camera.empty()) {
        const Result<Camera> chosen = choose_camera(scene, options.camera);
        if (!chosen) return chosen.error();
        camera = *chosen;
        out.camera = kernel_camera(*camera, out.film);
    }

    if (Result<void> added = add_textures(c); !added) return added.error();
    for (const Material& material : scene.materials) out.materials.push_back(material.values);
    if (Result<void> added = add_shapes(c, camera.has_value(), options.join_meshes); !added) return added.error();
    c.emission_rate = emission_rate(c);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        if (Result<void> added = add_instance(c, i); !added) return added.error();
        out.object_names.push_back(scene.objects[i].name);
    }
    if (Result<void> named = name_leaders(c); !named) return named.error();
    build_top_level(c);
    if (Result<void> found = find_contacts(c); !found) return found.error();
    if (Result<void> added = add_environment(c); !added) return added.error();
    const Result<uint> table = append_pool(out.words, kernels::MICROFACET_TABLE, WORDS);
    if (!table) return table.error();
    out.microfacet_first = *table;
    add_infinite_and_point_lights(c);
    if (Result<void> added = add_surface_lights(c); !added) return added.error();
    build_light_table(out);
    add_preview_light(c);
    if (wants_voxel_mips(scene.integrator, options.integrator))
        if (Result<void> added = add_voxel_mips(c); !added) return added.error();
    if ((options.integrator.empty() ? scene.integrator.name : options.integrator) == "dvr")
        if (Result<void> added = add_dvr(c); !added) return added.error();
    if (camera)
        if (Result<void> placed = place_camera_inside(c, *camera); !placed) return placed.error();
    return std::move(c.out);
}

}  // namespace spinel
