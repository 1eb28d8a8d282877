// Meshes that are walked as one answer as if each were walked by itself.

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "geometry/test_scene.h"
#include "kernels/counted.h"
#include "kernels/materials.h"
#include "scene/compiled_scene.h"
#include "scene/material_registry.h"
#include "spinel/trace.h"

namespace spinel::joins_test {
namespace {

using test::Random;

enum { diffuse, glass, veil };

// Triangles with corners on a coarse lattice: many lie in one plane, or are met at the same t.
MeshGeometry soup(int seed) {
    Random random{std::uint32_t(seed)};
    MeshGeometry mesh;
    for (std::uint32_t i = 0; i < 300; ++i) {
        for (int corner = 0; corner < 3; ++corner) mesh.positions.push_back(glm::round(random.in_cube(3.49f)));
        mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
    }
    return mesh;
}

mat4x3 moved(vec3 by) { return mat4x3(vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), by); }

class JoinScene {
  public:
    JoinScene() {
        for (const auto kind : {kernels::MATERIAL_DIFFUSE, kernels::MATERIAL_DIELECTRIC, kernels::MATERIAL_DIFFUSE})
            scene.materials.push_back({"", default_material(kind)});
        scene.materials[veil].values.opacity = 0.5f;
    }
    int add(Geometry geometry, const mat4x3& transform, int material) {
        scene.geometries.push_back(std::move(geometry));
        scene.objects.push_back({"", int(scene.geometries.size()) - 1, transform, {material}});
        return int(scene.objects.size()) - 1;
    }
    int add_soup(const mat4x3& transform = mat4x3(1), int material = diffuse) {
        return add({"", soup(int(scene.objects.size()))}, transform, material);
    }
    Scene scene;
};

std::vector<std::vector<int>> joins_of(const CompiledScene& scene) {
    std::vector<std::vector<int>> joins;
    for (const kernels::Instance& leader : scene.instances) {
        if (leader.member_count == 0) continue;
        const auto first = scene.words.begin() + leader.member_first;
        joins.emplace_back(first, first + leader.member_count);
    }
    return joins;
}

CompiledScene compiled(const Scene& scene, const std::string& structure = "", bool join = true) {
    CompileOptions options;
    options.join_meshes = join;
    options.accelerator.structure = structure;
    Result<CompiledScene> result = compile(scene, options);
    EXPECT_TRUE(result) << result.error().message;
    return *std::move(result);
}

using Joins = std::vector<std::vector<int>>;

TEST(Joins, meshes_of_one_space_that_stop_all_light_are_joined) {
    JoinScene s;
    const int a = s.add_soup(), b = s.add_soup(moved({0.5f, 0, 0})), c = s.add_soup();
    s.add_soup(mat4x3(1), veil);
    const int d = s.add_soup(moved({0.5f, 0, 0})), e = s.add_soup();
    s.add_soup(moved({9, 9, 9}));
    EXPECT_EQ(joins_of(compiled(s.scene)), (Joins{{a, c, e}, {b, d}}));
    EXPECT_EQ(joins_of(compiled(s.scene, "wide-bvh8-compact")), (Joins{{a, c, e}, {b, d}}));
    EXPECT_EQ(joins_of(compiled(s.scene, "bvh2")), Joins{});
    EXPECT_EQ(joins_of(compiled(s.scene, "", false)), Joins{});
    JoinScene twice = s;
    twice.scene.objects.push_back(s.scene.objects[std::size_t(a)]);
    EXPECT_EQ(joins_of(compiled(twice.scene)), (Joins{{b, d}, {c, e}})) << "what is placed twice is not joined";
    const CompiledScene joined = compiled(s.scene);
    EXPECT_EQ(joined.instance_order.size(), 4u);
    EXPECT_EQ(joined.view().unbounded_count, 0u);
}

TEST(Joins, what_touches_an_inside_stays_alone) {
    JoinScene s;
    const int a = s.add_soup(), b = s.add_soup(), c = s.add_soup(moved(vec3(0)));
    s.scene.geometries[std::size_t(c)] = {"", soup(50)};
    for (vec3& p : std::get<MeshGeometry>(s.scene.geometries[std::size_t(c)].data).positions) p.x += 20;
    EXPECT_EQ(joins_of(compiled(s.scene)), (Joins{{a, b, c}}));
    JoinScene with_ball = s;
    with_ball.add({"", SphereGeometry{1}}, moved({20, 0, 0}), glass);
    EXPECT_EQ(joins_of(compiled(with_ball.scene)), (Joins{{a, b}})) << "the ball stands among the third";
    // All stand within a box of fog, none on its faces; then one does.
    for (const bool large : {true, false}) {
        JoinScene fog = s;
        fog.scene.media.push_back({});
        const int box = fog.add({"", BoxGeometry{vec3(large ? 80 : 46)}}, mat4x3(1), -1);
        fog.scene.objects[std::size_t(box)].interior = 0;
        EXPECT_EQ(joins_of(compiled(fog.scene)), large ? (Joins{{a, b, c}}) : (Joins{{a, b}}));
    }
    JoinScene sea = s;
    sea.add({"", PlaneGeometry{}}, moved({0, -50, 0}), glass);
    EXPECT_EQ(joins_of(compiled(sea.scene)), Joins{});
}

MeshGeometry quad(float half, float y) {
    MeshGeometry mesh;
    mesh.positions = {{-half, y, -half}, {half, y, -half}, {half, y, half}, {-half, y, half}};
    mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
    return mesh;
}

// The ball does not reach the ground, but positions on so large a one are no better known than that.
TEST(Joins, what_is_near_an_inside_by_its_own_rounding_stays_alone) {
    JoinScene s;
    const int a = s.add({"", quad(1, 5)}, mat4x3(1), diffuse);
    const int ground = s.add({"", quad(1e5f, -1.02f)}, mat4x3(1), diffuse);
    const int b = s.add({"", quad(1, 7)}, mat4x3(1), diffuse);
    EXPECT_EQ(joins_of(compiled(s.scene)), (Joins{{a, ground, b}}));
    s.add({"", SphereGeometry{1}}, mat4x3(1), glass);
    EXPECT_EQ(joins_of(compiled(s.scene)), (Joins{{a, b}}));
}

// One large mesh would widen all boxes of fine ones by more than their triangles measure.
TEST(Joins, fine_meshes_are_not_joined_with_vast_ones) {
    JoinScene s;
    for (int i = 0; i < 2; ++i) {
        s.add_soup();
        for (vec3& p : std::get<MeshGeometry>(s.scene.geometries.back().data).positions) p *= 0.01f;
    }
    s.add({"", quad(1e5f, -1)}, mat4x3(1), diffuse);
    EXPECT_EQ(joins_of(compiled(s.scene)), (Joins{{0, 1}}));
    s.add({"", quad(1e5f, -2)}, mat4x3(1), diffuse);
    EXPECT_EQ(joins_of(compiled(s.scene)), (Joins{{0, 1}, {2, 3}}));
}

std::vector<TraceRay> rays_at(float size) {
    std::vector<TraceRay> rays;
    Random random(9);
    const float infinity = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 6000; ++i) {
        const vec3 from = random.in_cube(size);
        rays.push_back({from, 0, random.in_cube(3) - from, infinity});
    }
    // Side by side along an axis, through lattice points and between them: taken together, in packets.
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            rays.push_back({{-3.5f + float(x) / 8, -3.5f + float(y) / 8, -9}, 0, {0, 0, 1}, infinity});
    return rays;
}

TEST(Joins, hits_are_those_of_meshes_walked_one_by_one) {
    JoinScene s;
    for (int i = 0; i < 3; ++i) s.add_soup();
    s.add_soup(mat4x3(1), veil);  // between members, and at the same t as they
    for (int i = 0; i < 4; ++i) s.add_soup();
    s.add_soup(moved({0.25f, 0, 0}));
    const std::vector<TraceRay> rays = rays_at(8);
    for (const std::string structure : {"wide-bvh8", "wide-bvh8-compact"}) {
        const CompiledScene joined = compiled(s.scene, structure), apart = compiled(s.scene, structure, false);
        ASSERT_EQ(joins_of(joined), (Joins{{0, 1, 2, 4, 5, 6, 7}}));
        ASSERT_EQ(joins_of(apart), Joins{});
        for (const bool any : {false, true}) {
            const auto a = trace_rays(joined.view(), rays, {.any = any}),
                       b = trace_rays(apart.view(), rays, {.any = any});
            ASSERT_TRUE(a && b);
            int found = 0;
            std::vector<int> of(s.scene.objects.size(), 0);
            for (std::size_t i = 0; i < rays.size(); ++i) {
                ASSERT_EQ(std::memcmp(&(*a)[i], &(*b)[i], sizeof(TraceHit)), 0)
                    << structure << ", ray " << i << ": t " << (*a)[i].t << " of " << (*a)[i].instance << ", alone "
                    << (*b)[i].t << " of " << (*b)[i].instance;
                found += (*a)[i].t < kernels::INFINITE;
                if (!any && (*a)[i].instance < of.size()) ++of[(*a)[i].instance];
            }
            EXPECT_GT(found, 5000);
            if (any) continue;
            for (const int hits : of) EXPECT_GT(hits, 50);
        }
        // The counted walks, too.
        const kernels::SceneView one = joined.view(), many = apart.view();
        for (std::size_t i = 0; i < 2000; ++i) {
            const kernels::Ray ray(rays[i].origin, 0, rays[i].direction, kernels::INFINITE);
            kernels::WalkCount count = kernels::no_count();
            const kernels::Hit hit = kernels::trace_closest_counted(one, ray, kernels::TRACE_ALL, count);
            const kernels::Hit alone = kernels::trace_closest(many, ray, kernels::TRACE_ALL);
            ASSERT_EQ(hit.t, alone.t);
            ASSERT_EQ(hit.instance, alone.instance);
            ASSERT_EQ(hit.primitive, alone.primitive);
            ASSERT_EQ(kernels::trace_any_counted(one, ray, kernels::TRACE_ALL, count), hit.t < kernels::INFINITE);
        }
    }
}

TEST(Joins, a_mesh_without_triangles_is_refused_by_its_name) {
    JoinScene s;
    s.add_soup();
    MeshGeometry flat;
    flat.positions = {vec3(0), vec3(1), vec3(2)};
    flat.triangles = {{0, 1, 2}};
    s.add({"flat", flat}, mat4x3(1), diffuse);
    const Result<CompiledScene> result = compile(s.scene);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().message, "geometry 'flat' has no triangle with an area");
}

}  // namespace
}  // namespace spinel::joins_test
