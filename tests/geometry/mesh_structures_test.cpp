// Every structure of the table × every triangle test: what a loop over all triangles finds, to the last bit of t.

#include "geometry/mesh/mesh_structures.h"

#include <gtest/gtest.h>

#include <ctime>
#include <functional>
#include <map>

#include "geometry/test_scene.h"
#include "kernels/traverse.h"

namespace spinel::mesh_structures_test {
namespace {

using namespace test;
using kernels::Hit;
using kernels::Ray;
using kernels::SceneView;

// ---------------------------------------------------------------------------------------------------------- meshes
MeshGeometry soup_of(const std::vector<kernels::Triangle>& triangles) {
    MeshGeometry mesh;
    for (const kernels::Triangle& t : triangles) {
        const auto first = std::uint32_t(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {t.a, t.b, t.c});
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

MeshGeometry moved(MeshGeometry mesh, float scale, vec3 by) {
    for (vec3& p : mesh.positions) p = p * scale + by;
    return mesh;
}

MeshGeometry together(MeshGeometry a, const MeshGeometry& b) {
    const auto first = std::uint32_t(a.positions.size());
    a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
    for (const uvec3& t : b.triangles) a.triangles.push_back(t + first);
    return a;
}

MeshGeometry random_soup(int count, float size) {
    Random random(7);
    std::vector<kernels::Triangle> list;
    for (int i = 0; i < count; ++i) {
        const vec3 at = random.in_cube(1);
        const float s = size * (i % 10 == 0 ? 8.0f : 1.0f);
        list.push_back({at + random.in_cube(s), at + random.in_cube(s), at + random.in_cube(s)});
    }
    return soup_of(list);
}

MeshGeometry slivers(int count) {
    Random random(8);
    std::vector<kernels::Triangle> list;
    for (int i = 0; i < count; ++i) {
        const vec3 at = random.in_cube(1), along = random.in_cube(1);
        list.push_back({at, at + along, at + 0.5f * along + random.in_cube(1e-5f)});
    }
    return soup_of(list);
}

// Steps of a pyramid, all faces parallel to axes and on integers, some in one plane.
MeshGeometry steps() {
    std::vector<kernels::Triangle> list;
    const auto quad = [&](vec3 a, vec3 u, vec3 v) {
        list.push_back({a, a + u, a + u + v});
        list.push_back({a, a + u + v, a + v});
    };
    for (int level = 0; level < 4; ++level)
        for (int x = level; x < 8 - level; ++x)
            for (int z = level; z < 8 - level; ++z) {
                const vec3 at{float(x), float(level), float(z)};
                quad(at + vec3(0, 1, 0), vec3(1, 0, 0), vec3(0, 0, 1));
                quad(at, vec3(1, 0, 0), vec3(0, 1, 0));
                quad(at, vec3(0, 0, 1), vec3(0, 1, 0));
            }
    return soup_of(list);
}

MeshGeometry the_same_many_times(int count) {
    const kernels::Triangle t{vec3(0), vec3(1, 0, 0.5f), vec3(0, 1, 0.25f)};
    return soup_of(std::vector<kernels::Triangle>(std::size_t(count), t));
}

// A floor of strips along z, 2000 long and about 0.01 wide, in a frame of wide ones.
const std::vector<float>& strip_edges() {
    static const std::vector<float> edges = [] {
        Random random(10);
        std::vector<float> x{-1000};
        for (int i = 0; i < 80; ++i) x.push_back(random.uniform(0.1f, 0.9f));
        x.push_back(1000);
        std::sort(x.begin(), x.end());
        return x;
    }();
    return edges;
}

MeshGeometry strips() {
    MeshGeometry mesh;
    for (const float x : strip_edges()) {
        mesh.positions.push_back({x, 0, -1000});
        mesh.positions.push_back({x, 0, 1000});
    }
    for (std::uint32_t a = 0; a + 2 < mesh.positions.size(); a += 2) {
        mesh.triangles.push_back({a, a + 2, a + 3});
        mesh.triangles.push_back({a, a + 3, a + 1});
    }
    return mesh;
}

struct Case {
    const char* name;
    std::function<MeshGeometry()> mesh;
};

const Case cases[] = {
    {"one triangle", [] { return the_same_many_times(1); }},
    {"forty times the same", [] { return the_same_many_times(40); }},
    {"sphere", [] { return icosphere(3); }},
    {"torus", [] { return torus(24, 16, 0.4f); }},
    {"soup", [] { return random_soup(600, 0.1f); }},
    {"large and small", [] { return random_soup(300, 0.01f); }},
    {"slivers", [] { return slivers(200); }},
    {"steps", [] { return steps(); }},
    {"one plane",
     [] {
         MeshGeometry mesh = random_soup(300, 0.2f);
         for (vec3& p : mesh.positions) p.y = 0.5f;
         return mesh;
     }},
    {"far away", [] { return moved(icosphere(3), 40, vec3(1e6f, -3e6f, 2e6f)); }},
    {"far away soup", [] { return moved(random_soup(400, 0.1f), 1, vec3(1e4f, 2e4f, -3e4f)); }},
    {"tiny", [] { return moved(icosphere(2), 1e-6f, vec3(0)); }},
    {"enormous", [] { return moved(torus(16, 12, 0.3f), 1e6f, vec3(0)); }},
    {"strips", [] { return strips(); }},
    {"teapot in the stadium",
     [] { return together(moved(icosphere(4), 0.02f, vec3(3, 1, -2)), moved(steps(), 10, vec3(-40, 0, -40))); }},
    {"pearl in a ball", [] { return together(icosphere(3), moved(icosphere(4), 0.01f, vec3(0.3f, 0.2f, 0.1f))); }},
};

// ------------------------------------------------------------------------------------------------------------ rays
std::vector<Ray> rays_for(const MeshGeometry& mesh) {
    vec3 lower = mesh.positions[0], upper = lower;
    for (const vec3& p : mesh.positions) lower = glm::min(lower, p), upper = glm::max(upper, p);
    const vec3 center = 0.5f * (lower + upper);
    const float radius = 0.5f * glm::length(upper - lower);
    Random random(9);
    const auto index = [&](std::size_t size) { return std::size_t(random.uniform(0, 0.999f) * float(size)); };
    const auto corner = [&](int k) {
        const uvec3 t = mesh.triangles[index(mesh.triangles.size())];
        return std::array{mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]}[std::size_t(k)];
    };
    std::vector<Ray> rays;
    const auto add = [&](vec3 from, vec3 direction) {
        if (glm::length(direction) > 0) rays.push_back(Ray(from, 0, direction, kernels::INFINITE));
    };
    for (int i = 0; i < 400; ++i) add(center + random.in_cube(2 * radius), random.in_cube(radius));
    for (int i = 0; i < 400; ++i) {
        const vec3 from = center + random.in_cube(2 * radius);
        add(from, center + random.in_cube(0.7f * radius) - from);
    }
    for (int i = 0; i < 300; ++i) {  // at vertices, edges, points within
        const uvec3 t = mesh.triangles[index(mesh.triangles.size())];
        const vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
        const vec3 from = center + random.in_cube(2 * radius);
        add(from, a - from);
        add(from, 0.5f * (a + b) - from);
        add(from, (a + b + c) / 3.0f - from);
        add(a, random.in_cube(radius));  // from the surface
        add(0.5f * (b + c), from - 0.5f * (b + c));
        add(a, b - a);  // along edges
    }
    for (int i = 0; i < 300; ++i) {  // along the axes, through vertices and elsewhere
        vec3 axis(0);
        axis[i % 3] = i % 2 ? 1.0f : -1.0f;
        vec3 through = i % 4 < 2 ? corner(i % 3) : center + random.in_cube(radius);
        if (i % 5 == 0) through = glm::floor(through);
        add(through - 3 * radius * axis, axis);
        add(through, axis);
        vec3 in_plane = random.in_cube(1);
        in_plane[i % 3] = 0;
        add(through - 2 * radius * in_plane, in_plane);
    }
    for (int i = 0; i < 100; ++i) {  // from far away
        const vec3 from = center + random.in_cube(radius * (i % 2 ? 1e3f : 1e5f));
        add(from, center + random.in_cube(0.7f * radius) - from);
    }
    for (std::size_t i = 0; i < rays.size(); ++i) {  // segments, directions of any length
        if (i % 5 == 1) rays[i].t_max = random.uniform(0, 2);
        if (i % 7 == 2) rays[i].t_min = random.uniform(0, 1);
        if (i % 11 == 3) rays[i].direction *= 1e-3f;
    }
    return rays;
}

// -------------------------------------------------------------------------------------------------- the naive twin
struct Naive {
    float t;
    std::uint32_t triangle = NO;  // the user's
    bool real = true;             // false: the test found a triangle beside itself, as those of slivers do by rounding
};

// In double precision, edges included.
bool really_hit(const kernels::Triangle& t, const Ray& ray, float found) {
    const glm::dvec3 a(t.a), e1 = glm::dvec3(t.b) - a, e2 = glm::dvec3(t.c) - a, d(ray.direction);
    const glm::dvec3 p = glm::cross(d, e2), s = glm::dvec3(ray.origin) - a, q = glm::cross(s, e1);
    const double determinant = glm::dot(e1, p);
    const double u = glm::dot(s, p) / determinant, v = glm::dot(d, q) / determinant;
    const double exact = glm::dot(e2, q) / determinant;
    return u >= 0 && v >= 0 && u + v <= 1 && std::abs(exact - double(found)) <= 2e-6 * std::abs(exact);
}

Naive naive_closest(const SceneView& scene, const Ray& ray) {
    const kernels::Mesh& mesh = scene.meshes.at[0];
    const kernels::MeshRay r = kernels::mesh_ray(scene, 0, ray, false, mesh.triangle_test);
    kernels::MeshNearest nearest{{ray.t_max, 0, 0}, NO};
    for (std::uint32_t i = 0; i < mesh.triangle_count; ++i) kernels::mesh_test(scene, r, i, nearest);
    if (nearest.triangle == NO) return {ray.t_max};
    const kernels::Triangle& t = scene.triangles.at[nearest.triangle];
    const vec2 span = kernels::slab_interval(glm::min(t.a, glm::min(t.b, t.c)), glm::max(t.a, glm::max(t.b, t.c)),
                                             r.slab, kernels::INFINITE);
    return {nearest.hit.t, scene.triangle_infos.at[nearest.triangle].primitive,
            nearest.hit.t >= span.x && nearest.hit.t <= span.y && really_hit(t, ray, nearest.hit.t)};
}

// The same for every structure: the order in which triangles are stored changes nothing.
const std::vector<Naive>& naive_of(std::size_t which, kernels::uint test, const SceneView& scene,
                                   const std::vector<Ray>& rays) {
    static std::map<std::pair<std::size_t, kernels::uint>, std::vector<Naive>> known;
    std::vector<Naive>& list = known[{which, test}];
    if (list.empty())
        for (const Ray& ray : rays) list.push_back(naive_closest(scene, ray));
    return list;
}

bool is_watertight(const TriangleTest& test) {
    return test.test == kernels::TRIANGLE_WATERTIGHT || test.test == kernels::TRIANGLE_INDEXED;
}

class MeshStructures : public testing::TestWithParam<std::tuple<std::size_t, std::size_t>> {
  protected:
    const MeshStructure& structure() const { return mesh_structures()[std::get<0>(GetParam())]; }
    const TriangleTest& test() const { return triangle_tests()[std::get<1>(GetParam())]; }
};

TEST_P(MeshStructures, closest_and_any_hit_equal_brute_force_on_adversarial_rays) {
    for (std::size_t which = 0; which < std::size(cases); ++which) {
        const Case& c = cases[which];
        SCOPED_TRACE(c.name);
        const MeshGeometry mesh = c.mesh();
        TestScene built;
        built.place(kernels::GEOMETRY_MESH, built.add(mesh, {structure().name, test().name}));
        const SceneView& scene = built.view();
        const bool exact = is_watertight(test());
        int found = 0, excused = 0;
        const std::vector<Ray> rays = rays_for(mesh);
        const std::vector<Naive>& naive = naive_of(which, test().test, scene, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Ray& ray = rays[i];
            const Naive& expected = naive[i];
            Hit hit = kernels::no_hit(ray.t_max), counted = hit;
            kernels::mesh_closest(scene, 0, ray, hit);
            const bool any = kernels::mesh_any(scene, 0, ray);
            found += expected.triangle != NO;
            if (!exact && !expected.real && (hit.t > expected.t || !any)) {
                ++excused;
                continue;
            }
            ASSERT_EQ(hit.t, expected.t) << "ray " << i << " from " << ray.origin.x << ' ' << ray.origin.y << ' '
                                         << ray.origin.z << " towards " << ray.direction.x << ' ' << ray.direction.y
                                         << ' ' << ray.direction.z << ", triangle " << expected.triangle;
            ASSERT_EQ(any, expected.triangle != NO) << "ray " << i;
            kernels::WalkCount count = kernels::no_count();
            kernels::mesh_closest_counted(scene, 0, ray, counted, count);
            ASSERT_EQ(counted.t, hit.t);
            ASSERT_EQ(counted.primitive, hit.primitive);
            if (expected.triangle != NO) { ASSERT_TRUE(count.steps + count.tests > 0 && count.tests > 0); }
        }
        EXPECT_GT(found, 50);
        EXPECT_LE(excused, found / 20);
    }
}

// With the tests by which neighbours agree about their edge.
class WatertightStructures : public MeshStructures {};

// An edge is moved by the rounding of its ends, 1000 away, and not by that of where a ray meets it.
TEST_P(WatertightStructures, no_ray_falls_between_long_strips) {
    struct Placed {
        float scale;
        vec3 by;
    };
    for (const Placed& placed : {Placed{1, vec3(0)}, Placed{1, vec3(300, 0, -500)}, Placed{1e-4f, vec3(0.01f, 0, 0)},
                                 Placed{100, vec3(1e6f, 0, 2e6f)}, Placed{3e5f, vec3(0)}}) {
        SCOPED_TRACE(placed.scale);
        TestScene built;
        const MeshGeometry mesh = moved(strips(), placed.scale, placed.by);
        built.place(kernels::GEOMETRY_MESH, built.add(mesh, {structure().name, test().name}));
        const SceneView& scene = built.view();
        Random random(11);
        for (int i = 0; i < 2000; ++i) {
            const float edge = strip_edges()[1 + random.below(std::uint32_t(strip_edges().size()) - 2)];
            const float height = std::exp(random.uniform(-9, 3));
            const vec3 direction(random.uniform(-0.3f, 0.3f), -random.uniform(0.001f, 0.2f), 1);
            const float t = height / -direction.y;
            if (t > 900) continue;
            vec3 target(edge, 0, 0);
            if (i % 2) target.z = random.uniform(-50, 50);
            const Ray ray((target - t * direction) * placed.scale + placed.by, 0, direction, kernels::INFINITE);
            Hit hit = kernels::no_hit(ray.t_max);
            kernels::mesh_closest(scene, 0, ray, hit);
            ASSERT_LT(hit.t, kernels::INFINITE) << describe(ray);
            ASSERT_EQ(hit.t, naive_closest(scene, ray).t) << describe(ray);
            ASSERT_TRUE(kernels::mesh_any(scene, 0, ray)) << describe(ray);
            Hit placed_hit = kernels::trace_closest(scene, ray, kernels::TRACE_ALL);
            ASSERT_EQ(placed_hit.t, hit.t) << describe(ray);
        }
    }
}

// What lies close together somewhere is out of reach for rays from afar; for the rest of the mesh they walk all the
// same.
TEST(HierarchicalGrid, a_dense_spot_costs_only_rays_that_come_by) {
    const vec3 spot(0.3f, 0.2f, 0.1f);
    TestScene built;
    const MeshGeometry mesh = together(icosphere(5), moved(icosphere(5), 0.002f, spot));
    built.place(kernels::GEOMETRY_MESH, built.add(mesh, {"grid-hierarchical", "watertight"}));
    const SceneView& scene = built.view();
    Random random(12);
    for (const float away : {1.8f, 2.5f, 8.0f, 18.0f}) {
        SCOPED_TRACE(away);
        double tests = 0;
        constexpr int rays = 1000;
        for (int i = 0; i < rays; ++i) {
            const vec3 from = away * glm::normalize(vec3(1, 2, -3) + random.in_cube(1));
            const vec3 at = i % 20 ? random.in_cube(0.8f) : spot + random.in_cube(0.002f);
            const Ray ray(from, 0, at - from, kernels::INFINITE);
            Hit hit = kernels::no_hit(ray.t_max);
            kernels::WalkCount count = kernels::no_count();
            kernels::mesh_closest_counted(scene, 0, ray, hit, count);
            if (i % 20 != 0) tests += count.tests;
            if (i % 20 < 2) { ASSERT_EQ(hit.t, naive_closest(scene, ray).t) << describe(ray); }
        }
        EXPECT_LT(tests / rays, 100);
    }
}

TEST_P(MeshStructures, every_triangle_is_stored_once_and_measured) {
    TestScene built;
    const MeshGeometry mesh = torus(40, 30, 0.4f);
    const auto data = build_mesh(mesh, {structure().name, test().name});
    ASSERT_TRUE(data);
    std::vector<bool> seen(mesh.triangles.size(), false);
    for (const kernels::TriangleInfo& info : data->infos) {
        ASSERT_FALSE(seen[info.primitive]);
        seen[info.primitive] = true;
    }
    EXPECT_EQ(data->infos.size(), mesh.triangles.size());
    EXPECT_GT(data->statistics.sah_cost, 1);
    EXPECT_GE(data->statistics.leaf_count, 1u);
    EXPECT_GT(data->statistics.bytes, mesh.triangles.size() * 12);
}

// Where vertices go is far from where they were: half of the torus is turned over.
TEST_P(MeshStructures, a_refitted_mesh_is_hit_where_its_vertices_are_now) {
    const AcceleratorSettings settings{structure().name, test().name};
    const auto choice = choose_accelerator(settings);
    ASSERT_TRUE(choice);
    MeshGeometry mesh = torus(40, 30, 0.4f);
    auto data = build_mesh(mesh, settings);
    ASSERT_TRUE(data);
    for (vec3& p : mesh.positions) p = p.x > 0 ? vec3(p.x, -2 * p.z, p.y + 1) : vec3(p.x, p.y * 0.5f, p.z);
    const auto refitted = refit_mesh(mesh, *choice, *data);
    ASSERT_TRUE(refitted);
    EXPECT_EQ(*refitted, structure().refit != nullptr);
    if (!*refitted) return;
    TestScene scene;
    scene.place(kernels::GEOMETRY_MESH, scene.add(mesh, *data));
    int found = 0;
    for (const Ray& ray : rays_for(mesh)) {
        const Naive expected = naive_closest(scene.view(), ray);
        if (!is_watertight(test()) && !expected.real) continue;  // its rounding may differ
        Hit hit = kernels::no_hit(ray.t_max);
        kernels::mesh_closest(scene.view(), 0, ray, hit);
        ASSERT_EQ(hit.t, expected.t);
        ASSERT_EQ(kernels::mesh_any(scene.view(), 0, ray), expected.triangle != NO);
        found += expected.triangle != NO;
    }
    EXPECT_GT(found, 50);
}

TEST_P(MeshStructures, other_triangles_are_not_refitted) {
    const AcceleratorSettings settings{structure().name, test().name};
    const auto choice = choose_accelerator(settings);
    ASSERT_TRUE(choice);
    const MeshGeometry mesh = torus(12, 8, 0.4f);
    auto data = build_mesh(mesh, settings);
    ASSERT_TRUE(data);
    MeshGeometry flat = mesh, turned = mesh, slotted = mesh, endless = mesh;
    flat.positions[mesh.triangles[3].x] = flat.positions[mesh.triangles[3].y];  // and has no area
    std::swap(turned.triangles[5].x, turned.triangles[5].y);
    slotted.slots.assign(mesh.triangles.size(), 1);
    for (const MeshGeometry& other : {flat, turned, slotted}) {
        const auto refitted = refit_mesh(other, *choice, *data);
        ASSERT_TRUE(refitted);
        EXPECT_FALSE(*refitted);
    }
    endless.positions[7].y = std::numeric_limits<float>::infinity();
    const auto refused = refit_mesh(endless, *choice, *data);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message, "mesh vertex 7 has a position that is not finite");
}

TEST(MeshPresets, are_of_the_wide_hierarchies_alone) {
    for (const MeshStructure& structure : mesh_structures()) {
        SCOPED_TRACE(structure.name);
        const bool wide = std::string_view(structure.name).starts_with("wide-bvh8");
        ASSERT_EQ(structure.has_presets, wide);
        const auto fast = build_mesh(icosphere(2), {structure.name, "", "fast"});
        ASSERT_EQ(bool(fast), wide);
        if (!wide) {
            EXPECT_EQ(fast.error().message, "accelerator '" + std::string(structure.name) +
                                                "' has no presets, and 'fast' is asked for; those that have: "
                                                "wide-bvh8, wide-bvh8-compact");
        }
        ASSERT_TRUE(find_preset(structure, ""));
    }
    const auto wrong = build_mesh(icosphere(2), {"wide-bvh8", "", "faster"});
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().message, "unknown preset 'faster'; available: fast, balanced, high");
}

// The expected cost tells them apart; on this mesh spatial splits gain something.
TEST(MeshPresets, are_what_is_built) {
    for (const char* structure : {"wide-bvh8", "wide-bvh8-compact"}) {
        const MeshGeometry mesh = together(random_soup(3000, 0.1f), slivers(100));
        std::vector<double> costs;
        for (const char* preset : {"fast", "balanced", "high", ""}) {
            const auto data = build_mesh(mesh, {structure, "", preset});
            ASSERT_TRUE(data);
            costs.push_back(data->statistics.sah_cost);
        }
        EXPECT_GT(costs[0], costs[1]);
        EXPECT_GT(costs[1], costs[2]);
        EXPECT_EQ(costs[2], costs[3]);
    }
}

// Inputs whose triangles all lie in the same cells, where every cut of space doubles what is on either side.
class MeshBudgets : public testing::TestWithParam<std::size_t> {
  protected:
    void expect_bounded(const MeshGeometry& mesh) {
        const MeshStructure& structure = mesh_structures()[GetParam()];
        const std::clock_t start = std::clock();  // all threads together
        const auto data = build_mesh(mesh, {structure.name, ""});
        const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
        ASSERT_TRUE(data) << data.error().message;
        const double count = double(mesh.triangles.size());
        // Sixteen references of four bytes, nodes or cells over them, the triangles; and what is for small meshes.
        EXPECT_LT(double(data->statistics.bytes), 400 * count + 16e6);
        EXPECT_LT(seconds, 10) << "of the processor";
        EXPECT_EQ(data->triangles.size(), mesh.triangles.size());
    }
};

TEST_P(MeshBudgets, copies_of_one_triangle) { expect_bounded(the_same_many_times(10000)); }

TEST_P(MeshBudgets, a_soup_of_triangles_as_large_as_itself) { expect_bounded(random_soup(5000, 1)); }

TEST_P(MeshBudgets, copies_of_a_small_triangle_in_a_large_mesh) {
    expect_bounded(together(moved(the_same_many_times(5000), 1e-3f, vec3(0.5f)), random_soup(2000, 0.1f)));
}

TEST_P(MeshBudgets, needles_side_by_side) { expect_bounded(slivers(5000)); }

std::string parameter_name(const testing::TestParamInfo<std::tuple<std::size_t, std::size_t>>& info) {
    std::string name = std::string(mesh_structures()[std::get<0>(info.param)].name) + "_with_" +
                       triangle_tests()[std::get<1>(info.param)].name;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

INSTANTIATE_TEST_SUITE_P(All, MeshBudgets, testing::Range(std::size_t(0), mesh_structures().size()),
                         [](const testing::TestParamInfo<std::size_t>& info) {
                             std::string name = mesh_structures()[info.param].name;
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

INSTANTIATE_TEST_SUITE_P(All, MeshStructures,
                         testing::Combine(testing::Range(std::size_t(0), mesh_structures().size()),
                                          testing::Range(std::size_t(0), triangle_tests().size())),
                         parameter_name);

std::vector<std::size_t> watertight_tests() {
    std::vector<std::size_t> list;
    for (std::size_t i = 0; i < triangle_tests().size(); ++i)
        if (is_watertight(triangle_tests()[i])) list.push_back(i);
    return list;
}

INSTANTIATE_TEST_SUITE_P(All, WatertightStructures,
                         testing::Combine(testing::Range(std::size_t(0), mesh_structures().size()),
                                          testing::ValuesIn(watertight_tests())),
                         parameter_name);

}  // namespace
}  // namespace spinel::mesh_structures_test
