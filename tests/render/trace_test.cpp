#include "spinel/trace.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "geometry/test_scene.h"

namespace spinel::trace_test {
namespace {

using namespace test;

constexpr float INF = std::numeric_limits<float>::infinity();

// Mesh, voxels, implicit surface, analytic shapes, ground; materials numbered as they stand here.
TestScene everything(const std::string& structure = "") {
    TestScene parts;
    const auto at = [](float x) { return affine(glm::mat3(1), vec3(x, 0, 0)); };
    parts.place(kernels::GEOMETRY_MESH, parts.add(icosphere(2), {structure, ""}), at(-6), {{0, NO}});
    const VoxelGeometry voxels = voxels_of({2, 2, 2}, {1, 0, 2, 1, 0, 2, 2, 1});
    parts.place(kernels::GEOMETRY_VOXELS, parts.add(voxels), at(-3), {{1, NO}, {2, 0}});
    parts.place(kernels::GEOMETRY_SDF, parts.add_sdf_sphere(0.9f), at(0), {{3, NO}});
    parts.place(kernels::GEOMETRY_SPHERE, 0, at(3), {{4, NO}});
    parts.place(kernels::GEOMETRY_BOX, 0, at(6), {{5, NO}});
    parts.place(kernels::GEOMETRY_PLANE, 0, affine(glm::mat3(1), vec3(0, -2, 0)), {{6, NO}});
    return parts;
}

std::vector<TraceRay> random_rays(std::size_t count) {
    Random random(1);
    std::vector<TraceRay> rays(count);
    for (TraceRay& r : rays) {
        const vec3 target = vec3(random.uniform(-7, 7), 0, 0) + random.in_cube(1.2f);
        r.origin = random.in_cube(8);
        r.t_min = 0;
        r.direction = target - r.origin;
        r.t_max = INF;
    }
    return rays;
}

TEST(TraceRays, every_accelerator_agrees_with_the_naive_twin) {
    TestScene brute = everything();
    const std::vector<TraceRay> rays = random_rays(20000);
    const auto expected = trace_rays(brute.view(), rays, {.method = TraceMethod::brute_force});
    ASSERT_TRUE(expected);
    for (const Accelerator& accelerator : accelerators()) {
        TestScene parts = everything(accelerator.structure);
        const auto hits = trace_rays(parts.view(), rays, {.method = accelerator.method});
        const auto any = trace_rays(parts.view(), rays, {.method = accelerator.method, .any = true});
        ASSERT_TRUE(hits) << accelerator.structure << ": " << hits.error().message;
        ASSERT_TRUE(any) << accelerator.structure << ": " << any.error().message;
        int differing = 0, found = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const TraceHit &a = (*hits)[i], &b = (*expected)[i];
            EXPECT_EQ((*any)[i].t, std::isinf(a.t) ? INF : 0.0f);
            EXPECT_EQ((*any)[i].instance, NO);
            found += std::isinf(a.t) ? 0 : 1;
            if (std::isinf(a.t) && std::isinf(b.t)) continue;
            // Silhouettes and edges fall to either side.
            if (a.instance != b.instance || a.primitive != b.primitive || !(std::abs(a.t - b.t) < 1e-5f)) {
                ++differing;
                continue;
            }
            EXPECT_EQ(a.material, b.material);
            EXPECT_NEAR(a.nx * b.nx + a.ny * b.ny + a.nz * b.nz, 1, 1e-4);
            EXPECT_NEAR(a.u, b.u, 1e-3);
            EXPECT_NEAR(a.v, b.v, 1e-3);
            EXPECT_TRUE(a.ix == b.ix && a.iy == b.iy && a.iz == b.iz);
        }
        EXPECT_GT(found, 10000) << accelerator.name;
        EXPECT_LT(differing, 40) << accelerator.name;
    }
}

TEST(TraceRays, hits_are_reported_in_the_users_terms) {
    TestScene parts = everything();
    const kernels::SceneView& scene = parts.view();
    const MeshGeometry mesh = icosphere(2);
    std::vector<TraceRay> rays;
    for (const uvec3& t : mesh.triangles) {
        const vec3 middle = (mesh.positions[t.x] + mesh.positions[t.y] + mesh.positions[t.z]) / 3.0f;
        rays.push_back({vec3(-6, 0, 0), 0, middle, INF});
    }
    rays.push_back({vec3(-1.5f, 1.5f, -1), 0, vec3(0, 0, 1), INF});  // cell (1, 1, 0) of the voxels
    rays.push_back({vec3(7.5f, 0.5f, 0), 0, vec3(-1, 0, 0), INF});   // the box's + x side
    rays.push_back({vec3(0, 5, 0), 0, vec3(0, 1, 0), INF});          // the sky
    rays.push_back({vec3(3, 0, -4), 0, vec3(0, 0, 2), 1.5f});        // the sphere at its end
    rays.push_back({vec3(3, 0, -4), 0, vec3(0, 0, 2), 1.6f});
    const auto hits = trace_rays(scene, rays);
    ASSERT_TRUE(hits);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const TraceHit& hit = (*hits)[i];
        ASSERT_EQ(hit.primitive, i);
        ASSERT_EQ(hit.instance, 0u);
        ASSERT_EQ(hit.material, 0u);
        ASSERT_NEAR(hit.t, 1, 1e-5);
        ASSERT_NEAR(hit.u, 1.0f / 3, 1e-4);
        ASSERT_NEAR(hit.v, 1.0f / 3, 1e-4);
        const vec3 normal(hit.nx, hit.ny, hit.nz);
        ASSERT_NEAR(glm::length(normal), 1, 1e-5);
        ASSERT_GT(glm::dot(normal, rays[i].direction), 0);
    }
    const TraceHit* rest = &(*hits)[mesh.triangles.size()];
    EXPECT_EQ(rest[0].instance, 1u);
    EXPECT_EQ(rest[0].primitive, 1u);
    EXPECT_TRUE(rest[0].ix == 1 && rest[0].iy == 1 && rest[0].iz == 0);
    EXPECT_EQ(rest[0].material, 1u);
    EXPECT_EQ(rest[0].nz, -1.0f);
    EXPECT_EQ(rest[0].t, 1.0f);
    EXPECT_EQ(rest[1].instance, 4u);
    EXPECT_EQ(rest[1].primitive, 1u);
    EXPECT_EQ(rest[1].material, 5u);
    EXPECT_TRUE(std::isinf(rest[2].t) && rest[2].instance == NO && rest[2].primitive == NO && rest[2].material == NO);
    EXPECT_TRUE(std::isinf(rest[3].t));
    EXPECT_EQ(rest[4].t, 1.5f);
}

TEST(TraceRays, interfaces_without_a_material_let_rays_pass) {
    const kernels::uint through = kernels::INSTANCE_PASS_THROUGH;
    const std::vector<TraceRay> rays = {{vec3(0, 0, -5), 0, vec3(0, 0, 1), INF},
                                        {vec3(0.8f, 0.1f, -5), 0, vec3(0, 0, 1), INF},
                                        {vec3(-1, 4.5f, 0.5f), 0, vec3(1, 0, 0), INF},
                                        {vec3(0.5f, 4.5f, -1), 0, vec3(0, 0, 1), INF}};
    for (const Accelerator& accelerator : accelerators()) {
        TestScene parts;
        parts.place(kernels::GEOMETRY_BOX, 0, mat4x3(1), {{NO, 0}}, through);  // smoke …
        parts.place(kernels::GEOMETRY_MESH, parts.add(icosphere(1), {accelerator.structure, ""}),
                    affine(glm::mat3(2), vec3(0)), {{NO, 0}}, through);
        parts.place(kernels::GEOMETRY_SPHERE, 0, affine(glm::mat3(0.5f), vec3(0)), {{3, NO}});  // … around a ball
        const VoxelGeometry fog = voxels_of({3, 1, 1}, {1, 2, 1});
        parts.place(kernels::GEOMETRY_VOXELS, parts.add(fog), affine(glm::mat3(1), vec3(0, 4, 0)), {{NO, 0}, {7, 1}},
                    through);
        const auto hits = trace_rays(parts.view(), rays, {.method = accelerator.method});
        const auto any = trace_rays(parts.view(), rays, {.method = accelerator.method, .any = true});
        ASSERT_TRUE(hits) << accelerator.structure << ": " << hits.error().message;
        ASSERT_TRUE(any) << accelerator.structure << ": " << any.error().message;
        EXPECT_EQ((*hits)[0].material, 3u);
        EXPECT_EQ((*hits)[0].t, 4.5f);
        EXPECT_TRUE(std::isinf((*hits)[1].t));
        EXPECT_EQ((*hits)[2].material, 7u);
        EXPECT_EQ((*hits)[2].t, 2.0f);
        EXPECT_TRUE(std::isinf((*hits)[3].t));
        for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(std::isinf((*any)[i].t), std::isinf((*hits)[i].t));
    }
}

TEST(TraceRays, unusable_rays_miss) {
    TestScene parts = everything();
    const float nan = std::nanf("");
    const std::vector<TraceRay> rays = {{vec3(nan, 0, 0), 0, vec3(0, -1, 0), INF},
                                        {vec3(0), 0, vec3(0, nan, 0), INF},
                                        {vec3(0), 0, vec3(0, -INF, 0), INF},
                                        {vec3(0), 0, vec3(0), INF},
                                        {vec3(0), nan, vec3(0, -1, 0), INF},
                                        {vec3(0), 0, vec3(0, -1, 0), nan},
                                        {vec3(0), 5, vec3(0, -1, 0), 4}};
    for (const bool any : {false, true}) {
        const auto hits = trace_rays(parts.view(), rays, {.any = any});
        ASSERT_TRUE(hits);
        for (const TraceHit& hit : *hits) EXPECT_TRUE(std::isinf(hit.t));
    }
}

TEST(TraceRays, the_same_bits_for_any_number_of_threads) {
    TestScene parts = everything();
    const std::vector<TraceRay> rays = random_rays(50000);
    const auto one = trace_rays(parts.view(), rays, {.threads = 1});
    for (const int threads : {2, 7}) {
        const auto many = trace_rays(parts.view(), rays, {.threads = threads});
        ASSERT_TRUE(one && many);
        EXPECT_EQ(std::memcmp(one->data(), many->data(), rays.size() * sizeof(TraceHit)), 0);
    }
}

TEST(TraceRays, coherent_rays_go_together_and_find_what_each_finds_alone) {
    TestScene parts = everything();
    const kernels::uint through = kernels::INSTANCE_PASS_THROUGH;  // smoke around the mesh, and in front of the voxels
    parts.place(kernels::GEOMETRY_MESH, parts.add(icosphere(2)), affine(glm::mat3(1.5f), vec3(-6, 0, 0)), {{NO, 0}},
                through);
    parts.place(kernels::GEOMETRY_BOX, 0, affine(glm::mat3(1.2f), vec3(-3, 0, 0)), {{NO, 0}}, through);
    Random random(2);
    std::vector<TraceRay> rays;
    for (int group = 0; group < 500; ++group) {
        const vec3 origin = random.in_cube(8), target = vec3(random.uniform(-7, 0), 0, 0) + random.in_cube(1);
        const float spread = group % 5 ? 0.3f : 20.0f;  // some groups are not coherent
        for (int i = 0; i < 8; ++i)
            rays.push_back({origin, 0, target + spread * random.in_cube(1) - origin, i == 3 ? 1.0f : INF});
    }
    rays[17].direction = vec3(0);
    for (const bool any : {false, true}) {
        const auto all = trace_rays(parts.view(), rays, {.any = any, .threads = 1});
        ASSERT_TRUE(all);
        int found = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto one = trace_rays(parts.view(), std::span(rays).subspan(i, 1), {.any = any, .threads = 1});
            ASSERT_TRUE(one);
            ASSERT_EQ(std::memcmp(&(*all)[i], one->data(), sizeof(TraceHit)), 0) << i;
            found += !std::isinf((*all)[i].t);
        }
        EXPECT_GT(found, 1000);
    }
}

TEST(TraceRays, an_unknown_accelerator_is_named_with_what_there_is) {
    const auto found = find_accelerator("bhv2");
    ASSERT_FALSE(found);
    EXPECT_NE(found.error().message.find("unknown accelerator 'bhv2'; available: wide-bvh8, wide-bvh8-compact, bvh2, "),
              std::string::npos);
    EXPECT_NE(found.error().message.find(", brute-force"), std::string::npos);
    for (const Accelerator& accelerator : accelerators())
        EXPECT_EQ(*find_accelerator(accelerator.name), &accelerator) << "two rows of that name";
}

}  // namespace
}  // namespace spinel::trace_test
