// Volumes that overlap, are cut by surfaces, or fill glass, beside other scenes that mean the same.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <functional>

#include "geometry/sphere_mesh.h"
#include "render/pictures.h"

namespace spinel::media_twins_test {
namespace {

using namespace test;

constexpr int edge = 8;
const char* const estimators[] = {"ratio", "residual", "delta"};

std::string grid(const char* name, const std::function<double(int)>& value) {
    std::string list;
    for (int i = 0; i < edge * edge * edge; ++i) list += (i ? "," : "") + fmt::format("{}", value(i));
    return fmt::format(R"("{0}": {{"type": "volume", "size": [{1}, {1}, {1}], "values": [{2}],
        "transform": [{{"translate": [-4, -4, -4]}}, {{"scale": 0.25}}]}})",
                       name, edge, list);
}

// Of no use within glass, where it would be found by chance alone.
const std::string lamps =
    R"("lights": [{"type": "directional", "direction": [-1, -2, -0.5], "irradiance": 2, "angular_radius": 4},
                  {"type": "point", "position": [1.3, 1.2, 0.6], "intensity": 2}], )";

std::string scene(const std::string& settings, const std::string& contents, const std::string& objects) {
    return fmt::format(
        R"({{"version": 1, "film": {{"size": [32, 32], "filter": "box", "filter_radius": 0.5}}, "integrator": {{{}}},
        "camera": {{"from": [1, 1.4, 3.6], "at": [0, 0, 0], "fov": 42}},
        "environment": {{"type": "constant", "radiance": [0.3, 0.4, 0.5]}},
        {}, "objects": [{}]}})",
        settings, contents, objects);
}

TEST(MediaTwins, two_grids_that_fill_each_other_up_equal_the_even_box) {
    const auto half = [](int i) { return double((i * 7919) % 11 < 4 ? 0 : ((i * 104729) % 97) / 60.0); };
    const std::string coefficients = R"("scattering": [1, 0.6, 0.3], "absorption": [0.05, 0.15, 0.1], "g": 0.4)";
    const TestPicture even = render_text(
        scene("", lamps + R"("media": {"m": {"scattering": [2, 1.2, 0.6], "absorption": [0.1, 0.3, 0.2], "g": 0.4}})",
              R"({"geometry": {"type": "box", "size": [2, 2, 2]}, "material": null, "interior": "m"})"),
        24);
    for (const char* estimator : estimators)
        expect_same(even,
                    render_text(scene(fmt::format(R"("transmittance": "{}")", estimator),
                                      lamps + "\"geometries\": {" + grid("a", half) + ", " +
                                          grid("b", [&](int i) { return 2 - half(i); }) +
                                          "}, \"media\": {\"a\": {\"density\": \"a\", " + coefficients +
                                          "}, \"b\": {\"density\": \"b\", " + coefficients + "}}",
                                      R"({"geometry": "a", "interior": "a"}, {"geometry": "b", "interior": "b"})"),
                                24));
}

// A ball cut out of a grid by a mesh, with a solid in it that hides a part: as of the even medium in the sphere.
TEST(MediaTwins, a_cloud_is_cut_by_meshes_as_the_even_medium_is) {
    const std::string stone = R"("materials": {"stone": {"type": "diffuse", "color": [0.7, 0.6, 0.5]}}, )";
    const std::string rest =
        R"(, {"geometry": {"type": "box", "size": [0.6, 0.8, 0.6]}, "material": "stone", "transform": [{"translate": [0.3, 0, 0]}]})";
    const TestPicture even = render_text(
        scene(
            "",
            lamps + stone + R"("media": {"m": {"scattering": [2, 1.2, 0.6], "absorption": [0.1, 0.3, 0.2], "g": 0.4}})",
            R"({"geometry": {"type": "sphere", "radius": 0.95}, "material": null, "interior": "m"})" + rest),
        24);
    const std::string contents =
        lamps + stone + "\"geometries\": {" + grid("g", [](int) { return 2.0; }) +
        R"(, "ball": {"type": "mesh", "positions": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0,1,2]]}},
        "media": {"m": {"density": "g", "scattering": [1, 0.6, 0.3], "absorption": [0.05, 0.15, 0.1], "g": 0.4}})";
    Result<Scene> text =
        read_scene_json(scene("", contents, R"({"geometry": "ball", "material": null, "interior": "m"})" + rest),
                        "test.json", {load_model, read_pixels});
    ASSERT_TRUE(text) << text.error().message;
    for (Geometry& g : text->geometries)
        if (auto* mesh = std::get_if<MeshGeometry>(&g.data)) {
            *mesh = sphere_mesh(160);
            for (vec3& p : mesh->positions) p *= 0.95f;
        }
    const Result<CompiledScene> compiled = compile(*text);
    ASSERT_TRUE(compiled) << compiled.error().message;
    expect_same(even, render_scene(*compiled, 24));
}

TEST(MediaTwins, glass_filled_with_smoke_is_one_however_the_smoke_is_put_there) {
    const std::string smoke = R"("scattering": [2, 1.2, 0.6], "absorption": [0.1, 0.3, 0.2], "g": 0.4)";
    const std::string half =
        R"("density": "g", "scattering": [1, 0.6, 0.3], "absorption": [0.05, 0.15, 0.1], "g": 0.4)";
    const std::string ball = R"({"geometry": {"type": "sphere", "radius": 0.9}, "material": "glass")";
    const auto glass = [](const char* rest) {
        return fmt::format(R"("materials": {{"glass": {{"type": "dielectric", "ior": 1.4{}}}}}, )", rest);
    };
    const int spp = 96;
    const TestPicture own =
        render_text(scene("", glass(R"(, "interior": "m")") + "\"media\": {\"m\": {" + smoke + "}}", ball + "}"), spp);
    // Named by the object; as a grid; as a second object in the same place.
    expect_same(
        own,
        render_text(scene("", glass("") + "\"media\": {\"m\": {" + smoke + "}}", ball + R"(, "interior": "m"})"), spp));
    expect_same(own, render_text(scene("",
                                       glass(R"(, "interior": "m")") + "\"geometries\": {" +
                                           grid("g", [](int) { return 2.0; }) + "}, \"media\": {\"m\": {" + half + "}}",
                                       ball + "}"),
                                 spp));
    expect_same(
        own,
        render_text(
            scene("", glass("") + "\"media\": {\"m\": {" + smoke + "}}",
                  ball + R"(}, {"geometry": {"type": "sphere", "radius": 0.9}, "material": null, "interior": "m"})"),
            spp));
}

}  // namespace
}  // namespace spinel::media_twins_test
