#include "kernels/traverse.h"

#include <gtest/gtest.h>

#include <map>

#include "geometry/scanned_meshes.h"
#include "geometry/test_scene.h"
#include "render/reference.h"

namespace spinel::traverse_test {
namespace {

using namespace test;
using kernels::Hit;

// The twin's answer for a ray, or for some ray beside it as near as floats can tell: at silhouettes and edges
// either is right.
struct Agreement {
    int rays = 0;
    int hits = 0;
    int beside = 0;

    // `precision`: absolute error to expect of positions.
    void check(const kernels::SceneView& scene, const kernels::Ray& r, float precision,
               std::uint32_t mask = kernels::TRACE_ALL) {
        ++rays;
        const Hit hit = kernels::trace_closest(scene, r, mask);
        const bool found = kernels::is_hit(hit);
        ASSERT_EQ(kernels::trace_any(scene, r, mask), found) << describe(r);
        const double tolerance = double(precision) / double(glm::length(r.direction));
        const auto agrees = [&](const ReferenceHit& other, double factor) {
            if ((other.hit.instance != NO) != found) return false;
            return !found || std::abs(hit.t - other.t) <= factor * (tolerance + 1e-6 * other.t);
        };
        const ReferenceHit expected = reference_hit(scene, r, mask);
        if (agrees(expected, 1)) {
            if (!found) return;
            ++hits;
            if (hit.instance == expected.hit.instance && hit.primitive == expected.hit.primitive &&
                glm::length(expected.hit.normal) > 0) {
                const float cosine = glm::dot(glm::normalize(hit.normal), glm::normalize(expected.hit.normal));
                ASSERT_GT(cosine, 0.99f) << describe(r);
            }
            return;
        }
        ++beside;
        for (int j = 0; j < 200; ++j) {
            kernels::Ray other = r;
            other.t_min -= float(tolerance);  // an origin on a surface
            if (j % 8 != 0) other.origin += precision * random.in_cube();
            other.direction += 2e-7f * glm::length(r.direction) * random.in_cube();
            if (agrees(reference_hit(scene, other, mask), 10)) return;
        }
        FAIL() << describe(r) << " hit " << found << " t " << hit.t << " expected t " << expected.t << " instance "
               << expected.hit.instance;
    }

    Random random{99};
};

TEST(Walk, equals_the_naive_twin_on_a_closed_mesh) {
    TestScene parts;
    parts.place(kernels::GEOMETRY_MESH, parts.add(torus(24, 16, 0.4f)));
    const kernels::SceneView& scene = parts.view();
    const MeshGeometry mesh = torus(24, 16, 0.4f);
    Random random(1);
    Agreement agreement;
    for (int i = 0; i < 20000; ++i) {
        const vec3 origin = random.in_cube(i % 2 ? 3.0f : 1.0f);
        vec3 target = random.in_cube(1.4f);
        const uvec3 t = mesh.triangles[random.below(std::uint32_t(mesh.triangles.size()))];
        if (i % 4 == 1) target = mesh.positions[t.x];                                 // a vertex
        if (i % 4 == 2) target = 0.5f * (mesh.positions[t.x] + mesh.positions[t.y]);  // an edge
        const vec3 direction = i % 4 == 3 ? random.awkward_direction() : 3.0f * (target - origin);
        agreement.check(scene, ray(origin, direction, i % 8 == 0 ? 0.1f : 0.0f, i % 8 == 4 ? 0.2f : 1e30f), 3e-6f);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(agreement.hits, 8000);
    EXPECT_LT(agreement.beside, agreement.rays / 50);
}

// Axis-parallel triangles with flat boxes, duplicates, and rays within the lattice's planes.
TEST(Walk, equals_the_naive_twin_on_a_lattice_of_axis_parallel_squares) {
    MeshGeometry mesh;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 4; ++j) {
                const auto first = std::uint32_t(mesh.positions.size());
                for (const auto& [u, v] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
                    vec3 p(0);
                    p[axis] = float((i * 7 + j * 3) % 5);
                    p[(axis + 1) % 3] = float(i + u);
                    p[(axis + 2) % 3] = float(j + v);
                    mesh.positions.push_back(p);
                }
                mesh.triangles.push_back({first, first + 1, first + 2});
                mesh.triangles.push_back({first, first + 2, first + 3});
                if (i == j) mesh.triangles.push_back({first, first + 1, first + 2});  // a duplicate
            }
        }
    }
    TestScene parts;
    parts.place(kernels::GEOMETRY_MESH, parts.add(mesh));
    const kernels::SceneView& scene = parts.view();
    Random random(2);
    Agreement agreement;
    for (int i = 0; i < 20000; ++i) {
        vec3 origin = vec3(2) + random.in_cube(2.5f);
        if (i % 2) origin = glm::round(origin * 2.0f) * 0.5f;
        const vec3 direction = i % 3 ? random.awkward_direction() : glm::round(random.in_cube(3));
        if (kernels::is_black(direction)) continue;
        agreement.check(scene, ray(origin, direction), 4e-6f);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(agreement.hits, 4000);
    EXPECT_LT(agreement.beside, agreement.rays / 5);  // many rays run along edges on purpose
}

TEST(Walk, equals_the_naive_twin_at_tiny_and_huge_scales_far_from_the_origin) {
    const MeshGeometry unit = icosphere(2);
    Random random(3);
    for (const float scale : {1e-8f, 1e-3f, 1e3f, 1e8f}) {
        for (const float offset : {0.0f, 100.0f}) {
            MeshGeometry mesh = unit;
            const vec3 center = scale * offset * vec3(1, -0.7f, 0.3f);
            for (vec3& p : mesh.positions) p = scale * p + center;
            TestScene parts;
            parts.place(kernels::GEOMETRY_MESH, parts.add(mesh));
            const kernels::SceneView& scene = parts.view();
            Agreement agreement;
            for (int i = 0; i < 2000; ++i) {
                const vec3 origin = center + scale * random.in_cube(i % 2 ? 0.5f : 4.0f);
                agreement.check(scene, ray(origin, random.awkward_direction()), scale * (3e-6f + 1e-7f * offset));
                if (HasFatalFailure()) return;
            }
            EXPECT_GT(agreement.hits, 800);
            EXPECT_LT(agreement.beside, agreement.rays / 20);
        }
    }
}

// Every kind of geometry under transforms that rotate, stretch, shear and mirror.
TEST(Walk, equals_the_naive_twin_on_instances_of_every_kind) {
    Random random(4);
    TestScene parts;
    const std::uint32_t mesh = parts.add(icosphere(2));
    std::vector<std::uint16_t> cells;
    for (int i = 0; i < 60; ++i) cells.push_back(std::uint16_t(random.below(3)));
    const std::uint32_t grid = parts.add(voxels_of({5, 4, 3}, cells));
    const std::uint32_t sdf = parts.add_sdf_sphere(0.8f);
    const auto transform = [&](float place) {
        const glm::mat3 linear(random.in_cube(), random.in_cube(), random.in_cube());
        return affine(glm::mat3(1) + 0.7f * linear, random.in_cube(place));
    };
    for (int i = 0; i < 4; ++i) {
        parts.place(kernels::GEOMETRY_MESH, mesh, transform(6));
        parts.place(kernels::GEOMETRY_VOXELS, grid, transform(6), {OPAQUE_SLOT, {1, 0}});
        parts.place(kernels::GEOMETRY_SDF, sdf, transform(6));
        parts.place(kernels::GEOMETRY_SPHERE, 0, transform(6));
        parts.place(kernels::GEOMETRY_BOX, 0, transform(6));
        parts.place(kernels::GEOMETRY_RECTANGLE, 0, transform(6));
    }
    parts.place(kernels::GEOMETRY_MESH, mesh, affine(glm::mat3(-1, 0, 0, 0, 1, 0, 0, 0, 1), vec3(3)));
    parts.place(kernels::GEOMETRY_PLANE, 0, affine(glm::mat3(1), vec3(0, -7, 0)));
    parts.place(kernels::GEOMETRY_PLANE, 0, affine(glm::mat3(0, 1, 0, 1, 0, 0, 0, 0, 1), vec3(9, 0, 0)));
    const kernels::SceneView& scene = parts.view();
    Agreement agreement;
    for (int i = 0; i < 6000; ++i) {
        const vec3 direction =
            (i % 2 ? random.direction() : random.awkward_direction()) * std::exp(random.uniform(-3, 3));
        agreement.check(scene, ray(random.in_cube(8), direction, 0, i % 4 ? 1e30f : 2.0f), 1e-4f);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(agreement.hits, 3000);
    EXPECT_LT(agreement.beside, agreement.rays / 50);
}

TEST(Walk, the_mask_selects_instances) {
    TestScene parts;
    parts.place(kernels::GEOMETRY_SPHERE, 0, affine(glm::mat3(1), vec3(0, 0, 3)), {OPAQUE_SLOT},
                kernels::INSTANCE_PASS_THROUGH);
    parts.place(kernels::GEOMETRY_SPHERE, 0, affine(glm::mat3(1), vec3(0, 0, 6)));
    parts.place(kernels::GEOMETRY_PLANE, 0, affine(glm::mat3(1, 0, 0, 0, 0, 1, 0, 1, 0), vec3(0, 0, 9)));
    const kernels::SceneView& scene = parts.view();
    const kernels::Ray r = ray(vec3(0), vec3(0, 0, 1));
    EXPECT_EQ(kernels::trace_closest(scene, r, kernels::TRACE_ALL).instance, 0u);
    EXPECT_EQ(kernels::trace_closest(scene, r, kernels::TRACE_PASS_THROUGH).instance, 0u);
    EXPECT_EQ(kernels::trace_closest(scene, r, kernels::TRACE_SOLID).instance, 1u);
    EXPECT_FALSE(kernels::trace_occluded(scene, ray(vec3(0), vec3(0, 0, 1), 0, 4.9f)));
    EXPECT_TRUE(kernels::trace_occluded(scene, ray(vec3(0), vec3(0, 0, 1), 0, 5.1f)));
    EXPECT_EQ(kernels::trace_closest(scene, ray(vec3(0, 0, 8), vec3(0, 0, 1)), kernels::TRACE_ALL).instance, 2u);
    EXPECT_FALSE(
        kernels::is_hit(kernels::trace_closest(scene, ray(vec3(0, 0, 10), vec3(0, 0, 1)), kernels::TRACE_ALL)));
    EXPECT_FALSE(kernels::is_hit(kernels::trace_closest(TestScene().view(), r, kernels::TRACE_ALL)));
}

TEST(Walk, a_sphere_far_away_and_from_inside_is_hit_where_it_is) {
    Random random(5);
    for (int i = 0; i < 50000; ++i) {
        // The relative error of t is that of the inputs, however far the origin.
        const float distance = std::exp(random.uniform(1, 12));
        const vec3 direction = random.direction();
        const kernels::Ray far_away = ray(-distance * direction, 0.5f * direction);
        Hit hit = kernels::no_hit(1e30f);
        kernels::sphere_closest(far_away, hit);
        ASSERT_NEAR(hit.t, 2 * (distance - 1), 1e-6 * double(distance) + 1e-5) << describe(far_away);
        ASSERT_NEAR(glm::length(hit.normal), 1, 1e-5);
        const kernels::Ray inside = ray(random.in_cube(0.57f), direction);
        hit = kernels::no_hit(1e30f);
        kernels::sphere_closest(inside, hit);
        ASSERT_NEAR(glm::length(kernels::ray_at(inside, hit.t)), 1, 1e-5) << describe(inside);
        ASSERT_GT(glm::dot(hit.normal, direction), 0);
    }
}

// Watertight: no ray from inside of a closed mesh gets out.
void expect_no_leaks(const MeshGeometry& mesh, int ray_count, vec3 inside, float spread, std::uint32_t seed) {
    TestScene parts;
    parts.place(kernels::GEOMETRY_MESH, parts.add(mesh));
    const kernels::SceneView& scene = parts.view();
    Random random(seed);
    int leaks = 0;
    for (int i = 0; i < ray_count; ++i) {
        const vec3 origin = inside + spread * random.in_cube();
        const uvec3 t = mesh.triangles[random.below(std::uint32_t(mesh.triangles.size()))];
        vec3 target = mesh.positions[t.x];
        if (i % 4 == 1) target = glm::mix(mesh.positions[t.x], mesh.positions[t.y], random.uniform(0, 1));
        vec3 direction = i % 4 == 2 ? random.awkward_direction() : target - origin;
        if (i % 4 == 3) direction = random.direction();
        if (!kernels::is_hit(kernels::trace_closest(scene, ray(origin, direction), kernels::TRACE_ALL))) {
            if (leaks++ == 0) ADD_FAILURE() << describe(ray(origin, direction));
        }
    }
    EXPECT_EQ(leaks, 0) << "of " << ray_count;
}

TEST(Walk, no_ray_leaks_out_of_closed_meshes) {
    expect_no_leaks(icosphere(0), 200000, vec3(0), 0.3f, 6);
    expect_no_leaks(icosphere(5), 500000, vec3(0), 0.5f, 7);
    expect_no_leaks(torus(200, 100, 0.4f), 300000, vec3(1, 0, 0), 0.15f, 8);
    MeshGeometry shifted = icosphere(4);
    for (vec3& p : shifted.positions) p += vec3(1000, -2000, 500);
    expect_no_leaks(shifted, 200000, vec3(1000, -2000, 500), 0.5f, 9);
}

// A ray at an edge from whose two triangles it sees the same side cannot pass between them, whatever else is
// open in a scan.
TEST(Walk, no_ray_leaks_between_two_triangles_of_a_scanned_mesh) {
    const auto mesh = read_gzipped_ply(SPINEL_SOURCE_DIR "/../shared/data/mesh/stanford/dragon_vrip_res3.ply.gz");
    if (!mesh) GTEST_SKIP() << "needs shared/data/mesh/stanford/dragon_vrip_res3.ply.gz beside the source tree";
    ASSERT_GT(mesh->triangles.size(), 10000u);
    TestScene parts;
    parts.place(kernels::GEOMETRY_MESH, parts.add(*mesh));
    const kernels::SceneView& scene = parts.view();
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> edges;
    for (std::uint32_t i = 0; i < mesh->triangles.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
            edges[std::minmax(mesh->triangles[i][k], mesh->triangles[i][(k + 1) % 3])].push_back(i);
        }
    }
    const auto normal_of = [&](std::uint32_t i) {
        const uvec3 t = mesh->triangles[i];
        const glm::dvec3 a(mesh->positions[t.x]), b(mesh->positions[t.y]), c(mesh->positions[t.z]);
        return glm::cross(b - a, c - a);
    };
    Random random(10);
    int tested = 0, leaks = 0;
    while (tested < 1000000) {
        for (const auto& [edge, sharers] : edges) {
            if (sharers.size() != 2) continue;
            const vec3 target =
                glm::mix(mesh->positions[edge.first], mesh->positions[edge.second], random.uniform(0.05f, 0.95f));
            const vec3 direction = random.direction();
            const glm::dvec3 n0 = normal_of(sharers[0]), n1 = normal_of(sharers[1]);
            const double c0 = glm::dot(n0, glm::dvec3(direction)) / glm::length(n0);
            const double c1 = glm::dot(n1, glm::dvec3(direction)) / glm::length(n1);
            if (!(c0 * c1 > 0.01)) continue;  // a silhouette, or nearly
            ++tested;
            const kernels::Ray r = ray(target - 0.3f * direction, direction);
            const Hit hit = kernels::trace_closest(scene, r, kernels::TRACE_ALL);
            if (!(hit.t < 0.3001f) && leaks++ == 0) ADD_FAILURE() << describe(r);
        }
    }
    EXPECT_EQ(leaks, 0) << "of " << tested;
}

}  // namespace
}  // namespace spinel::traverse_test
