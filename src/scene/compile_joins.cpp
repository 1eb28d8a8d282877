// Meshes that rays walk as one. The parts of a model lie about and through each other; each with a tree of its own, a
// ray would have to walk many of them to learn what one tree over all tells it.
//
// Joined are objects in one local space, of geometries that are placed once, whose surfaces stop all light and have no
// inside: the rest of the renderer asks those one by one (kernels/locate.h, boundary.h), where the nearest must not
// hide the others. For the same reason nothing that may have an inside touches them. And they are of like size: the
// boxes of a tree are widened by what rounds over its whole extent (kernels/box.h), which must stay small beside its
// triangles.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "geometry/mesh/mesh_builder.h"
#include "scene/boxes.h"
#include "scene/compilation.h"

namespace spinel {
namespace {

using kernels::uint;

constexpr std::size_t most_triangles = std::size_t(1) << 24;  // of a join, which every layout can address
constexpr std::size_t most_neighbours = 64;                   // with an inside, that a mesh's triangles are asked about
constexpr float least_edge = 8e-6f;  // mean edge of a member's triangles to the reach of all: four times the padding

bool overlap(const Box& a, const Box& b) { return !is_empty(intersection(a, b)); }

Box bounds_of(const MeshGeometry& mesh) {
    Box box = empty_box;
    for (const vec3& p : mesh.positions) box = {glm::min(box.lower, p), glm::max(box.upper, p)};
    return box;
}

const MeshGeometry* mesh_of(const Scene& scene, const Object& object) {
    return std::get_if<MeshGeometry>(&scene.geometries[std::size_t(object.geometry)].data);
}

// A mesh that may be joined, in its local space.
struct Candidate {
    uint object;
    Box bounds;
    float edge = 0;  // of its triangles, the mean; 0: an index is wrong, which is told when the mesh is built
};

Candidate candidate_of(const Scene& scene, uint object) {
    const MeshGeometry& mesh = *mesh_of(scene, scene.objects[object]);
    Candidate c{object, bounds_of(mesh)};
    double sum = 0;
    for (const uvec3& t : mesh.triangles) {
        if (std::max({t.x, t.y, t.z}) >= mesh.positions.size()) return c;
        for (int corner = 0; corner < 3; ++corner)
            sum += double(glm::distance(mesh.positions[t[corner]], mesh.positions[t[(corner + 1) % 3]]));
    }
    c.edge = float(sum / (3 * double(mesh.triangles.size())));
    return c;
}

// Where an object that may have an inside stands.
struct Hollow {
    Box bounds;                          // in world space
    float error;                         // of positions on its surface
    std::optional<mat4x3> world_to_box;  // of boxes, whose surface is where a coordinate is ±1
};

class Hollows {
  public:
    explicit Hollows(const Compilation& c) : c_(c), mesh_bounds_(c.scene.geometries.size()) {
        for (const Object& object : c.scene.objects)
            if (may_have_inside(c.scene, object)) hollows_.push_back(hollow_of(object));
    }

    // Whether the surface of one may lie in the place of a triangle, up to twice of what compile_contacts.cpp takes
    // into account.
    bool touch(const MeshGeometry& mesh, const Box& local, const mat4x3& to_world) const {
        const Box bounds = world_bounds(to_world, local.lower, local.upper);
        const float error = bounded_position_error(to_world, local.lower, local.upper);
        std::vector<const Hollow*> near;
        for (const Hollow& hollow : hollows_)
            if (overlap(hollow.bounds, grown(bounds, margin(hollow, error)))) near.push_back(&hollow);
        if (near.size() > most_neighbours) return true;
        return !near.empty() && std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const uvec3& triangle) {
            Box box = empty_box;
            for (int corner = 0; corner < 3; ++corner) {
                const vec3 p = to_world * vec4(mesh.positions[triangle[corner]], 1);
                box = {glm::min(box.lower, p), glm::max(box.upper, p)};
            }
            return std::any_of(near.begin(), near.end(), [&](const Hollow* hollow) {
                return touches(*hollow, grown(box, margin(*hollow, error)));
            });
        });
    }

  private:
    static float margin(const Hollow& hollow, float error) { return 8 * std::max(hollow.error, error); }

    static bool touches(const Hollow& hollow, const Box& box) {
        if (!overlap(hollow.bounds, box)) return false;
        if (!hollow.world_to_box) return true;
        // Well inside of a box of fog is not on its surface.
        return !(magnitude(world_bounds(*hollow.world_to_box, box.lower, box.upper)) < 1);
    }

    Hollow hollow_of(const Object& object) {
        const auto index = std::size_t(object.geometry);
        Compilation::Shape shape = c_.shapes[index];
        if (const MeshGeometry* mesh = mesh_of(c_.scene, object)) {  // these have no shape yet
            if (!mesh_bounds_[index]) mesh_bounds_[index] = bounds_of(*mesh);
            shape.lower = mesh_bounds_[index]->lower;
            shape.upper = mesh_bounds_[index]->upper;
        }
        if (!shape.bounded) return {{vec3(-kernels::INFINITE), vec3(kernels::INFINITE)}, 0, {}};
        const mat4x3 to_world = affine_product(object.transform, shape.bake);
        Hollow hollow{world_bounds(to_world, shape.lower, shape.upper),
                      bounded_position_error(to_world, shape.lower, shape.upper),
                      {}};
        if (shape.kind == kernels::GEOMETRY_BOX) hollow.world_to_box = affine_inverse(to_world);
        return hollow;
    }

    const Compilation& c_;
    std::vector<std::optional<Box>> mesh_bounds_;  // parallel to Scene::geometries
    std::vector<Hollow> hollows_;
};

bool is_joinable(const AcceleratorChoice& choice) {
    const uint walk = choice.structure->walk;
    return (walk == kernels::MESH_WALK_WIDE || walk == kernels::MESH_WALK_COMPACT) &&
           choice.test->test == kernels::TRIANGLE_WATERTIGHT;
}

// Of candidates in one space, those of like size together.
void join(const Scene& scene, std::vector<Candidate> candidates, std::vector<Compilation::Join>& joins) {
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return magnitude(a.bounds) < magnitude(b.bounds); });
    std::vector<uint> members;
    std::size_t triangles = 0;
    float edge = kernels::INFINITE;
    const auto finish = [&] {
        std::sort(members.begin(), members.end());
        if (members.size() > 1) joins.push_back({members});
        members.clear();
        triangles = 0;
        edge = kernels::INFINITE;
    };
    for (const Candidate& c : candidates) {
        const std::size_t count = mesh_of(scene, scene.objects[c.object])->triangles.size();
        if (triangles + count > most_triangles || !(std::min(edge, c.edge) >= least_edge * magnitude(c.bounds)))
            finish();
        members.push_back(c.object);
        triangles += count;
        edge = std::min(edge, c.edge);
    }
    finish();
}

}  // namespace

void find_joins(Compilation& c, const AcceleratorChoice& choice) {
    const Scene& scene = c.scene;
    if (!is_joinable(choice)) return;
    std::vector<int> uses(scene.geometries.size(), 0);
    for (const Object& object : scene.objects) ++uses[std::size_t(object.geometry)];
    using Key = std::array<float, 12>;
    std::map<Key, std::vector<uint>> spaces;
    for (uint i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        const MeshGeometry* mesh = mesh_of(scene, object);
        if (!mesh || uses[std::size_t(object.geometry)] != 1 || !is_shell(scene, object)) continue;
        Key key;
        static_assert(sizeof key == sizeof object.transform);
        std::memcpy(key.data(), &object.transform, sizeof key);
        spaces[key].push_back(i);
    }
    std::optional<Hollows> hollows;
    for (const auto& [key, objects] : spaces) {
        if (objects.size() < 2) continue;
        if (!hollows) hollows.emplace(c);
        std::vector<Candidate> candidates;
        for (const uint object : objects) {
            const Candidate candidate = candidate_of(scene, object);
            const Object& o = scene.objects[object];
            if (candidate.edge > 0 && !hollows->touch(*mesh_of(scene, o), candidate.bounds, o.transform))
                candidates.push_back(candidate);
        }
        join(scene, std::move(candidates), c.joins);
    }
    std::sort(c.joins.begin(), c.joins.end(),
              [](const Compilation::Join& a, const Compilation::Join& b) { return a.objects[0] < b.objects[0]; });
    for (const Compilation::Join& joined : c.joins)
        for (const uint object : joined.objects) c.joined[object] = true;
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
