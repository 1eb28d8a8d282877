#include "geometry/mesh/mesh_builder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/test_scene.h"

namespace spinel::mesh_builder_test {
namespace {

using namespace test;

MeshGeometry square() {
    MeshGeometry mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

std::string error_of(const MeshGeometry& mesh) {
    const auto result = build_mesh(mesh);
    return result ? "" : result.error().message;
}

TEST(MeshBuilder, triangles_in_leaf_order_remember_where_they_came_from) {
    MeshGeometry mesh = icosphere(3);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) mesh.slots.push_back(std::uint32_t(i % 5));
    const auto built = build_mesh(mesh);
    ASSERT_TRUE(built);
    ASSERT_EQ(built->triangles.size(), mesh.triangles.size());
    ASSERT_EQ(built->infos.size(), mesh.triangles.size());
    std::vector<int> seen(mesh.triangles.size(), 0);
    for (std::size_t i = 0; i < built->triangles.size(); ++i) {
        const kernels::TriangleInfo& info = built->infos[i];
        ++seen[info.primitive];
        EXPECT_EQ(info.slot, info.primitive % 5);
        EXPECT_EQ(info.vertices, mesh.triangles[info.primitive]);
        EXPECT_EQ(built->triangles[i].a, mesh.positions[info.vertices.x]);
        EXPECT_EQ(built->triangles[i].b, mesh.positions[info.vertices.y]);
        EXPECT_EQ(built->triangles[i].c, mesh.positions[info.vertices.z]);
    }
    for (const int times : seen) EXPECT_EQ(times, 1);
}

TEST(MeshBuilder, bounds_are_those_of_the_vertices) {
    const auto built = build_mesh(square());
    ASSERT_TRUE(built);
    EXPECT_EQ(built->bounds.lower, vec3(0));
    EXPECT_EQ(built->bounds.upper, vec3(1, 1, 0));
}

TEST(MeshBuilder, triangles_without_area_are_left_out) {
    MeshGeometry mesh = square();
    mesh.triangles.insert(mesh.triangles.begin(), {{1, 1, 1}, {0, 0, 2}});
    mesh.positions.push_back({2, 0, 0});
    mesh.triangles.push_back({0, 1, 4});  // on a line
    const auto built = build_mesh(mesh);
    ASSERT_TRUE(built);
    ASSERT_EQ(built->triangles.size(), 2u);
    EXPECT_EQ(built->infos[0].primitive + built->infos[1].primitive, 2u + 3u);
    mesh.triangles = {{0, 0, 1}};
    const auto nothing = build_mesh(mesh);
    ASSERT_TRUE(nothing);
    EXPECT_TRUE(nothing->structure.nodes.empty());
}

TEST(MeshBuilder, bad_meshes_are_refused_with_the_culprit_named) {
    EXPECT_EQ(error_of(MeshGeometry{}), "mesh has no triangles");
    MeshGeometry mesh = square();
    mesh.triangles[1].y = 4;
    EXPECT_EQ(error_of(mesh), "mesh triangle 1 refers to vertex 4, but there are only 4");
    mesh = square();
    mesh.positions[3].y = std::nanf("");
    EXPECT_EQ(error_of(mesh), "mesh vertex 3 has a position that is not finite");
    mesh = square();
    mesh.normals.resize(3);
    EXPECT_EQ(error_of(mesh), "mesh has 3 normals for 4 vertices; allowed: none, or one for each");
    mesh = square();
    mesh.slots.resize(4);
    EXPECT_EQ(error_of(mesh), "mesh has 4 material slots for 2 triangles; allowed: none, or one for each");
}

}  // namespace
}  // namespace spinel::mesh_builder_test
