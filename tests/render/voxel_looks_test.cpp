// Textures by face, outlines, and what of looks is refused.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "geometry/test_scene.h"
#include "kernels/surface.h"
#include "kernels/traverse.h"
#include "render/pictures.h"
#include "scene/json_writer.h"

namespace spinel::voxel_looks_test {
namespace {

using namespace test;
using kernels::Hit;

// 4×4 pixels in 2×2 tiles. Every tile is darker at its lower left pixel, and has a colour of its own; the last has
// holes.
Result<PixelBuffer> tiles(const std::filesystem::path&) {
    PixelBuffer p{4, 4, 4, std::vector<std::uint8_t>(64, 255)};
    auto& bytes = std::get<std::vector<std::uint8_t>>(p.data);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            const int tile = x / 2 + 2 * (y / 2);
            const bool lower_left = x % 2 == 0 && y % 2 == 1;
            std::uint8_t* c = &bytes[std::size_t(4 * (x + 4 * y))];
            for (int k = 0; k < 3; ++k) c[k] = std::uint8_t(k == tile % 3 ? (lower_left ? 100 : 200) : 50 * (tile / 3));
            c[3] = tile == 3 && lower_left ? 0 : 255;
        }
    return p;
}

Result<CompiledScene> compile_looks(const std::string& geometry, const std::string& faces, const std::string& material,
                                    const std::string& slots = "\"m\"") {
    const Result<Scene> scene =
        read_scene_json(R"({"version": 1, "camera": {}, "textures": {"t": {"type": "faces", "file": "tiles.png", )" +
                            faces + R"(}}, "materials": {"m": )" + material +
                            R"(, "g": {"type": "dielectric"}}, "objects": [{"name": "thing", "geometry": )" + geometry +
                            R"(, "material": )" + slots + "}]}",
                        "test.json", {load_model, tiles});
    if (!scene) return scene.error();
    // What is written is read again as the same.
    const Result<std::string> text = write_scene_json(*scene);
    if (!text) return text.error();
    const Result<Scene> again = read_scene_json(*text, "again.json", {load_model, tiles});
    if (!again) return again.error();
    EXPECT_EQ(*text, *write_scene_json(*again));
    return compile(*again);
}

constexpr char CUBE[] = R"({"type": "voxels", "size": [1, 1, 1], "cells": [1]})";
constexpr char TEXTURED[] = R"({"type": "diffuse", "color": "t", "opacity": "t"})";
constexpr char GRID[] = R"("grid": [2, 2], "top": 0, "bottom": 1, "sides": 2, "south": 3)";

// The colour seen by a ray along −n that meets the face with normal n at a place right and up of its centre.
vec3 color_seen(const kernels::SceneView& scene, vec3 centre, vec3 n, vec3 offset, float* opacity = nullptr) {
    const kernels::Ray r = ray(centre + 0.5f * n + offset + 3.0f * n, -n);
    const Hit hit = kernels::trace_closest(scene, r, kernels::TRACE_ALL);
    EXPECT_TRUE(kernels::is_hit(hit));
    const kernels::Surface s = kernels::surface_at(scene, r, hit);
    if (opacity) *opacity = kernels::surface_opacity(scene, s);
    return kernels::surface_bsdf(scene, s, 1).color;
}

TEST(FaceTextures, every_face_shows_its_tile_upright) {
    for (const bool box : {false, true}) {
        const auto compiled = compile_looks(box ? R"({"type": "box"})" : CUBE, GRID, TEXTURED);
        ASSERT_TRUE(compiled) << compiled.error().message;
        const kernels::SceneView scene = compiled->view();
        const vec3 centre = box ? vec3(0) : vec3(0.5f);
        const auto linear = [](int byte) { return kernels::srgb_to_linear(float(byte) / 255); };
        struct Face {
            vec3 normal, right, up;
            int tile;
        };
        for (const Face& face : {Face{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}, 0}, Face{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}, 1},
                                 Face{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, 2}, Face{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}, 2},
                                 Face{{0, 0, -1}, {-1, 0, 0}, {0, 1, 0}, 2}, Face{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 3}})
            for (const float right : {-0.45f, -0.05f, 0.05f, 0.45f})
                for (const float up : {-0.45f, -0.05f, 0.05f, 0.45f}) {
                    float opacity = 0;
                    const vec3 c = color_seen(scene, centre, face.normal, right * face.right + up * face.up, &opacity);
                    const bool lower_left = right < 0 && up < 0;
                    for (int k = 0; k < 3; ++k)
                        EXPECT_FLOAT_EQ(c[k],
                                        linear(k == face.tile % 3 ? (lower_left ? 100 : 200) : 50 * (face.tile / 3)))
                            << "tile " << face.tile << " at " << right << ", " << up;
                    EXPECT_EQ(opacity, face.tile == 3 && lower_left ? 0.0f : 1.0f);
                }
    }
}

TEST(FaceTextures, linear_filtering_never_looks_beyond_its_tile) {
    const auto compiled = compile_looks(CUBE, R"("all": [2, 0, 2, 2], "filter": "linear")", TEXTURED);
    ASSERT_TRUE(compiled) << compiled.error().message;
    Random random(1);
    for (int i = 0; i < 500; ++i) {
        const vec3 c = color_seen(compiled->view(), vec3(0.5f), {0, 1, 0},
                                  {random.uniform(-0.5f, 0.5f), 0, random.uniform(-0.5f, 0.5f)});
        EXPECT_EQ(c.x, 0.0f);  // tile 1 is green all over
        EXPECT_EQ(c.z, 0.0f);
    }
}

// A lamp whose tile shines in part: found by light sampling and by paths, to the same mean.
TEST(FaceTextures, textured_emitters_are_lights) {
    const auto picture = [](const std::string& geometry, const std::string& emission) {
        const auto compiled =
            compile_looks(geometry, GRID, R"({"type": "diffuse", "color": 0, "emission": )" + emission + "}");
        EXPECT_TRUE(compiled) << compiled.error().message;
        return *compiled;
    };
    const CompiledScene lamp = picture(CUBE, R"({"texture": "t", "factor": 5})");
    ASSERT_EQ(lamp.lights.size(), 6u);
    const kernels::SceneView scene = lamp.view();
    Random random(4);
    int lit = 0;
    for (int i = 0; i < 4000; ++i) {
        const vec3 from = vec3(0.5f) + 3.0f * random.direction();
        const kernels::LightSample light = kernels::sample_light(
            scene, from, random.uniform(0, 1), random.uniform(0, 1), {random.uniform(0, 1), random.uniform(0, 1)});
        if (!(light.pdf > 0)) continue;
        const kernels::Ray r = ray(from, light.direction);
        const Hit hit = kernels::trace_closest(scene, r, kernels::TRACE_ALL);
        ASSERT_TRUE(kernels::is_hit(hit));
        if (std::abs(hit.t - glm::length(light.point - from)) > 1e-4f) continue;  // behind another face
        const kernels::Surface s = kernels::surface_at(scene, r, hit);
        const vec2 off_texel = glm::fract(2.0f * hit.uv);
        if (std::min({off_texel.x, off_texel.y, 1 - off_texel.x, 1 - off_texel.y}) < 0.01f) continue;
        const vec3 emission = kernels::surface_emission(scene, s);
        for (int k = 0; k < 3; ++k) EXPECT_FLOAT_EQ(emission[k], light.radiance[k]);
        const kernels::uint index = kernels::light_of_primitive(scene, scene.instances.at[0], s.light_key);
        EXPECT_NEAR(kernels::light_pdf(scene, index, from, light.direction, hit.t) / light.pdf, 1, 1e-3f);
        ++lit;
    }
    EXPECT_GT(lit, 1000);
}

// Where a line is drawn on a plate of two colours with a step in it.
TEST(Outlines, are_drawn_where_they_are_asked_for) {
    const auto drawn = [](const std::string& where, vec3 place) {
        const auto compiled = compile_looks(
            R"({"type": "voxels", "layers": [["1122", "1122", "1111"], ["....", "...2", "...."]], "outlines": {"width": 0.2, "color": [0.5, 0, 0], "where": ")" +
                where + "\"}}",
            "\"all\": 0", R"({"type": "diffuse", "color": 0.25})", R"(["m", "m"])");
        EXPECT_TRUE(compiled) << compiled.error().message;
        const kernels::SceneView scene = compiled->view();
        const kernels::Ray r = ray(place + vec3(0, 5, 0), {0, -1, 0});
        const Hit hit = kernels::trace_closest(scene, r, kernels::TRACE_ALL);
        EXPECT_TRUE(kernels::is_hit(hit));
        const vec3 c = kernels::surface_bsdf(scene, kernels::surface_at(scene, r, hit), 1).color;
        EXPECT_TRUE(c == vec3(0.25f) || c == vec3(0.5f, 0, 0));
        return c.y == 0;
    };
    const vec3 inside(0.95f, 0, 0.5f), colors(1.95f, 0, 0.5f), step(2.95f, 0, 1.5f), rim(0.05f, 0, 0.5f),
        middle(0.5f, 0, 0.5f);
    const vec3 corner(1.95f, 0, 1.95f);  // a change of colour across the corner alone is an edge of the other two faces
    for (const std::string where : {"voxels", "changes", "shape"}) {
        EXPECT_EQ(drawn(where, inside), where == "voxels") << where;
        EXPECT_EQ(drawn(where, colors), where != "shape") << where;
        EXPECT_EQ(drawn(where, corner), where != "shape") << where;
        EXPECT_TRUE(drawn(where, step)) << where;
        EXPECT_TRUE(drawn(where, rim)) << where;
        EXPECT_FALSE(drawn(where, middle)) << where;
    }
}

TEST(Looks, what_cannot_be_is_refused_in_a_sentence) {
    const std::string plain = R"({"type": "diffuse"})";
    const auto says = [&](const std::string& geometry, const std::string& faces, const std::string& slots,
                          const std::string& expected) {
        const auto compiled = compile_looks(geometry, faces, TEXTURED, slots);
        ASSERT_FALSE(compiled) << expected;
        EXPECT_NE(compiled.error().message.find(expected), std::string::npos) << compiled.error().message;
    };
    const std::string all = "\"all\": 0";
    const auto cube = [](const std::string& looks) {
        return R"({"type": "voxels", "size": [1, 1, 1], "cells": [1], )" + looks + "}";
    };
    says(R"({"type": "sphere"})", all, "\"m\"", "is for voxels and boxes only");
    says(CUBE, "\"top\": 0", "\"m\"", "has no \"west\", \"sides\" or \"all\"");
    says(CUBE, R"("grid": [3, 2], "all": 0)", "\"m\"", "must divide the picture's 4×4 pixels");
    says(CUBE, R"("grid": [2, 2], "all": 4)", "\"m\"", "\"all\" of texture \"t\"");
    says(CUBE, R"("all": [2, 2, 3, 1])", "\"m\"", "sticks out of the atlas");
    says(cube(R"("rounding": 0.2)"), all, "\"g\"", "only what is opaque allows, but its palette index 1 is \"g\"");
    says(cube(R"("rounding": 0.2)"), all, "\"m\"", "only what is opaque allows");  // it has holes
    says(cube(R"("rounding": 0.6)"), all, "\"g\"", "\"rounding\"");
    says(cube(R"("waves": {"palette": [1]})"), all, "\"m\"", "only a dielectric may have");
    says(cube(R"("waves": {"height": 0.5})"), all, "\"g\"", "needs \"palette\"");
    says(cube(R"("waves": {"palette": [1], "height": 1.0})"), all, "\"g\"", "\"height\"");
    says(cube(R"("outlines": {"where": "there"})"), all, "\"g\"", "must be one of voxels, changes, shape");
}

}  // namespace
}  // namespace spinel::voxel_looks_test
