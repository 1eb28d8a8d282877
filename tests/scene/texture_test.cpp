#include <gtest/gtest.h>

#include "image/pixels.h"
#include "kernels/materials.h"
#include "kernels/surface.h"
#include "scene/compiled_scene.h"
#include "scene/host_texture.h"
#include "scene/material_registry.h"

namespace spinel::texture_test {
namespace {

// A picture of 4×2 texels whose red and green tell column and row, row 0 at the top.
ImageTexture numbered() {
    PixelBuffer pixels{4, 2, 3, {}};
    auto& bytes = pixels.data.emplace<std::vector<std::uint8_t>>();
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 4; ++x) bytes.insert(bytes.end(), {std::uint8_t(x), std::uint8_t(y), 0});
    ImageTexture texture;
    texture.pixels = std::make_shared<const PixelBuffer>(std::move(pixels));
    texture.srgb = false;
    texture.filter = Filter::nearest;
    return texture;
}

// A triangle at z = 0 with two sets of uvs, the second moved by (10, 0.25).
Scene scene_of(const ImageTexture& texture) {
    Scene scene;
    MeshGeometry mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
    mesh.second_uvs = {{10, 0.25f}, {11, 0.25f}, {10, 1.25f}};
    scene.geometries = {{"triangle", mesh}};
    scene.textures = {{"numbered", texture}};
    scene.materials.push_back({"grey", default_material(kernels::MATERIAL_DIFFUSE)});
    scene.materials[0].values.color_texture = 0;
    Object object;
    object.geometry = 0;
    object.materials = {0};
    scene.objects.push_back(object);
    scene.cameras.push_back({});
    return scene;
}

ivec2 texel(const vec4& value) { return ivec2(std::lround(value.x * 255), std::lround(value.y * 255)); }

ivec2 texel_at(const ImageTexture& image, vec2 uv) {
    const Scene scene = scene_of(image);
    const Result<CompiledScene> compiled = compile(scene);
    if (!compiled) {
        ADD_FAILURE() << compiled.error().message;
        return {};
    }
    const ivec2 seen = texel(kernels::texture_at(compiled->view(), 0, kernels::both_uvs(uv), kernels::NONE));
    EXPECT_EQ(texel(HostTexture(scene.textures[0]).at(uv, 0)), seen) << "the host sees another texel";
    return seen;
}

TEST(TexturePlace, a_turn_is_counter_clockwise_after_the_scale) {
    ImageTexture image = numbered();
    EXPECT_EQ(texel_at(image, {0.6f, 0.2f}), ivec2(2, 1));
    image.rotation = 90;  // (u, v) → (−v, u)
    EXPECT_EQ(texel_at(image, {0.6f, 0.2f}), ivec2(3, 0));
    image.scale = {0.5f, 2};
    EXPECT_EQ(texel_at(image, {0.6f, 0.2f}), ivec2(2, 1));
    image.offset = {0.25f, 0.5f};
    EXPECT_EQ(texel_at(image, {0.6f, 0.2f}), ivec2(3, 0));
}

TEST(TexturePlace, each_direction_wraps_its_own_way) {
    ImageTexture image = numbered();
    image.wrap = Wrap::clamp;
    EXPECT_EQ(texel_at(image, {1.3f, 1.2f}), ivec2(3, 0));
    image.wrap_v = WrapV::repeat;
    EXPECT_EQ(texel_at(image, {1.3f, 1.2f}), ivec2(3, 1));
    image.wrap_v = WrapV::mirror;
    EXPECT_EQ(texel_at(image, {1.3f, 1.6f}), ivec2(3, 1));
    EXPECT_EQ(texel_at(image, {1.3f, 1.2f}), ivec2(3, 0));
}

TEST(TexturePlace, a_surface_looks_a_texture_up_in_its_own_set) {
    for (const int set : {0, 1}) {
        ImageTexture image = numbered();
        image.uv_set = set;
        const Scene scene = scene_of(image);
        const Result<CompiledScene> compiled = compile(scene);
        ASSERT_TRUE(compiled) << compiled.error().message;
        const kernels::Ray ray{{0.3f, 0.4f, 1}, 0, {0, 0, -1}, kernels::INFINITE};
        kernels::Hit hit = kernels::no_hit(kernels::INFINITE);
        hit.t = 1;
        hit.instance = hit.primitive = 0;
        hit.uv = {0.3f, 0.4f};
        hit.normal = {0, 0, 1};
        const kernels::Surface s = kernels::surface_at(compiled->view(), ray, hit);
        EXPECT_NEAR(s.uvs.x, 0.3f, 1e-6f);
        EXPECT_NEAR(s.uvs.z, 10.3f, 1e-5f);
        EXPECT_NEAR(s.uvs.w, 0.65f, 1e-6f);
        const kernels::Bsdf b = kernels::surface_bsdf(compiled->view(), s, 1);
        EXPECT_EQ(texel(vec4(b.color / scene.materials[0].values.color, 1)), set == 0 ? ivec2(1, 1) : ivec2(1, 0));
    }
}

}  // namespace
}  // namespace spinel::texture_test
