#include <gtest/gtest.h>

#include "core/pool.h"
#include "kernels/materials.h"
#include "scene/compiled_scene.h"
#include "scene/material_registry.h"

namespace spinel::compile_test {
namespace {

MeshGeometry triangle() {
    MeshGeometry mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

// A preset goes with the structure that it is said of.
TEST(Compile, a_preset_is_checked_and_left_with_its_structure) {
    Scene scene;
    scene.geometries = {{"bare", triangle()}};
    scene.materials.push_back({"grey", default_material(kernels::MATERIAL_DIFFUSE)});
    scene.objects.emplace_back().geometry = 0;
    scene.objects[0].materials = {0};
    scene.cameras.push_back({});
    scene.accelerator.preset = "fast";
    EXPECT_TRUE(compile(scene));
    EXPECT_TRUE(compile(scene, {.accelerator = {"kd-tree", ""}}));
    const auto wrong = compile(scene, {.accelerator = {"kd-tree", "", "fast"}});
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().message.find("'kd-tree' has no presets"), std::string::npos) << wrong.error().message;
    scene.accelerator.structure = "kd-tree";
    ASSERT_FALSE(compile(scene));
}

TEST(Compile, a_mesh_takes_room_for_the_attributes_that_it_has_only) {
    Scene scene;
    MeshGeometry bare = triangle(), textured = triangle(), painted = triangle();
    textured.uvs = {{0, 0}, {1, 0}, {0, 1}};
    textured.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    painted.uvs = {{2, 0}, {3, 0}, {2, 1}};
    painted.second_uvs = {{4, 0}, {5, 0}, {4, 1}};
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
    ASSERT_EQ(meshes.size(), 4u) << "the three, and that of all their triangles";
    for (const kernels::uint first : {meshes[3].uv_first, meshes[3].second_uv_first, meshes[3].normal_first,
                                      meshes[3].tangent_first, meshes[3].color_first})
        EXPECT_EQ(first, kernels::NONE);
    EXPECT_EQ(meshes[3].triangle_count, 3u);
    EXPECT_EQ(meshes[0].uv_first, kernels::NONE);
    EXPECT_EQ(meshes[0].normal_first, kernels::NONE);
    EXPECT_EQ(meshes[0].tangent_first, kernels::NONE);
    EXPECT_EQ(meshes[0].color_first, kernels::NONE);
    EXPECT_EQ(meshes[1].normal_first, 0u);
    EXPECT_EQ(meshes[1].uv_first, 0u);
    EXPECT_EQ(meshes[2].normal_first, kernels::NONE);
    EXPECT_EQ(meshes[2].uv_first, 3u);
    EXPECT_EQ(meshes[2].color_first, 0u);
    EXPECT_EQ(meshes[1].second_uv_first, kernels::NONE);
    EXPECT_EQ(meshes[2].second_uv_first, 6u);
    ASSERT_EQ(compiled->uvs.size(), 9u);
    EXPECT_EQ(compiled->uvs[4], vec2(3, 0));
    EXPECT_EQ(compiled->uvs[7], vec2(5, 0));
}

TEST(Compile, pools_end_where_32_bit_indices_do) {
    std::vector<int> pool = {1, 2};
    const Result<std::uint32_t> first = append_pool(pool, std::vector<int>{3, 4}, "things");
    ASSERT_TRUE(first);
    EXPECT_EQ(*first, 2u);
    EXPECT_EQ(pool, (std::vector<int>{1, 2, 3, 4}));

    ASSERT_TRUE(pool_place(max_pool - 1, 1, "things"));
    EXPECT_EQ(*pool_place(max_pool, 0, "things"), 0xffffffffu);
    for (const auto& [size, more] : {std::pair<std::size_t, std::size_t>{max_pool, 1},
                                     {max_pool + 1, 0},
                                     {1, max_pool},
                                     {2, ~std::size_t(0)},
                                     {0, std::size_t(1) << 40}}) {
        const Result<std::uint32_t> place = pool_place(size, more, "nodes of voxels");
        ASSERT_FALSE(place) << size << " + " << more;
        EXPECT_EQ(place.error().message,
                  "the scene needs more than the 4294967295 nodes of voxels that can be addressed");
    }
}

}  // namespace
}  // namespace spinel::compile_test
