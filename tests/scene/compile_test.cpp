#include <gtest/gtest.h>

#include "kernels/materials.h"
#include "scene/compiled_scene.h"
#include "scene/material_registry.h"

namespace spinel {
namespace {

MeshGeometry triangle() {
    MeshGeometry mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

TEST(Compile, a_mesh_takes_room_for_the_attributes_that_it_has_only) {
    Scene scene;
    MeshGeometry bare = triangle(), textured = triangle(), painted = triangle();
    textured.uvs = {{0, 0}, {1, 0}, {0, 1}};
    textured.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    painted.uvs = {{2, 0}, {3, 0}, {2, 1}};
    painted.colors = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}};
    scene.geometries = {{"bare", bare}, {"textured", textured}, {"painted", painted}};
    scene.materials.push_back({"grey", default_material(kernels::MATERIAL_DIFFUSE)});
    for (int i = 0; i < 3; ++i) {
        Object object;
        object.geometry = i;
        object.materials = {0};
        scene.objects.push_back(object);
    }
    scene.cameras.push_back({});
    const auto compiled = compile(scene);
    ASSERT_TRUE(compiled) << compiled.error().message;
    const auto& meshes = compiled->meshes;
    ASSERT_EQ(meshes.size(), 3u);
    EXPECT_EQ(meshes[0].uv_first, kernels::NONE);
    EXPECT_EQ(meshes[0].normal_first, kernels::NONE);
    EXPECT_EQ(meshes[0].tangent_first, kernels::NONE);
    EXPECT_EQ(meshes[0].color_first, kernels::NONE);
    EXPECT_EQ(meshes[1].normal_first, 0u);
    EXPECT_EQ(meshes[1].uv_first, 0u);
    EXPECT_EQ(meshes[2].normal_first, kernels::NONE);
    EXPECT_EQ(meshes[2].uv_first, 3u);
    EXPECT_EQ(meshes[2].color_first, 0u);
    ASSERT_EQ(compiled->uvs.size(), 6u);
    EXPECT_EQ(compiled->uvs[4], vec2(3, 0));
}

}  // namespace
}  // namespace spinel
