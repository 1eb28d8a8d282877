#include "formats/mesh_assimp.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gltf_file.h"
#include "image/image_io.h"
#include "image/tone_map.h"
#include "kernels/constants.h"
#include "kernels/materials.h"
#include "scene/validate.h"

namespace spinel::mesh_test {
namespace {

const MeshGeometry& mesh_of(const Scene& scene, std::size_t geometry = 0) {
    return std::get<MeshGeometry>(scene.geometries[geometry].data);
}

using Mesh = GltfTest;

const std::string triangle_obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST_F(Mesh, polygons_of_an_obj_become_triangles_with_smooth_normals) {
    const Result<Scene> scene = load_mesh(write("a.obj", triangle_obj + "v 1 1 0\nf 1 2 4 3\n"));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(validate(*scene));
    EXPECT_EQ(mesh_of(*scene).positions.size(), 4u);
    EXPECT_EQ(mesh_of(*scene).triangles.size(), 2u);
    for (const vec3& n : mesh_of(*scene).normals) EXPECT_EQ(n, vec3(0, 0, 1));
    EXPECT_EQ(scene->materials[0].values.kind, kernels::MATERIAL_DIFFUSE);
}

TEST_F(Mesh, mtl_materials_become_what_they_mean) {
    write("m.mtl",
          "newmtl matte\nKd 0.1 0.2 0.3\nnewmtl shiny\nKd 0.5 0 0\nKs 0.5 0.5 0.5\nNs 98\nillum 2\n"
          "newmtl mirror\nKd 0 0 0\nKs 0.9 0.8 0.7\nillum 3\nnewmtl glass\nKd 0 0 0\nNi 1.33\nillum 7\n"
          "newmtl lamp\nKd 0 0 0\nKe 5 6 7\nnewmtl veil\nKd 1 1 1\nd 0.25\n");
    std::string obj = "mtllib m.mtl\n" + triangle_obj;
    for (const char* name : {"matte", "shiny", "mirror", "glass", "lamp", "veil"})
        obj += std::string("usemtl ") + name + "\nf 1 2 3\n";
    const Result<Scene> scene = load_mesh(write("a.obj", obj));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(validate(*scene)) << validate(*scene).error().message;
    const auto named = [&](const std::string& name) {
        for (const Material& m : scene->materials)
            if (m.name == name) return m.values;
        ADD_FAILURE() << "no material " << name;
        return kernels::Material{};
    };
    EXPECT_EQ(named("matte").kind, kernels::MATERIAL_DIFFUSE);
    EXPECT_FLOAT_EQ(named("matte").color.z, 0.3f);
    EXPECT_EQ(named("shiny").kind, kernels::MATERIAL_PLASTIC);
    EXPECT_NEAR(named("shiny").roughness, std::pow(0.02f, 0.25f), 1e-5f);
    EXPECT_EQ(named("mirror").kind, kernels::MATERIAL_METAL);
    EXPECT_FLOAT_EQ(named("mirror").color.y, 0.8f);
    EXPECT_EQ(named("glass").kind, kernels::MATERIAL_DIELECTRIC);
    EXPECT_FLOAT_EQ(named("glass").ior, 1.33f);
    EXPECT_FLOAT_EQ(named("lamp").emission.z, 7.0f);
    EXPECT_FLOAT_EQ(named("veil").opacity, 0.25f);
}

TEST_F(Mesh, textures_of_an_obj_are_found_beside_it) {
    write_png("red map.png", Image{2, 1, 3, {1, 0, 0, 0, 1, 0}}, {"R", "G", "B"});
    write_png("holes.png", Image{2, 1, 1, {0, 1}}, {"Y"});
    write("m.mtl", "newmtl a\nKd 1 1 1\nmap_Kd red map.png\nmap_d holes.png\n");
    const std::string obj = "mtllib m.mtl\n" + triangle_obj + "vt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";
    const Result<Scene> scene = load_mesh(write("a.obj", obj));
    ASSERT_TRUE(scene) << scene.error().message;
    const kernels::Material& m = scene->materials[0].values;
    ASSERT_LT(m.color_texture, scene->textures.size());
    ASSERT_LT(m.opacity_texture, scene->textures.size());
    const auto& color = std::get<ImageTexture>(scene->textures[m.color_texture].data);
    EXPECT_TRUE(color.srgb);
    EXPECT_EQ(color.pixels->width, 2);
    const auto& opacity = std::get<ImageTexture>(scene->textures[m.opacity_texture].data);
    EXPECT_FALSE(opacity.srgb);
    EXPECT_EQ(std::get<std::vector<std::uint8_t>>(opacity.pixels->data), (std::vector<std::uint8_t>{255, 0, 255, 255}));
    ASSERT_EQ(mesh_of(*scene).tangents.size(), 3u);
    EXPECT_EQ(mesh_of(*scene).tangents[0], vec4(1, 0, 0, 1));
    EXPECT_EQ(mesh_of(*scene).uvs[2], vec2(0, 1));
}

TEST_F(Mesh, vertices_that_are_not_finite_are_named) {
    for (const std::string odd : {"nan", "inf", "-inf"}) {
        const auto obj = write("a.obj", "v 0 0 0\nv 1 " + odd + " 0\nv 0 1 0\nf 1 2 3\n");
        expect_refused(load_mesh(obj), obj, "vertex 1 is not finite");
    }
    std::string ply =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float "
        "y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    std::string good = ply, bad = ply, beyond = ply;
    for (int i = 0; i < 9; ++i) {
        good += raw(float(i * i));
        bad += raw(i == 7 ? NAN : float(i * i));
        beyond += raw(float(i * i));
    }
    const std::string face = std::string(1, '\3') + raw(0) + raw(1) + raw(2);
    EXPECT_TRUE(load_mesh(write("good.ply", good + face)));
    const auto bad_path = write("bad.ply", bad + face);
    expect_refused(load_mesh(bad_path), bad_path, "vertex 2 is not finite");
    const auto beyond_path = write("beyond.ply", beyond + std::string(1, '\3') + raw(0) + raw(1) + raw(7));
    expect_refused(load_mesh(beyond_path), beyond_path);
    const auto negative_path = write("negative.ply", beyond + std::string(1, '\3') + raw(0) + raw(1) + raw(-2));
    expect_refused(load_mesh(negative_path), negative_path);
}

TEST_F(Mesh, colors_of_a_scan_are_decoded_and_stand_on_white) {
    const auto path =
        write("a.ply",
              "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
              "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
              "property list uchar int vertex_indices\nend_header\n"
              "0 0 0 255 0 128\n1 0 0 255 0 128\n0 1 0 255 0 128\n3 0 1 2\n");
    const Result<Scene> scene = load_mesh(path);
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ(mesh_of(*scene).colors.size(), 3u);
    EXPECT_FLOAT_EQ(mesh_of(*scene).colors[0].x, 1.0f);
    EXPECT_NEAR(mesh_of(*scene).colors[0].z, srgb_decoded(128 / 255.0f), 1e-4f);
    EXPECT_EQ(scene->materials[std::size_t(scene->objects[0].materials[0])].values.color, vec3(1.0f));
}

TEST_F(Mesh, an_stl_is_smoothed_over_its_facets) {
    // Two facets that meet at 20°: their shared vertices get one normal.
    std::string stl(80, ' ');
    stl += raw(std::uint32_t(2));
    const float s = std::sin(glm::radians(20.0f)), c = std::cos(glm::radians(20.0f));
    for (const vec3& apex : {vec3(-1, 0, 0), vec3(c, 0, s)}) {
        for (int i = 0; i < 3; ++i) stl += raw(0.0f);
        const bool left = apex.x < 0;
        for (const vec3& p : {left ? vec3(0, 1, 0) : vec3(0, 0, 0), left ? vec3(0, 0, 0) : vec3(0, 1, 0), apex}) {
            for (int i = 0; i < 3; ++i) stl += raw(p[i]);
        }
        stl += raw(std::uint16_t(0));
    }
    const Result<Scene> scene = load_mesh(write("a.stl", stl));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(mesh_of(*scene).positions.size(), 4u);
    EXPECT_EQ(mesh_of(*scene).triangles.size(), 2u);
}

TEST_F(Mesh, gltf_nodes_place_one_geometry_many_times) {
    const auto path =
        gltf(R"([{"children": [1, 2], "translation": [1, 2, 3]}, {"mesh": 0, "name": "a", "scale": [2, 2, 2]},
                               {"mesh": 0, "name": "b", "rotation": [0, 0.70710678, 0, 0.70710678]}])",
             "[{}]");
    const Result<Scene> scene = load_gltf(path);
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(validate(*scene)) << validate(*scene).error().message;
    EXPECT_EQ(scene->geometries.size(), 1u);
    ASSERT_EQ(scene->objects.size(), 2u);
    EXPECT_EQ(scene->objects[0].name, "a");
    EXPECT_EQ(scene->objects[0].transform * vec4(1, 0, 0, 1), vec3(3, 2, 3));
    EXPECT_LT(glm::length(scene->objects[1].transform * vec4(1, 0, 0, 1) - vec3(1, 2, 2)), 1e-5f);
    // v grows upwards here, downwards in the file.
    EXPECT_EQ(mesh_of(*scene).uvs[0], vec2(0, 0));
    EXPECT_EQ(mesh_of(*scene).uvs[2], vec2(0, 1));
    EXPECT_EQ(mesh_of(*scene).tangents[0], vec4(1, 0, 0, 1));
}

TEST_F(Mesh, gltf_materials_keep_their_factors_and_textures) {
    write_png("c.png", Image{1, 1, 4, {0.2f, 0.4f, 0.6f, 0.4f}}, {"R", "G", "B", "A"});
    const auto path = gltf(R"([{"mesh": 0}])", R"([{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 0.8],
            "metallicFactor": 0.3, "roughnessFactor": 0.7, "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 0}}, "normalTexture": {"index": 0, "scale": 0.5},
            "emissiveFactor": [1, 0.5, 0], "alphaMode": "BLEND", "doubleSided": true,
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}, "KHR_materials_ior": {"ior": 1.7}}}])",
                           R"(, "textures": [{"source": 0, "sampler": 0}], "images": [{"uri": "c.png"}],
            "samplers": [{"magFilter": 9728, "wrapS": 33071, "wrapT": 33071}])");
    const Result<Scene> scene = load_gltf(path);
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(validate(*scene)) << validate(*scene).error().message;
    const kernels::Material& m = scene->materials[0].values;
    EXPECT_EQ(m.kind, kernels::MATERIAL_PRINCIPLED);
    EXPECT_EQ(m.color, vec3(0.5f, 0.25f, 1));
    EXPECT_FLOAT_EQ(m.metallic, 0.3f);
    EXPECT_FLOAT_EQ(m.roughness, 0.7f);
    EXPECT_FLOAT_EQ(m.normal_scale, 0.5f);
    EXPECT_FLOAT_EQ(m.ior, 1.7f);
    EXPECT_FLOAT_EQ(m.opacity, 0.8f);
    EXPECT_EQ(m.emission, vec3(4, 2, 0));
    EXPECT_EQ(m.emission_two_sided, 1u);
    EXPECT_EQ(m.metallic_texture, m.roughness_texture);
    const auto texture = [&](std::uint32_t i) { return std::get<ImageTexture>(scene->textures.at(i).data); };
    EXPECT_TRUE(texture(m.color_texture).srgb);
    EXPECT_FALSE(texture(m.normal_texture).srgb);
    EXPECT_FALSE(texture(m.roughness_texture).srgb);
    EXPECT_EQ(texture(m.color_texture).filter, Filter::nearest);
    EXPECT_EQ(texture(m.color_texture).wrap, Wrap::clamp);
    EXPECT_EQ(texture(m.normal_texture).pixels, texture(m.roughness_texture).pixels);  // read once
    const auto& alpha = std::get<std::vector<std::uint8_t>>(texture(m.opacity_texture).pixels->data);
    EXPECT_EQ(alpha.back(), 102);
}

TEST_F(Mesh, a_mask_is_all_or_nothing_at_its_cutoff) {
    write_png("c.png", Image{2, 1, 4, {1, 1, 1, 0.4f, 1, 1, 1, 0.6f}}, {"R", "G", "B", "A"});
    const auto path = gltf(R"([{"mesh": 0}])",
                           R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "alphaMode": "MASK"}])",
                           R"(, "textures": [{"source": 0}], "images": [{"uri": "c.png"}])");
    const Result<Scene> scene = load_gltf(path);
    ASSERT_TRUE(scene) << scene.error().message;
    const auto& texture = std::get<ImageTexture>(scene->textures.at(scene->materials[0].values.opacity_texture).data);
    EXPECT_EQ(std::get<std::vector<std::uint8_t>>(texture.pixels->data), (std::vector<std::uint8_t>{255, 0, 255, 255}));
}

TEST_F(Mesh, transmission_becomes_glass_that_attenuates) {
    const auto path =
        gltf(R"([{"mesh": 0}])", R"([{"pbrMetallicRoughness": {"roughnessFactor": 0}, "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.33}, "KHR_materials_volume":
        {"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [0.25, 0.5, 1]}}}])",
             R"(, "extensionsUsed": ["KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior"])");
    const Result<Scene> scene = load_gltf(path);
    ASSERT_TRUE(scene) << scene.error().message;
    const kernels::Material& m = scene->materials[0].values;
    EXPECT_EQ(m.kind, kernels::MATERIAL_DIELECTRIC);
    EXPECT_FLOAT_EQ(m.ior, 1.33f);
    EXPECT_EQ(m.roughness, 0.0f);
    EXPECT_NEAR(std::exp(-2 * m.absorption.x), 0.25f, 1e-5f);
    EXPECT_NEAR(std::exp(-2 * m.absorption.y), 0.5f, 1e-5f);
    EXPECT_EQ(m.absorption.z, 0.0f);
}

TEST_F(Mesh, gltf_cameras_and_lights_stand_where_their_nodes_are) {
    const auto path =
        gltf(R"([{"children": [1, 2, 3]}, {"mesh": 0}, {"camera": 0, "name": "eye", "translation": [0, 1, 5]},
        {"translation": [3, 4, 5], "extensions": {"KHR_lights_punctual": {"light": 0}}}])",
             "[{}]", R"(, "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "color": [1, 0.5, 0], "intensity": 10}]}})");
    const Result<Scene> scene = load_gltf(path);
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(validate(*scene)) << validate(*scene).error().message;
    ASSERT_EQ(scene->cameras.size(), 1u);
    EXPECT_EQ(scene->cameras[0].from, vec3(0, 1, 5));
    EXPECT_EQ(scene->cameras[0].at, vec3(0, 1, 4));
    EXPECT_NEAR(scene->cameras[0].fov, glm::degrees(0.5f), 1e-4f);
    ASSERT_EQ(scene->lights.size(), 1u);
    const auto& light = std::get<PointLight>(scene->lights[0].data);
    EXPECT_EQ(light.position, vec3(3, 4, 5));
    EXPECT_EQ(light.intensity, vec3(10, 5, 0));
}

TEST_F(Mesh, what_cannot_be_read_right_is_refused_with_its_name) {
    const auto draco = gltf(R"([{"mesh": 0}])", "[{}]", R"(, "extensionsRequired": ["EXT_meshopt_compression"])");
    expect_refused(load_gltf(draco), draco, "EXT_meshopt_compression");
    const auto missing = gltf(R"([{"mesh": 0}])", R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])",
                              R"(, "textures": [{"source": 0}], "images": [{"uri": "gone.png"}])");
    expect_refused(load_gltf(missing), missing, "gone.png");
    for (const auto& [name, bytes] : std::map<std::string, std::string>{{"empty.obj", ""},
                                                                        {"points.obj", triangle_obj},
                                                                        {"lines.obj", triangle_obj + "l 1 2\n"},
                                                                        {"beyond.obj", triangle_obj + "f 1 2 9\n"},
                                                                        {"text.ply", "hello"},
                                                                        {"short.stl", std::string(84, '\1')},
                                                                        {"a.off", "OFF\n3 1 0\n0 0 0\n"}}) {
        const auto path = write(name, bytes);
        expect_refused(load_mesh(path), path);
    }
    for (const auto& [name, bytes] :
         std::map<std::string, std::string>{{"text.gltf", "hello"},
                                            {"empty.glb", ""},
                                            {"cut.glb", "glTF" + raw(2) + raw(999) + raw(999) + "JSON{"},
                                            {"array.gltf", "[]"},
                                            {"old.glb", "glTF" + raw(1) + raw(20) + raw(0) + raw(0)}}) {
        const auto path = write(name, bytes);
        expect_refused(load_gltf(path), path);
    }
    expect_refused(load_mesh(folder / "absent.obj"), folder / "absent.obj", "no such file");
}

TEST_F(Mesh, reads_real_files) {
    if (!std::filesystem::exists(data_folder / "mesh")) GTEST_SKIP() << "no " << data_folder / "mesh";
    struct Case {
        const char* file;
        std::size_t objects, triangles, textures;
    };
    for (const Case& c : {Case{"mesh/common/spot.obj", 1, 5856, 0},
                          {"mesh/common/suzanne.obj", 1, 968, 0},
                          {"mesh/stanford/bun_zipper_res4.ply", 1, 948, 0},
                          {"mesh/mitsuba/bunny_binary.ply", 1, 69451, 0},
                          {"mesh/stl/spider_ascii.stl", 1, 1368, 0},
                          {"mesh/stl/spider_binary.stl", 1, 1368, 0},
                          {"mesh/gltf/DamagedHelmet.glb", 1, 15452, 4},
                          {"mesh/gltf/living_room.glb", 7, 5088, 0},
                          {"mesh/gltf/AttenuationTest.glb", 23, 232, 2}}) {
        const std::filesystem::path path = data_folder / c.file;
        const Result<Scene> scene = path.extension() == ".glb" ? load_gltf(path) : load_mesh(path);
        ASSERT_TRUE(scene) << scene.error().message;
        const Result<void> valid = validate(*scene);
        EXPECT_TRUE(valid) << c.file << ": " << valid.error().message;
        EXPECT_EQ(scene->objects.size(), c.objects) << c.file;
        EXPECT_EQ(scene->textures.size(), c.textures) << c.file;
        std::size_t triangles = 0;
        for (std::size_t g = 0; g < scene->geometries.size(); ++g) triangles += mesh_of(*scene, g).triangles.size();
        EXPECT_EQ(triangles, c.triangles) << c.file;
    }
}

TEST_F(Mesh, the_normals_of_a_scan_point_the_way_its_faces_do) {
    const auto path = data_folder / "mesh/mitsuba/bunny_binary.ply";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
    const Result<Scene> scene = load_mesh(path);
    ASSERT_TRUE(scene);
    const MeshGeometry& mesh = mesh_of(*scene);
    for (const uvec3& t : mesh.triangles) {
        const vec3 n = glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
        if (glm::length(n) == 0.0f) continue;
        for (int c = 0; c < 3; ++c) ASSERT_GT(glm::dot(glm::normalize(n), mesh.normals[t[c]]), -0.2f);
    }
}

}  // namespace
}  // namespace spinel::mesh_test
