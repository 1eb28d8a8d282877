#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "formats/mesh_assimp.h"
#include "gltf_file.h"
#include "kernels/constants.h"
#include "kernels/materials.h"
#include "kernels/texture.h"
#include "scene/compiled_scene.h"
#include "scene/validate.h"
#include "spinel/render.h"

namespace spinel::gltf_material_test {
namespace {

class GltfMaterial : public GltfTest {
  protected:
    // The material of a triangle, its textures all c.png.
    kernels::Material load(const std::string& material, const std::string& more = "") {
        write_png("c.png", Image{2, 1, 4, {0.2f, 0.4f, 0.6f, 0.4f, 1, 1, 1, 1}}, {"R", "G", "B", "A"});
        Result<Scene> read = load_gltf(gltf(R"([{"mesh": 0}])", "[" + material + "]",
                                            R"(, "textures": [{"source": 0}, {"source": 0, "sampler": 0}],
            "images": [{"uri": "c.png"}], "samplers": [{"wrapS": 33648, "wrapT": 33071}],
            "extensionsUsed": ["KHR_materials_clearcoat", "KHR_materials_transmission", "KHR_materials_volume",
                               "KHR_materials_ior", "KHR_materials_unlit", "KHR_texture_transform"])" +
                                                more));
        EXPECT_TRUE(read) << read.error().message;
        if (!read) return {};
        scene = std::move(*read);
        const Result<void> valid = validate(scene);
        EXPECT_TRUE(valid) << valid.error().message;
        return scene.materials[0].values;
    }
    const ImageTexture& texture(kernels::uint index) { return std::get<ImageTexture>(scene.textures.at(index).data); }
    bool noted(const std::string& words) const {
        return std::any_of(scene.notes.begin(), scene.notes.end(),
                           [&](const std::string& note) { return note.find(words) != std::string::npos; });
    }
    Scene scene;
};

TEST_F(GltfMaterial, a_clear_coat_keeps_its_factors_and_textures) {
    const kernels::Material m = load(R"({"pbrMetallicRoughness": {"metallicFactor": 0.5, "roughnessFactor": 0.6},
        "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.25,
            "clearcoatTexture": {"index": 0}, "clearcoatRoughnessTexture": {"index": 1},
            "clearcoatNormalTexture": {"index": 0}}}})");
    EXPECT_EQ(m.kind, kernels::MATERIAL_PRINCIPLED);
    EXPECT_EQ(m.coat, 0.75f);
    EXPECT_EQ(m.coat_roughness, 0.25f);
    ASSERT_NE(m.coat_texture, kernels::NONE);
    ASSERT_NE(m.coat_roughness_texture, kernels::NONE);
    EXPECT_FALSE(texture(m.coat_texture).srgb);
    EXPECT_EQ(texture(m.coat_roughness_texture).wrap, Wrap::mirror);
    EXPECT_EQ(texture(m.coat_roughness_texture).wrap_v, WrapV::clamp);
    EXPECT_TRUE(noted("normal maps of clear coats"));
}

TEST_F(GltfMaterial, transmission_without_a_thickness_is_a_thin_wall) {
    const kernels::Material m = load(R"({"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.25, "transmissionTexture": {"index": 0}},
                       "KHR_materials_volume": {"attenuationDistance": 1}}})");
    EXPECT_EQ(m.kind, kernels::MATERIAL_PRINCIPLED);
    EXPECT_EQ(m.transmission, 0.25f);
    ASSERT_NE(m.transmission_texture, kernels::NONE);
    EXPECT_FALSE(texture(m.transmission_texture).srgb);
}

TEST_F(GltfMaterial, a_solid_that_transmits_in_part_is_rounded_and_told) {
    EXPECT_EQ(load(R"({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.75},
                       "KHR_materials_volume": {"thicknessFactor": 1}}})")
                  .kind,
              kernels::MATERIAL_DIELECTRIC);
    EXPECT_TRUE(noted("taken for whole"));
    EXPECT_EQ(load(R"({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.25},
                       "KHR_materials_volume": {"thicknessFactor": 1}}})")
                  .kind,
              kernels::MATERIAL_PRINCIPLED);
    EXPECT_TRUE(noted("taken for a thin wall"));
}

TEST_F(GltfMaterial, an_unlit_surface_shows_its_colour_from_both_sides) {
    const kernels::Material m = load(R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1],
        "baseColorTexture": {"index": 0}}, "extensions": {"KHR_materials_unlit": {}}})");
    EXPECT_EQ(m.color, vec3(0.0f));
    EXPECT_EQ(m.emission, vec3(1, 0.5f, 0.25f));
    EXPECT_EQ(m.emission_two_sided, 1u);
    ASSERT_NE(m.emission_texture, kernels::NONE);
    EXPECT_TRUE(texture(m.emission_texture).srgb);
}

TEST_F(GltfMaterial, specular_changes_the_index_to_one_of_the_same_reflectance) {
    const kernels::Material m = load(R"({"extensions": {"KHR_materials_specular": {"specularFactor": 0.25}}})");
    EXPECT_NEAR(kernels::fresnel_f0(m.ior), 0.01f, 1e-5f);
}

TEST_F(GltfMaterial, specular_changes_what_solid_glass_reflects_not_how_it_bends_light) {
    const std::string glass = R"("KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 1}, "KHR_materials_ior": {"ior": 1.7})";
    const kernels::Material plain = load(R"({"extensions": {)" + glass + "}}");
    EXPECT_EQ(plain.kind, kernels::MATERIAL_DIELECTRIC);
    EXPECT_EQ(plain.ior, 1.7f);
    EXPECT_FALSE(noted("specular factor"));
    const kernels::Material m =
        load(R"({"extensions": {"KHR_materials_specular": {"specularFactor": 0.25}, )" + glass + "}}");
    EXPECT_EQ(m.kind, kernels::MATERIAL_DIELECTRIC);
    EXPECT_EQ(m.ior, 1.7f);
    EXPECT_TRUE(noted("the specular factor of solid glass is left out"));
}

// An index of 0 stands for a Fresnel factor of 1.
TEST_F(GltfMaterial, an_index_of_0_reflects_most_of_all_and_is_told) {
    const kernels::Material m = load(R"({"extensions": {"KHR_materials_ior": {"ior": 0}}})");
    EXPECT_NEAR(kernels::fresnel_f0(m.ior), 0.25f, 1e-5f);
    EXPECT_TRUE(noted("which reflects all, is held to 3"));
    const kernels::Material faint = load(R"({"extensions": {"KHR_materials_ior": {"ior": 0},
        "KHR_materials_specular": {"specularFactor": 0.09}}})");
    EXPECT_NEAR(kernels::fresnel_f0(faint.ior), 0.09f, 1e-5f);
    const kernels::Material glass = load(R"({"extensions": {"KHR_materials_ior": {"ior": 0},
        "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 1}}})");
    EXPECT_EQ(glass.kind, kernels::MATERIAL_DIELECTRIC);
    EXPECT_EQ(glass.ior, 1.5f);
    EXPECT_TRUE(noted("cannot bend light"));
}

TEST_F(GltfMaterial, a_coat_above_emission_is_told) {
    const std::string coat = R"("extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1}})";
    load("{" + coat + "}");
    EXPECT_FALSE(noted("does not darken"));
    load(R"({"emissiveFactor": [1, 1, 1], )" + coat + "}");
    EXPECT_TRUE(noted("the clear coat does not darken the emission"));
}

TEST_F(GltfMaterial, each_texture_takes_its_own_set_of_coordinates) {
    const kernels::Material m = load(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}},
        "normalTexture": {"index": 0}, "emissiveTexture": {"index": 0, "extensions": {"KHR_texture_transform":
            {"texCoord": 1}}}, "emissiveFactor": [1, 1, 1]})");
    EXPECT_EQ(texture(m.normal_texture).uv_set, 0);
    EXPECT_EQ(texture(m.color_texture).uv_set, 1);
    EXPECT_EQ(texture(m.emission_texture).uv_set, 1);
    const auto& mesh = std::get<MeshGeometry>(scene.geometries[0].data);
    ASSERT_EQ(mesh.second_uvs.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        const vec2 down(mesh.uvs[i].x, 1 - mesh.uvs[i].y), second_down(mesh.second_uvs[i].x, 1 - mesh.second_uvs[i].y);
        EXPECT_EQ(second_down, 2.0f * down) << i;
    }
    // Where only the second set is used it is the mesh's one and only.
    const kernels::Material alone =
        load(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}}})");
    EXPECT_EQ(texture(alone.color_texture).uv_set, 0);
    EXPECT_TRUE(std::get<MeshGeometry>(scene.geometries[0].data).second_uvs.empty());
    EXPECT_EQ(std::get<MeshGeometry>(scene.geometries[0].data).uvs[1].x, 2.0f);
}

TEST_F(GltfMaterial, three_sets_of_coordinates_in_one_material_are_refused) {
    write_png("c.png", Image{1, 1, 3, {1, 1, 1}}, {"R", "G", "B"});
    const auto path =
        gltf(R"([{"mesh": 0}])", R"([{"name": "rich", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0,
        "texCoord": 1}}, "normalTexture": {"index": 0}, "emissiveTexture": {"index": 0, "texCoord": 2},
        "emissiveFactor": [1, 1, 1]}])",
             R"(, "textures": [{"source": 0}], "images": [{"uri": "c.png"}])");
    expect_refused(load_gltf(path), path, "material 'rich' uses three sets of texture coordinates");
}

// uv is scaled, turned counter-clockwise as one sees the picture, and moved, all with v downwards: what the formula of
// the extension gives for a few places, looked up through the renderer's own eyes.
TEST_F(GltfMaterial, texture_transforms_scale_turn_and_move) {
    const kernels::Material m = load(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions":
        {"KHR_texture_transform": {"offset": [0.1, 0.3], "rotation": 0.5, "scale": [2, 3]}}}}})");
    const Result<CompiledScene> compiled = compile(scene);
    ASSERT_TRUE(compiled) << compiled.error().message;
    const kernels::Texture t = compiled->textures.at(m.color_texture);
    const float c = std::cos(0.5f), s = std::sin(0.5f);
    for (const vec2 down : {vec2(0, 0), vec2(1, 0), vec2(0, 1), vec2(0.3f, 0.8f)}) {
        const vec2 expected_down(c * 2 * down.x + s * 3 * down.y + 0.1f, -s * 2 * down.x + c * 3 * down.y + 0.3f);
        const vec2 uv(down.x, 1 - down.y);
        const vec2 st = vec2(glm::dot(t.row_u, uv), glm::dot(t.row_v, uv)) + t.offset;
        EXPECT_NEAR(st.x, expected_down.x, 1e-5f);
        EXPECT_NEAR(1 - st.y, expected_down.y, 1e-5f);
    }
}

TEST_F(GltfMaterial, what_is_required_and_not_there_is_refused_by_its_name) {
    for (const std::string name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_mesh_quantization",
                                   "KHR_texture_basisu", "KHR_materials_sheen", "VENDOR_of_tomorrow"}) {
        const auto path = gltf(R"([{"mesh": 0}])", "[{}]", R"(, "extensionsRequired": [")" + name + R"("])");
        expect_refused(load_gltf(path), path, "it requires the extension " + name + ", which is not supported");
    }
}

TEST_F(GltfMaterial, what_is_left_out_is_told) {
    load("{}", R"(, "skins": [{"joints": [0]}], "animations": [{"channels": [], "samplers": []}])");
    EXPECT_TRUE(noted("animations, skins are left out"));
    Result<Scene> sheen = load_gltf(
        gltf(R"([{"mesh": 0}])", "[{}]", R"(, "extensionsUsed": ["KHR_materials_sheen", "KHR_materials_ior"])"));
    ASSERT_TRUE(sheen);
    ASSERT_EQ(sheen->notes.size(), 1u);
    EXPECT_NE(sheen->notes[0].find("KHR_materials_sheen"), std::string::npos);
    EXPECT_EQ(sheen->notes[0].find("KHR_materials_ior"), std::string::npos);
}

TEST_F(GltfMaterial, orthographic_cameras_keep_their_height) {
    const Result<Scene> read =
        load_gltf(gltf(R"([{"children": [1, 2]}, {"mesh": 0}, {"camera": 0, "name": "plan"}])", "[{}]",
                       R"(, "cameras": [{"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2,
        "znear": 0.1, "zfar": 9}}])"));
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->cameras.size(), 1u);
    EXPECT_EQ(read->cameras[0].kind, Camera::Kind::orthographic);
    EXPECT_EQ(read->cameras[0].height, 4.0f);
}

// ------------------------------------------------------------------------------------------------------------- OBJ
using MtlMaterial = GltfTest;
const std::string textured_triangle =
    "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";

TEST_F(MtlMaterial, metal_roughness_and_coat_of_the_pbr_extension_are_read) {
    write("m.mtl", "newmtl a\nKd 0.5 0.25 1\nPr 0.3\nPm 0.75\nPc 0.5\nPcr 0.125\n");
    const Result<Scene> scene = load_mesh(write("a.obj", textured_triangle));
    ASSERT_TRUE(scene) << scene.error().message;
    const kernels::Material& m = scene->materials[0].values;
    EXPECT_EQ(m.kind, kernels::MATERIAL_PRINCIPLED);
    EXPECT_EQ(m.color, vec3(0.5f, 0.25f, 1));
    EXPECT_FLOAT_EQ(m.roughness, 0.3f);
    EXPECT_FLOAT_EQ(m.metallic, 0.75f);
    EXPECT_FLOAT_EQ(m.coat, 0.5f);
    EXPECT_FLOAT_EQ(m.coat_roughness, 0.125f);
}

TEST_F(MtlMaterial, transparency_is_read_in_both_its_ways) {
    write("m.mtl", "newmtl a\nKd 1 1 1\nTr 0.75\n");
    const Result<Scene> scene = load_mesh(write("a.obj", textured_triangle));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_FLOAT_EQ(scene->materials[0].values.opacity, 0.25f);
}

TEST_F(MtlMaterial, heights_become_normals_and_normals_stay) {
    // A ramp that rises to the right by a quarter a texel: the normal leans to the left.
    write_png("ramp.png", Image{4, 1, 1, {0, 0.25f, 0.5f, 0.75f}}, {"Y"});
    write_png("normals.png", Image{1, 1, 3, {0.5f, 0.5f, 1}}, {"R", "G", "B"});
    write("m.mtl", "newmtl a\nKd 1 1 1\nmap_bump -bm 2 ramp.png\n");
    const Result<Scene> heights = load_mesh(write("a.obj", textured_triangle));
    ASSERT_TRUE(heights) << heights.error().message;
    ASSERT_LT(heights->materials[0].values.normal_texture, heights->textures.size());
    const auto& relief = std::get<ImageTexture>(heights->textures[heights->materials[0].values.normal_texture].data);
    EXPECT_FALSE(relief.srgb);
    const auto& bytes = std::get<std::vector<std::uint8_t>>(relief.pixels->data);
    const vec3 n = 2.0f * vec3(bytes[3], bytes[4], bytes[5]) / 255.0f - 1.0f;
    EXPECT_NEAR(n.x / n.z, -0.5f, 0.02f);
    EXPECT_NEAR(n.y, 0, 0.01f);

    for (const std::string key : {"map_bump", "norm"}) {
        write("m.mtl", "newmtl a\nKd 1 1 1\n" + key + " normals.png\n");
        const Result<Scene> normals = load_mesh(folder / "a.obj");
        ASSERT_TRUE(normals) << normals.error().message;
        const kernels::uint index = normals->materials[0].values.normal_texture;
        ASSERT_LT(index, normals->textures.size()) << key;
        const auto& map = std::get<ImageTexture>(normals->textures[index].data);
        EXPECT_EQ(std::get<std::vector<std::uint8_t>>(map.pixels->data).at(2), 255) << key;
    }
}

TEST_F(MtlMaterial, textures_that_are_not_there_are_left_out_and_named) {
    write("m.mtl", "newmtl a\nKd 0.5 0.5 0.5\nmap_Kd gone/wall.png\n");
    const Result<Scene> scene = load_mesh(write("a.obj", textured_triangle));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->materials[0].values.color_texture, kernels::NONE);
    EXPECT_EQ(scene->materials[0].values.color, vec3(0.5f));
    ASSERT_EQ(scene->notes.size(), 1u);
    EXPECT_EQ(scene->notes[0], "textures that are not there are left out (1): 'gone/wall.png'");
}

TEST_F(MtlMaterial, textures_in_folders_below_are_found_whatever_the_slash) {
    std::filesystem::create_directories(folder / "maps");
    write_png("maps/wall.png", Image{1, 1, 3, {1, 0, 0}}, {"R", "G", "B"});
    write("m.mtl", "newmtl a\nKd 0 0 0\nmap_Kd maps\\wall.png\nmap_Ke maps/wall.png\n");
    const Result<Scene> scene = load_mesh(write("a.obj", textured_triangle));
    ASSERT_TRUE(scene) << scene.error().message;
    const kernels::Material& m = scene->materials[0].values;
    EXPECT_NE(m.color_texture, kernels::NONE);
    EXPECT_EQ(m.color, vec3(1.0f));  // Kd 0 beside a map
    EXPECT_NE(m.emission_texture, kernels::NONE);
    EXPECT_EQ(m.emission, vec3(1.0f));
}

}  // namespace
}  // namespace spinel::gltf_material_test
