// Meshes that rays walk as one. The parts of a model lie about and through each other; each with a tree of its own, a
// ray would have to walk many of them to learn what one tree over all tells it.
//
// Joined are objects in one local space, of geometries that are placed once, whose surfaces stop all light and have no
// inside: the rest of the renderer asks those one by one (kernels/locate.h, boundary.h), where the nearest must not
// hide the others. For the same reason nothing that has an inside may touch them.
#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/mesh/mesh_builder.h"
#include "scene/compilation.h"

namespace spinel {
namespace {

using kernels::uint;

constexpr std::size_t most_triangles = std::size_t(1) << 26;  // of a join
constexpr std::size_t most_neighbours = 64;                   // with an inside, that a mesh's triangles are asked about

bool overlap(const Box& a, const Box& b) {
    return glm::all(glm::lessThanEqual(a.lower, b.upper)) && glm::all(glm::lessThanEqual(b.lower, a.upper));
}

Box bounds_of(const MeshGeometry& mesh, const mat4x3& transform) {
    Box box{vec3(kernels::INFINITE), vec3(-kernels::INFINITE)};
    for (const vec3& position : mesh.positions) {
        const vec3 p = transform * vec4(position, 1);
        box.lower = glm::min(box.lower, p);
        box.upper = glm::max(box.upper, p);
    }
    return box;
}

// Where an object that may have an inside stands.
struct Hollow {
    Box bounds;                          // in world space, wider than any rounding
    std::optional<mat4x3> world_to_box;  // of boxes, whose surface is where a coordinate is ±1
};

class Finder {
  public:
    explicit Finder(const Compilation& c) : c_(c), scene_(c.scene) {
        for (const Object& object : scene_.objects)
            if (may_have_inside(scene_, object)) hollow_.push_back(hollow_of(object));
    }

    bool may_join(const Object& object) const {
        const auto* mesh = std::get_if<MeshGeometry>(&scene_.geometries[std::size_t(object.geometry)].data);
        return mesh && mesh->triangles.size() <= most_triangles && is_shell(scene_, object) &&
               !touches_hollow(*mesh, object.transform);
    }

  private:
    Hollow hollow_of(const Object& object) const {
        const auto* mesh = std::get_if<MeshGeometry>(&scene_.geometries[std::size_t(object.geometry)].data);
        const Compilation::Shape& shape = c_.shapes[std::size_t(object.geometry)];
        if (!mesh && !shape.bounded) return {{vec3(-kernels::INFINITE), vec3(kernels::INFINITE)}, {}};
        Hollow hollow;
        if (mesh) {
            hollow.bounds = bounds_of(*mesh, object.transform);
        } else {
            const mat4x3 to_world = affine_product(object.transform, shape.bake);
            hollow.bounds = world_bounds(to_world, shape.lower, shape.upper);
            if (shape.kind == kernels::GEOMETRY_BOX) hollow.world_to_box = affine_inverse(to_world);
        }
        const float size =
            kernels::max_component(glm::max(glm::abs(hollow.bounds.lower), glm::abs(hollow.bounds.upper)));
        hollow.bounds.lower -= margin * size;
        hollow.bounds.upper += margin * size;
        return hollow;
    }

    bool touches_hollow(const MeshGeometry& mesh, const mat4x3& transform) const {
        std::vector<const Hollow*> near;
        const Box bounds = bounds_of(mesh, transform);
        for (const Hollow& hollow : hollow_)
            if (overlap(hollow.bounds, bounds)) near.push_back(&hollow);
        if (near.empty()) return false;
        if (near.size() > most_neighbours) return true;
        return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const uvec3& triangle) {
            Box box{vec3(kernels::INFINITE), vec3(-kernels::INFINITE)};
            for (int corner = 0; corner < 3; ++corner) {
                if (triangle[corner] >= mesh.positions.size()) return true;  // refused when it is built
                const vec3 p = transform * vec4(mesh.positions[triangle[corner]], 1);
                box.lower = glm::min(box.lower, p);
                box.upper = glm::max(box.upper, p);
            }
            return std::any_of(near.begin(), near.end(), [&](const Hollow* hollow) { return touches(*hollow, box); });
        });
    }

    static bool touches(const Hollow& hollow, const Box& box) {
        if (!overlap(hollow.bounds, box)) return false;
        if (!hollow.world_to_box) return true;
        // Well inside of a box of fog is not on its surface.
        const Box local = world_bounds(*hollow.world_to_box, box.lower, box.upper);
        const float most = kernels::max_component(glm::max(glm::abs(local.lower), glm::abs(local.upper)));
        return !(most < 1 - margin);
    }

    static constexpr float margin = 1e-4f;

    const Compilation& c_;
    const Scene& scene_;
    std::vector<Hollow> hollow_;
};

bool is_joinable(const AcceleratorChoice& choice) {
    const uint walk = choice.structure->walk;
    return (walk == kernels::MESH_WALK_WIDE || walk == kernels::MESH_WALK_COMPACT) &&
           choice.test->test == kernels::TRIANGLE_WATERTIGHT;
}

std::size_t triangle_count(const Scene& scene, uint object) {
    const Geometry& geometry = scene.geometries[std::size_t(scene.objects[object].geometry)];
    return std::get<MeshGeometry>(geometry.data).triangles.size();
}

}  // namespace

void find_joins(Compilation& c, const AcceleratorChoice& choice) {
    const Scene& scene = c.scene;
    if (!is_joinable(choice)) return;
    std::vector<int> uses(scene.geometries.size(), 0);
    for (const Object& object : scene.objects) ++uses[std::size_t(object.geometry)];
    struct Begun {
        Compilation::Join join;
        std::size_t triangles = 0;
    };
    std::vector<Begun> begun;  // one for each transform
    const Finder finder(c);
    const auto keep = [&](Begun& full) {
        if (full.join.objects.size() > 1) c.joins.push_back(std::move(full.join));
        full = {};
    };
    for (uint i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        if (uses[std::size_t(object.geometry)] != 1 || !finder.may_join(object)) continue;
        auto to = std::find_if(begun.begin(), begun.end(), [&](const Begun& b) {
            return scene.objects[b.join.objects[0]].transform == object.transform;
        });
        if (to == begun.end()) to = begun.insert(begun.end(), Begun{});
        const std::size_t count = triangle_count(scene, i);
        if (to->triangles + count > most_triangles) keep(*to);
        to->join.objects.push_back(i);
        to->triangles += count;
    }
    for (Begun& rest : begun) keep(rest);
    for (const Compilation::Join& join : c.joins)
        for (const uint object : join.objects) c.joined[object] = true;
}

Result<void> build_join(Compilation& c, Compilation::Join& join, const AcceleratorChoice& choice) {
    CompiledScene& out = c.out;
    kernels::Mesh record = {};
    record.triangle_first = uint(out.triangles.size());
    record.lower = vec3(kernels::INFINITE);
    record.upper = vec3(-kernels::INFINITE);
    for (const uint object : join.objects) {
        const auto index = std::size_t(c.scene.objects[object].geometry);
        const Geometry& geometry = c.scene.geometries[index];
        const auto& mesh = std::get<MeshGeometry>(geometry.data);
        Result<MeshData> data = read_mesh(mesh, choice);
        if (data) data->walk = kernels::MESH_WALK_JOINED;
        const Result<Compilation::Shape> shape = add_mesh(c, geometry.name, mesh, data);
        if (!shape) return shape.error();
        c.shapes[index] = *shape;
        const kernels::Mesh& part = out.meshes.back();
        record.lower = glm::min(record.lower, part.lower);
        record.upper = glm::max(record.upper, part.upper);
        record.triangle_count += part.triangle_count;
    }
    Result<MeshStructureData> built =
        build_structure(std::span(out.triangles).subspan(record.triangle_first, record.triangle_count), choice);
    if (!built) return built.error();
    record.walk = choice.structure->walk;
    record.triangle_test = choice.test->test;
    for (uint* attribute :
         {&record.normal_first, &record.uv_first, &record.second_uv_first, &record.tangent_first, &record.color_first})
        *attribute = kernels::NONE;
    const Result<uint> first = append_pool(out.wide_units, built->arrays.wide_units, "units of wide trees");
    if (!first) return first.error();
    record.node_first = *first;
    join.mesh = uint(out.meshes.size());
    out.meshes.push_back(record);
    built->statistics.bytes = built->arrays.wide_units.size() * sizeof(kernels::WideUnit);
    out.mesh_statistics.push_back(built->statistics);
    return {};
}

Result<void> name_leaders(Compilation& c) {
    for (const Compilation::Join& join : c.joins) {
        kernels::Instance& leader = c.out.instances[join.objects[0]];
        const Result<uint> first = append_pool(c.out.words, join.objects, WORDS);
        if (!first) return first.error();
        leader.joined_mesh = join.mesh;
        leader.member_first = *first;
        leader.member_count = uint(join.objects.size());
    }
    return {};
}

}  // namespace spinel
