#include "formats/mesh_attributes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace spinel::mesh_attributes_test {
namespace {

// A unit cube of twelve triangles over eight shared corners.
MeshGeometry cube() {
    MeshGeometry mesh;
    for (int i = 0; i < 8; ++i) mesh.positions.emplace_back(i & 1, i >> 1 & 1, i >> 2);
    for (const auto& [a, b, c, d] :
         {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
        mesh.triangles.emplace_back(a, b, c);
        mesh.triangles.emplace_back(a, c, d);
    }
    return mesh;
}

vec3 face_normal(const MeshGeometry& mesh, uvec3 t) {
    return glm::normalize(
        glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
}

TEST(MeshAttributes, a_cube_keeps_its_edges) {
    MeshGeometry mesh = cube();
    generate_normals(mesh, 60);
    EXPECT_EQ(mesh.positions.size(), 24u);
    ASSERT_EQ(mesh.normals.size(), 24u);
    for (const uvec3& t : mesh.triangles)
        for (int c = 0; c < 3; ++c) EXPECT_GT(glm::dot(mesh.normals[t[c]], face_normal(mesh, t)), 0.9999f);
}

TEST(MeshAttributes, smooth_normals_weigh_faces_by_angle_not_by_triangles) {
    // With everything smooth a corner's normal is its diagonal, though one of its faces may have two
    // triangles there.
    MeshGeometry mesh = cube();
    generate_normals(mesh, 180);
    EXPECT_EQ(mesh.positions.size(), 8u);
    for (std::size_t i = 0; i < 8; ++i) {
        const vec3 diagonal = glm::normalize(mesh.positions[i] - vec3(0.5f));
        EXPECT_LT(glm::length(mesh.normals[i] - diagonal), 1e-5f);
    }
}

TEST(MeshAttributes, vertices_at_one_place_are_smoothed_as_one) {
    MeshGeometry mesh = cube(), soup;
    for (const uvec3& t : mesh.triangles) {
        for (int c = 0; c < 3; ++c) soup.positions.push_back(mesh.positions[t[c]]);
        const auto n = std::uint32_t(soup.positions.size());
        soup.triangles.emplace_back(n - 3, n - 2, n - 1);
    }
    soup.positions[0].x = -0.0f;  // the same place
    generate_normals(mesh, 180);
    generate_normals(soup, 180);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int c = 0; c < 3; ++c)
            EXPECT_LT(glm::length(mesh.normals[mesh.triangles[t][c]] - soup.normals[soup.triangles[t][c]]), 1e-5f);
}

TEST(MeshAttributes, degenerate_triangles_and_tiny_coordinates_give_no_nan) {
    MeshGeometry mesh;
    mesh.positions = {{0, 0, 0}, {1e-20f, 0, 0}, {0, 1e-20f, 0}, {5, 5, 5}};
    mesh.triangles = {{0, 1, 2}, {3, 3, 3}, {0, 1, 1}};
    mesh.uvs = {{0, 0}, {1, 0}, {0, 1}, {0, 0}};
    generate_normals(mesh, 60);
    generate_tangents(mesh);
    for (const vec3& n : mesh.normals) EXPECT_TRUE(glm::length(n) == 0.0f || std::abs(glm::length(n) - 1) < 1e-5f);
    for (const vec4& t : mesh.tangents) EXPECT_TRUE(t == vec4(0) || std::abs(glm::length(vec3(t)) - 1) < 1e-5f);
    const uvec3 tiny = mesh.triangles[0];
    EXPECT_NEAR(mesh.normals[tiny.x].z, 1.0f, 1e-6f);
    EXPECT_NEAR(mesh.tangents[tiny.x].x, 1.0f, 1e-6f);
}

TEST(MeshAttributes, welding_merges_only_what_is_equal) {
    MeshGeometry mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.uvs = {{0, 0}, {1, 0}, {0, 1}, {0, 0}, {0.5f, 0}, {0, 1}};
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    weld_vertices(mesh);
    EXPECT_EQ(mesh.positions.size(), 4u);
    EXPECT_EQ(mesh.uvs.size(), 4u);
    EXPECT_EQ(mesh.triangles[0], uvec3(0, 1, 2));
    EXPECT_EQ(mesh.triangles[1], uvec3(0, 3, 2));
}

TEST(MeshAttributes, tangents_run_along_u_and_mirrored_uvs_get_the_other_hand) {
    // Two quads side by side, u growing away from the seam x = 0 on both sides.
    MeshGeometry mesh;
    mesh.positions = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, 1, 0}};
    mesh.uvs = {{0, 0}, {0, 1}, {1, 0}, {1, 1}, {1, 0}, {1, 1}};
    mesh.normals.assign(6, {0, 0, 1});
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4}};
    generate_tangents(mesh);
    EXPECT_EQ(mesh.positions.size(), 8u);  // the seam twice
    for (std::size_t t = 0; t < 4; ++t) {
        for (int c = 0; c < 3; ++c) {
            const std::uint32_t v = mesh.triangles[t][c];
            const vec4 tangent = mesh.tangents[v];
            EXPECT_NEAR(tangent.x, t < 2 ? 1.0f : -1.0f, 1e-6f);
            // The bitangent n × t · w runs along +v, which is +y on both sides.
            const vec3 bitangent = glm::cross(mesh.normals[v], vec3(tangent)) * tangent.w;
            EXPECT_NEAR(bitangent.y, 1.0f, 1e-6f);
        }
    }
}

}  // namespace
}  // namespace spinel::mesh_attributes_test
