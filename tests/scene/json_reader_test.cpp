#include "scene/json_reader.h"

#include "json_test.h"

namespace spinel::json_reader_test {
namespace {

using test::message;
using test::read;
using test::scene_of;

TEST(JsonReader, a_simple_scene) {
    const Scene scene = scene_of(R"({
        "version": 1,
        "camera": {"type": "perspective", "from": [0, 1, 5], "at": [0, 0.5, 0], "fov": 40, "lens_radius": 0.1},
        "film": {"size": [320, 200], "exposure": -1, "tone_map": "aces", "filter": "box", "filter_radius": 0.5},
        "integrator": {"type": "path", "spp": 16, "max_bounces": 8},
        "environment": {"type": "constant", "radiance": [1, 2, 3]},
        "materials": {"red": {"type": "diffuse", "color": [0.5, 0.1, 0.1]}},
        "objects": [{"name": "ball", "geometry": {"type": "sphere", "radius": 2}, "material": "red"}],
        "expected": {"mean": 0.5, "tolerance": 0.01}
    })");
    ASSERT_EQ(scene.cameras.size(), 1u);
    EXPECT_EQ(scene.cameras[0].from, vec3(0, 1, 5));
    EXPECT_EQ(scene.cameras[0].at, vec3(0, 0.5f, 0));
    EXPECT_EQ(scene.cameras[0].up, vec3(0, 1, 0));
    EXPECT_EQ(scene.cameras[0].fov, 40);
    EXPECT_EQ(scene.cameras[0].lens_radius, 0.1f);
    EXPECT_EQ(scene.film.size, ivec2(320, 200));
    EXPECT_EQ(scene.film.exposure, -1);
    EXPECT_EQ(scene.film.tone_map, ToneMap::aces);
    EXPECT_EQ(scene.film.filter, PixelFilter::box);
    EXPECT_EQ(scene.film.filter_radius, 0.5f);
    EXPECT_EQ(scene.integrator.spp, 16);
    EXPECT_EQ(scene.integrator.max_bounces, 8);
    EXPECT_EQ(std::get<ConstantEnvironment>(scene.environment).radiance, vec3(1, 2, 3));
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(scene.objects[0].name, "ball");
    EXPECT_EQ(scene.objects[0].materials, std::vector<int>{0});
    EXPECT_EQ(std::get<SphereGeometry>(scene.geometries.at(0).data).radius, 2);
    EXPECT_EQ(scene.materials.at(0).values.color, vec3(0.5f, 0.1f, 0.1f));
    ASSERT_TRUE(scene.expected);
    EXPECT_EQ(scene.expected->mean, vec3(0.5f));
}

TEST(JsonReader, cameras_have_names_and_the_first_is_the_default) {
    const Scene scene = scene_of(R"({"version": 1, "cameras": {
        "zenith": {"from": [0, 9, 0], "up": [0, 0, 1]},
        "front": {"type": "orthographic", "height": 3}}})");
    ASSERT_EQ(scene.cameras.size(), 2u);
    EXPECT_EQ(scene.cameras[0].name, "zenith");
    EXPECT_EQ(scene.cameras[0].kind, Camera::Kind::perspective);
    EXPECT_EQ(scene.cameras[1].name, "front");
    EXPECT_EQ(scene.cameras[1].kind, Camera::Kind::orthographic);
    EXPECT_EQ(scene.cameras[1].height, 3);
}

TEST(JsonReader, environments_lights_textures_and_media) {
    const Scene scene = scene_of(R"({"version": 1,
        "environment": {"type": "image", "file": "picture.exr", "scale": 2, "rotation": 90},
        "textures": {
            "wood": {"type": "image", "file": "picture.png", "wrap": "mirror", "filter": "nearest"},
            "heights": {"type": "image", "file": "picture.exr"},
            "floor": {"type": "checker", "color_a": 0.5, "scale": [8, 4]}},
        "geometries": {"box": {"type": "volume", "size": [1, 1, 2], "values": [0.25, 4], "filter": "nearest"}},
        "media": {
            "haze": {"scattering": 0.1, "absorption": [1, 2, 3], "g": -0.5},
            "fog": {"scattering": [1, 2, 3], "density": "box", "erosion": {"type": "fbm", "octaves": 5}}},
        "objects": [{"geometry": "box", "interior": "fog"}],
        "lights": [
            {"type": "point", "name": "bulb", "position": [1, 2, 3], "intensity": 5},
            {"type": "spot", "direction": [0, 0, -1], "inner_angle": 5, "outer_angle": 6},
            {"type": "directional", "irradiance": [1, 2, 3], "angular_radius": 0.265}]
    })");
    const auto& environment = std::get<ImageEnvironment>(scene.environment);
    EXPECT_EQ(environment.file, "picture.exr");
    ASSERT_TRUE(environment.pixels);
    EXPECT_EQ(environment.scale, vec3(2));
    EXPECT_EQ(environment.rotation, 90);
    ASSERT_EQ(scene.textures.size(), 3u);
    const auto& wood = std::get<ImageTexture>(scene.textures[0].data);
    EXPECT_EQ(wood.wrap, Wrap::mirror);
    EXPECT_EQ(wood.filter, Filter::nearest);
    EXPECT_TRUE(wood.srgb);
    EXPECT_FALSE(std::get<ImageTexture>(scene.textures[1].data).srgb) << "floating-point pictures are linear";
    EXPECT_EQ(std::get<CheckerTexture>(scene.textures[2].data).color_a, vec3(0.5f));
    ASSERT_EQ(scene.media.size(), 2u);
    EXPECT_EQ(scene.media[0].scattering, vec3(0.1f));
    EXPECT_EQ(scene.media[0].absorption, vec3(1, 2, 3));
    EXPECT_EQ(scene.media[0].g, -0.5f);
    EXPECT_EQ(scene.media[0].grid, -1);
    EXPECT_EQ(scene.media[1].grid, 0);
    EXPECT_EQ(scene.media[1].erosion.kind, Erosion::Kind::fbm);
    EXPECT_EQ(scene.media[1].erosion.octaves, 5);
    ASSERT_EQ(scene.grids.size(), 1u);
    EXPECT_EQ(scene.grids[0].samples->dense(), (std::vector<float>{0.25f, 4}));
    EXPECT_EQ(scene.grids[0].filter, Filter::nearest);
    EXPECT_EQ(scene.objects.at(0).interior, 1);
    ASSERT_EQ(scene.lights.size(), 3u);
    EXPECT_EQ(scene.lights[0].name, "bulb");
    EXPECT_EQ(std::get<PointLight>(scene.lights[0].data).intensity, vec3(5));
    EXPECT_EQ(std::get<SpotLight>(scene.lights[1].data).outer_angle, 6);
    EXPECT_EQ(std::get<DirectionalLight>(scene.lights[2].data).angular_radius, 0.265f);
}

TEST(JsonReader, materials_take_textures_media_and_emission) {
    const Scene scene = scene_of(R"({"version": 1,
        "textures": {"a": {"type": "checker"}, "b": {"type": "checker"}},
        "media": {"milk": {"scattering": 1}, "smoke": {"scattering": 2}},
        "materials": {
            "ground": {"type": "diffuse", "color": "b"},
            "lamp": {"type": "diffuse", "color": 0, "emission": [10, 9, 8]},
            "glass": {"type": "dielectric", "ior": 1.25, "absorption": [1, 2, 3], "priority": 7, "interior": "smoke"}}})");
    ASSERT_EQ(scene.materials.size(), 3u);
    EXPECT_EQ(scene.materials[0].name, "ground");
    EXPECT_EQ(scene.materials[0].values.color_texture, 1u);
    EXPECT_EQ(scene.materials[0].values.color, vec3(1)) << "a texture alone is not dimmed by the default colour";
    EXPECT_EQ(scene.materials[1].values.color, vec3(0));
    EXPECT_EQ(scene.materials[1].values.emission, vec3(10, 9, 8));
    EXPECT_EQ(scene.materials[2].values.ior, 1.25f);
    EXPECT_EQ(scene.materials[2].values.absorption, vec3(1, 2, 3));
    EXPECT_EQ(scene.materials[2].values.priority, 7);
    EXPECT_EQ(scene.materials[2].values.interior, 1u);
}

// One for each class of error: the sentence and where it points.
TEST(JsonReader, errors_say_where_what_and_what_is_allowed) {
    EXPECT_EQ(message("[]"), "a.json:1:1: the scene must be an object, not an empty array");
    EXPECT_EQ(message("{}"), "a.json:1:1: the scene needs \"version\"");
    EXPECT_EQ(message("{\"version\": 2}"),
              "a.json:1:13: \"version\" must be 1, the only version of scene files there is");
    EXPECT_EQ(message("{\"version\": 1,\n  \"colour\": 3}"),
              "a.json:2:3: unknown key \"colour\" in the scene; allowed: version, camera, cameras, film, "
              "integrator, accelerator, "
              "environment, textures, materials, media, geometries, objects, lights, animation, expected");
    EXPECT_EQ(message("{\"version\": 1,\n \"film\": {\"exposure\": \"x\"}}"),
              "a.json:2:23: \"exposure\" of film must be a number, not the text \"x\"");
    EXPECT_EQ(message("{\"version\": 1, \"film\": {\"size\": [0, 2]}}"),
              "a.json:1:34: \"size\" of film is 0; allowed: 1 … 65536");
    EXPECT_EQ(message("{\"version\": 1, \"film\": {\"size\": [1.5, 2]}}"),
              "a.json:1:33: \"size\" of film must be whole numbers");
    EXPECT_EQ(message("{\"version\": 1, \"film\": {\"size\": [1, 2, 3]}}"),
              "a.json:1:33: \"size\" of film must be an array of 2 numbers, not an array of 3");
    EXPECT_EQ(message("{\"version\": 1, \"film\": {\"exposure\": 1e39}}"),
              "a.json:1:37: \"exposure\" of film is 1e+39, more than a 32-bit float holds");
    EXPECT_EQ(message("{\"version\": 1, \"film\": {\"tone_map\": \"film\"}}"),
              "a.json:1:37: \"tone_map\" of film must be one of linear, aces, agx, not the text \"film\"");
    EXPECT_EQ(message("{\"version\": 1, \"integrator\": {\"spp\": 1.5}}"),
              "a.json:1:38: \"spp\" of integrator is 1.5; it must be a whole number of 32 bits");
    EXPECT_EQ(message("{\"version\": 1, \"camera\": {\"mirrored\": 1}}"),
              "a.json:1:39: \"mirrored\" of camera must be true or false, not a number");
    EXPECT_EQ(message("{\"version\": 1, \"camera\": {\"fov\": 180}}"),
              "a.json:1:34: \"fov\" of camera is 180; allowed: between 0 and 180, without these");
    EXPECT_EQ(message("{\"version\": 1, \"camera\": {\"type\": \"fisheye\"}}"),
              "a.json:1:35: unknown camera type \"fisheye\" in camera; available: perspective, orthographic");
    EXPECT_EQ(message("{\"version\": 1, \"camera\": {\"from\": [0, 0, 0]}}"),
              "a.json:1:26: camera looks at the point where it stands: \"from\" and \"at\" must differ");
    EXPECT_EQ(message("{\"version\": 1, \"camera\": {\"up\": [0, 0, 2]}}"),
              "a.json:1:26: camera has \"up\" along its view");
    EXPECT_EQ(message("{\"version\": 1, \"camera\": {}, \"cameras\": {}}"),
              "a.json:1:41: \"camera\" and \"cameras\" exclude each other");
    EXPECT_EQ(message("{\"version\": 1, \"environment\": {}}"),
              "a.json:1:31: environment needs \"type\"; available: constant, image, sky");
    EXPECT_EQ(message("{\"version\": 1, \"environment\": {\"type\": \"image\"}}"),
              "a.json:1:31: environment needs \"file\"");
    EXPECT_EQ(message("{\"version\": 1, \"environment\": {\"type\": \"image\", \"file\": \"x.exr\"}}"),
              "a.json:1:57: scenes/x.exr: no such file");
    EXPECT_EQ(message("{\"version\": 1, \"media\": {\"fog\": {\"g\": 1}}}"),
              "a.json:1:39: \"g\" of medium \"fog\" is 1; allowed: between -1 and 1, without these");
    EXPECT_EQ(message("{\"version\": 1, \"media\": {\"fog\": {\"absorption\": -1}}}"),
              "a.json:1:48: \"absorption\" of medium \"fog\" is -1; allowed: ≥ 0");
    EXPECT_EQ(message("{\"version\": 1, \"media\": {\"fog\": {\"absorption\": [1, 2]}}}"),
              "a.json:1:48: \"absorption\" of medium \"fog\" must be a number or an array of 3 numbers, not "
              "an array of 2");
    EXPECT_EQ(message("{\"version\": 1, \"media\": {\"fog\": {\"erosion\": {\"type\": \"fbm\"}}}}"),
              "a.json:1:33: medium \"fog\" has erosion but no density that it could eat");
    EXPECT_EQ(message("{\"version\": 1, \"lights\": {}}"), "a.json:1:26: \"lights\" must be an array, not an object");
    EXPECT_EQ(message("{\"version\": 1, \"lights\": [{\"type\": \"spot\", \"inner_angle\": 40}]}"),
              "a.json:1:27: lights[0] must have 0 ≤ inner_angle ≤ outer_angle ≤ 90 degrees, and outer_angle "
              "above 0");
    EXPECT_EQ(message("{\"version\": 1, \"media\": []}"),
              "a.json:1:25: \"media\" must be an object of names, not an empty array");
    EXPECT_EQ(message("{\"version\": 1, \"media\": {\"a\": {}, \"a\": {}}}"),
              "a.json:1:35: key \"a\" stands twice in this object");
    EXPECT_EQ(message("{\"version\": 1, \"media\": {\"\": {}}}"), "a.json:1:26: a medium needs a name");
}

TEST(JsonReader, materials_that_are_wrong) {
    const auto materials = [](const std::string& text) {
        return message("{\"version\": 1, \"materials\": {\n\"gold\": " + text + "}}");
    };
    EXPECT_EQ(materials("{\"type\": \"gals\"}").substr(0, 78),
              "a.json:2:18: unknown material type \"gals\" in material \"gold\"; available: diffu");
    const std::string unknown = materials("{\"type\": \"metal\", \"roughnes\": 1}");
    EXPECT_EQ(unknown.substr(0, 79),
              "a.json:2:27: unknown key \"roughnes\" in material \"gold\" of type \"metal\"; allowed");
    EXPECT_NE(unknown.find("roughness"), std::string::npos);
    EXPECT_EQ(materials("{\"type\": \"diffuse\", \"color\": \"wood\"}"),
              "a.json:2:38: \"color\" of material \"gold\": no texture is named \"wood\"; the scene defines none");
    EXPECT_EQ(materials("{\"type\": \"dielectric\", \"interior\": \"fog\"}"),
              "a.json:2:44: \"interior\" of material \"gold\": no medium is named \"fog\"; the scene defines none");
    EXPECT_EQ(materials("{\"type\": \"metal\", \"roughness\": 1.5}").substr(0, 50),
              "a.json:2:40: \"roughness\" of material \"gold\" is 1.5");
}

TEST(JsonReader, references_list_what_exists) {
    EXPECT_EQ(message("{\"version\": 1, \"geometries\": {\"a\": {\"type\": \"plane\"}, \"b\": {\"type\": "
                      "\"sphere\"}},\n"
                      "\"objects\": [{\"geometry\": \"c\"}]}"),
              "a.json:2:26: \"geometry\" of objects[0]: no geometry is named \"c\"; defined: a, b");
    EXPECT_EQ(message("{\"version\": 1, \"media\": {\"fog\": {}},\n"
                      "\"objects\": [{\"geometry\": {\"type\": \"sphere\"}, \"material\": null, "
                      "\"interior\": \"mist\"}]}"),
              "a.json:2:76: \"interior\" of objects[0]: no medium is named \"mist\"; defined: fog");
    EXPECT_EQ(message("{\"version\": 1, \"geometries\": {\"a\": {\"type\": \"plane\"}},\n"
                      "\"media\": {\"fog\": {\"density\": \"a\"}}}"),
              "a.json:2:30: \"density\" of medium \"fog\": geometry \"a\" is not a volume");
}

}  // namespace
}  // namespace spinel::json_reader_test
