#include "json_test.h"

namespace spinel::json_objects_test {
namespace {

using test::message;
using test::scene_of;

// A scene of one object with these keys and a material "m".
std::string object(const std::string& keys) {
    return "{\"version\": 1, \"materials\": {\"m\": {\"type\": \"diffuse\"}, \"n\": {\"type\": "
           "\"diffuse\"}},\n"
           "\"media\": {\"fog\": {\"scattering\": 1}}, \"objects\": [\n{" +
           keys + "}]}";
}

std::string transformed(const std::string& transform) {
    return object("\"geometry\": {\"type\": \"sphere\"}, \"material\": \"m\",\n\"transform\": " + transform);
}

mat4x3 transform_of(const std::string& transform) { return scene_of(transformed(transform)).objects.at(0).transform; }

void expect_near(const vec3& a, const vec3& b) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-6f) << "component " << i;
}

TEST(JsonTransform, steps_are_applied_in_order) {
    const std::string scale = "{\"scale\": [2, 3, 4]}", move = "{\"translate\": [1, 0, 0]}";
    const std::string turn = "{\"rotate\": {\"axis\": [0, 2, 0], \"degrees\": 90}}";
    // (1, 1, 1) is scaled to (2, 3, 4), turned about +y to (4, 3, −2), moved to (5, 3, −2).
    expect_near(transform_of("[" + scale + ", " + turn + ", " + move + "]") * vec4(1, 1, 1, 1), {5, 3, -2});
    // Moved to (2, 1, 1), turned to (1, 1, −2), scaled to (2, 3, −8).
    expect_near(transform_of("[" + move + ", " + turn + ", " + scale + "]") * vec4(1, 1, 1, 1), {2, 3, -8});
    // Right angles are exact.
    EXPECT_EQ(transform_of("[{\"rotate\": {\"axis\": [0, 1, 0], \"degrees\": 180}}]")[0].x, -1);
    EXPECT_EQ(transform_of("[{\"scale\": 2}]"), mat4x3(2, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0));
    EXPECT_EQ(transform_of("[]"), mat4x3(1));
}

TEST(JsonTransform, matrices_are_written_row_by_row) {
    const mat4x3 expected(1, 0, 0, 2, 1, 0, 0, 0, 1, 3, 4, 5);  // columns
    EXPECT_EQ(transform_of("[1, 2, 0, 3, 0, 1, 0, 4, 0, 0, 1, 5]"), expected);
    EXPECT_EQ(transform_of("[1, 2, 0, 3, 0, 1, 0, 4, 0, 0, 1, 5, 0, 0, 0, 1]"), expected);
}

TEST(JsonTransform, what_is_wrong_is_pointed_at) {
    EXPECT_EQ(message(transformed("[{\"scale\": [1, 0, 1]}]")),
              "a.json:4:14: objects[0] has a singular transform: it flattens space");
    EXPECT_EQ(message(transformed("[1, 2, 3, 4, 2, 4, 6, 8, 0, 0, 1, 0]")),
              "a.json:4:14: objects[0] has a singular transform: it flattens space");
    EXPECT_EQ(message(transformed("[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1]")),
              "a.json:4:14: \"transform\" of objects[0]: the last row of a 4×4 matrix must be 0, 0, 0, 1");
    EXPECT_EQ(message(transformed("[1, 2, 3]")),
              "a.json:4:14: \"transform\" of objects[0] must be a list of steps or a matrix of 12 or 16 "
              "numbers, not an "
              "array of 3");
    EXPECT_EQ(message(transformed("[{\"spin\": 3}]")),
              "a.json:4:16: unknown step \"spin\" in \"transform\" of objects[0]; allowed: scale, rotate, "
              "translate");
    EXPECT_EQ(message(transformed("[{\"scale\": 2, \"translate\": [0, 0, 0]}]")),
              "a.json:4:15: \"transform\" of objects[0] must be a list of objects with one key each: scale, "
              "rotate or "
              "translate, not an object");
    EXPECT_EQ(message(transformed("[{\"rotate\": {\"axis\": [0, 0, 0], \"degrees\": 3}}]")),
              "a.json:4:26: \"rotate\" of \"transform\" of objects[0] has an axis of length 0");
    EXPECT_EQ(message(transformed("[{\"rotate\": {\"axis\": [0, 1, 0], \"radians\": 3}}]")),
              "a.json:4:46: unknown key \"radians\" in \"rotate\" of \"transform\" of objects[0]; allowed: "
              "axis, degrees");
}

TEST(JsonObjects, materials_are_a_name_null_or_one_a_slot) {
    const std::string voxels = "\"geometry\": {\"type\": \"voxels\", \"layers\": [[\"12\"]]}";
    EXPECT_EQ(scene_of(object(voxels + ", \"material\": \"n\"")).objects.at(0).materials, std::vector<int>{1});
    EXPECT_EQ(scene_of(object(voxels + ", \"material\": null")).objects.at(0).materials, std::vector<int>{-1});
    EXPECT_EQ(scene_of(object(voxels + ", \"material\": [\"n\", null]")).objects.at(0).materials,
              (std::vector<int>{1, -1}));
    EXPECT_EQ(message(object(voxels)),
              "a.json:3:1: objects[0] needs \"material\": a name, null (an interface that does not scatter), "
              "or a list of "
              "these, one for each slot");
    EXPECT_EQ(message(object(voxels + ",\n\"material\": \"x\"")),
              "a.json:4:13: \"material\" of objects[0]: no material is named \"x\"; defined: m, n");
    EXPECT_EQ(
        message(object("\"geometry\": {\"type\": \"voxels\", \"layers\": [[\"123\"]]},\n\"material\": [\"m\", \"n\"]")),
        "a.json:4:13: \"material\" of objects[0] lists 2 materials, but its geometry uses 3 slots");
}

TEST(JsonObjects, interiors_need_an_inside) {
    const std::string keys = "\"material\": null,\n\"interior\": \"fog\", \"geometry\": ";
    EXPECT_EQ(scene_of(object(keys + "{\"type\": \"box\"}")).objects.at(0).interior, 0);
    EXPECT_EQ(message(object(keys + "{\"type\": \"plane\"}")),
              "a.json:4:13: objects[0] is a plane, which has no inside for an interior medium");
    EXPECT_EQ(message(object(keys + "{\"type\": \"rectangle\"}")),
              "a.json:4:13: objects[0] is a rectangle, which has no inside for an interior medium");
    EXPECT_EQ(message(object("\"geometry\": {\"type\": \"volume\", \"size\": [1, 1, 1], \"values\": [1]}")),
              "a.json:3:1: objects[0] is a volume and needs \"interior\", the medium that it holds");
}

const char* const two =
    R"({"version": 1, "materials": {"m": {"type": "diffuse"}}, "textures": {"t": {"type": "checker"}},
    "geometries": {"pair": {"type": "mesh", "file": "two.obj"}},
    "objects": [
        {"geometry": {"type": "sphere"}, "material": "m"},
        {"name": "own", "geometry": "pair", "transform": [{"scale": 10}]},
        {"name": "painted", "geometry": "pair", "material": "m"}]})";

TEST(JsonObjects, a_file_of_several_objects_expands_in_front_of_the_transform) {
    const Scene scene = scene_of(two);
    ASSERT_EQ(scene.objects.size(), 5u);
    EXPECT_EQ(scene.geometries.size(), 3u) << "the file is read once, however often it stands in the scene";
    const Object& first = scene.objects[1];
    const Object& second = scene.objects[2];
    EXPECT_EQ(first.name, "own/part0");
    EXPECT_EQ(second.name, "own/part1");
    EXPECT_EQ(first.transform, mat4x3(10, 0, 0, 0, 10, 0, 0, 0, 10, 10, 0, 0)) << "placed by the file, then scaled";
    EXPECT_EQ(second.transform[3], vec3(20, 0, 0));
    EXPECT_EQ(scene.geometries[std::size_t(first.geometry)].name, "mesh0");
    EXPECT_EQ(scene.geometries[std::size_t(second.geometry)].name, "mesh1");
    // The file's materials follow the scene's own, their textures the scene's textures.
    ASSERT_EQ(scene.materials.size(), 3u);
    EXPECT_EQ(first.materials, std::vector<int>{1});
    EXPECT_EQ(second.materials, std::vector<int>{2});
    EXPECT_EQ(scene.materials[1].name, "paint0");
    EXPECT_EQ(scene.materials[1].values.color_texture, kernels::NONE);
    EXPECT_EQ(scene.materials[2].values.color_texture, 1u);
    EXPECT_EQ(scene.textures.at(1).name, "white");
    // A material of the object replaces all of the file's.
    EXPECT_EQ(scene.objects[3].materials, std::vector<int>{0});
    EXPECT_EQ(scene.objects[4].materials, std::vector<int>{0});
}

TEST(JsonObjects, a_volume_file_gives_its_grid_to_media) {
    const Scene scene = scene_of(R"({"version": 1,
        "geometries": {"own": {"type": "volume", "size": [1, 1, 1], "values": [3]},
                       "cloud": {"type": "volume", "file": "cloud.vol", "filter": "nearest"}},
        "media": {"thick": {"scattering": 5, "density": "cloud"}},
        "objects": [{"geometry": "cloud"}, {"geometry": "cloud", "interior": "thick"}]})");
    ASSERT_EQ(scene.grids.size(), 2u);
    EXPECT_EQ(scene.grids[1].name, "cloud");
    EXPECT_EQ(scene.grids[1].filter, Filter::nearest);
    ASSERT_EQ(scene.media.size(), 2u);
    EXPECT_EQ(scene.media[0].grid, 1);
    EXPECT_EQ(scene.media[1].grid, 1) << "the file's own medium follows the scene's";
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_EQ(scene.objects[0].interior, 1) << "the file's own medium";
    EXPECT_EQ(scene.objects[1].interior, 0);
}

TEST(JsonObjects, files_that_do_not_serve) {
    const auto geometry = [](const std::string& text) {
        return message("{\"version\": 1, \"geometries\": {\n\"g\": " + text + "}}");
    };
    EXPECT_EQ(geometry("{\"type\": \"mesh\", \"file\": \"three.obj\"}"), "a.json:2:31: scenes/three.obj: no such file");
    EXPECT_EQ(geometry("{\"type\": \"mesh\", \"file\": \"empty.obj\"}"),
              "a.json:2:31: scenes/empty.obj holds no objects");
    EXPECT_EQ(geometry("{\"type\": \"mesh\", \"file\": \"\"}"), "a.json:2:31: \"file\" of geometry \"g\" is empty");
    EXPECT_EQ(geometry("{\"type\": \"voxels\", \"file\": \"two.obj\"}"),
              "a.json:2:33: geometry \"g\" is of type \"voxels\", but scenes/two.obj holds a geometry of "
              "type \"mesh\"");
    EXPECT_EQ(geometry("{\"type\": \"mesh\", \"file\": \"two.obj\", \"positions\": []}"),
              "a.json:2:42: \"positions\" of geometry \"g\" excludes \"file\"");
}

}  // namespace
}  // namespace spinel::json_objects_test
