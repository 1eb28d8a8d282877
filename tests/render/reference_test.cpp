#include "render/reference.h"

#include <gtest/gtest.h>

#include "geometry/test_scene.h"

namespace spinel::reference_test {
namespace {

using namespace test;

// The twin itself, against numbers worked out by hand.
double distance(TestScene& parts, const kernels::Ray& r) {
    return reference_hit(parts.view(), r, kernels::TRACE_ALL).t;
}

TEST(Reference, analytic_shapes) {
    const kernels::Ray down = ray(vec3(0.25f, 5, -0.5f), vec3(0, -2, 0));
    TestScene sphere, box, plane, rectangle;
    sphere.place(kernels::GEOMETRY_SPHERE);
    EXPECT_NEAR(distance(sphere, down), (5 - std::sqrt(1 - 0.0625 - 0.25)) / 2, 1e-12);
    box.place(kernels::GEOMETRY_BOX);
    EXPECT_DOUBLE_EQ(distance(box, down), 2);
    EXPECT_DOUBLE_EQ(distance(box, ray(vec3(0), vec3(0, -2, 0))), 0.5);
    plane.place(kernels::GEOMETRY_PLANE);
    EXPECT_DOUBLE_EQ(distance(plane, down), 2.5);
    EXPECT_DOUBLE_EQ(distance(plane, ray(vec3(1000, 1, 0), vec3(0, -1, 0))), 1);
    rectangle.place(kernels::GEOMETRY_RECTANGLE);
    const kernels::Hit hit = reference_hit(rectangle.view(), down, kernels::TRACE_ALL).hit;
    EXPECT_EQ(hit.t, 2.5f);
    EXPECT_EQ(hit.uv, vec2(0.625f, 0.75f));
    EXPECT_EQ(reference_hit(rectangle.view(), ray(vec3(1000, 1, 0), vec3(0, -1, 0)), kernels::TRACE_ALL).hit.instance,
              NO);
}

TEST(Reference, triangles_voxels_and_implicit_surfaces_under_a_transform) {
    const mat4x3 doubled = affine(glm::mat3(2), vec3(0, 0, 10));
    const kernels::Ray forward = ray(vec3(0.5f, 0.5f, 0), vec3(0, 0, 1));
    MeshGeometry mesh;
    mesh.positions = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
    mesh.triangles = {{0, 1, 2}};
    TestScene triangle;
    triangle.place(kernels::GEOMETRY_MESH, triangle.add(mesh), doubled);
    const ReferenceHit hit = reference_hit(triangle.view(), forward, kernels::TRACE_ALL);
    EXPECT_DOUBLE_EQ(hit.t, 12);
    EXPECT_EQ(hit.hit.uv, vec2(0.25f, 0.25f));

    const VoxelGeometry voxels = voxels_of({1, 1, 3}, {0, 1, 1});
    TestScene grid;
    grid.place(kernels::GEOMETRY_VOXELS, grid.add(voxels), doubled);
    EXPECT_DOUBLE_EQ(distance(grid, forward), 12);
    EXPECT_EQ(reference_hit(grid.view(), forward, kernels::TRACE_ALL).hit.cell, ivec3(0, 0, 1));
    TestScene glass;
    glass.place(kernels::GEOMETRY_VOXELS, glass.add(voxels), doubled, {{0, 0}});
    kernels::Ray inside = forward;
    inside.t_min = 13;
    EXPECT_DOUBLE_EQ(distance(glass, inside), 16);  // the far side of both cells

    TestScene sdf;
    sdf.place(kernels::GEOMETRY_SDF, sdf.add_sdf_sphere(0.75f), doubled);
    EXPECT_NEAR(distance(sdf, ray(vec3(0), vec3(0, 0, 1))), 8.5, 1e-5);
    EXPECT_NEAR(distance(sdf, ray(vec3(0, 0, 10), vec3(0, 0, 1))), 1.5, 1e-5);
}

}  // namespace
}  // namespace spinel::reference_test
