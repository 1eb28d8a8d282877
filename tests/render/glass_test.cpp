// Glass: the same solid made of different things is the same picture, and insides are what they say.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>

#include "geometry/sphere_mesh.h"
#include "render/pictures.h"

namespace spinel::glass_test {
namespace {

using namespace test;

// Checkered ground, a sky that changes from side to side, an area light: whatever bends light wrongly shows.
std::string stage(const std::string& things, const std::string& glass = "", const std::string& geometries = "") {
    return fmt::format(R"({{"version": 1, "film": {{"size": [32, 32], "filter": "box", "filter_radius": 0.5}},
        "camera": {{"from": [1, 1.4, 3.6], "at": [0, 0, 0], "fov": 42}},
        "textures": {{"tiles": {{"type": "checker", "color_a": [0.8, 0.7, 0.6], "color_b": [0.1, 0.1, 0.2], "scale": [1.5, 1.5]}}}},
        "media": {{"milk": {{"scattering": [2, 1.2, 0.6], "absorption": [0.1, 0.3, 0.2], "g": 0.4}}}},
        "materials": {{"floor": {{"type": "diffuse", "color": "tiles"}}, "lamp": {{"type": "diffuse", "color": 0, "emission": 6}},
                       "glass": {{"type": "dielectric", "ior": 1.5{}}}, "same": {{"type": "dielectric", "ior": 1.5{}}},
                       "water": {{"type": "dielectric", "ior": 1.33, "absorption": [0.8, 0.3, 0.1], "priority": -1}}}},
        "geometries": {{{}"ball": {{"type": "sphere", "radius": 1}}}},
        "objects": [{{"geometry": {{"type": "plane"}}, "material": "floor", "transform": [{{"translate": [0, -1.05, 0]}}]}},
                    {{"geometry": {{"type": "rectangle", "size": [2, 2]}}, "material": "lamp",
                      "transform": [{{"rotate": {{"axis": [1, 0, 0], "degrees": 180}}}}, {{"translate": [-1, 3, 0]}}]}}, {}]}})",
                       glass, glass, geometries, things);
}

TestPicture render_stage(const std::string& text, int mesh_steps = 0) {
    Result<Scene> scene = read_scene_json(text, "test.json", {load_model, read_pixels});
    EXPECT_TRUE(scene) << scene.error().message;
    if (!scene) return {};
    ImageEnvironment sky;
    sky.pixels = std::make_shared<PixelBuffer>(PixelBuffer{
        4, 2, 3, std::vector<float>{1,    0.5f, 0.2f, 0.6f, 0.6f, 0.6f, 0.2f, 0.5f, 1,    0.6f, 0.6f, 0.6f,
                                    0.2f, 0.2f, 0.2f, 0.2f, 0.2f, 0.2f, 0.2f, 0.2f, 0.2f, 0.2f, 0.2f, 0.2f}});
    scene->environment = sky;
    for (Geometry& g : scene->geometries)
        if (auto* mesh = std::get_if<MeshGeometry>(&g.data); mesh && mesh_steps > 0) *mesh = sphere_mesh(mesh_steps);
    const Result<CompiledScene> compiled = compile(*scene);
    EXPECT_TRUE(compiled) << compiled.error().message;
    return compiled ? render_scene(*compiled, 48) : TestPicture{};
}
// Caustics of the lamp through glass are found by chance alone: rare bright paths make the variance of blocks
// rough.
void expect_same_glass(const TestPicture& a, const TestPicture& b) {
    const Estimate ea = a.mean(), eb = b.mean();
    for (int k = 0; k < 3; ++k) {
        const double error = std::sqrt(ea.error[k] * ea.error[k] + eb.error[k] * eb.error[k]);
        EXPECT_NEAR(ea.mean[k], eb.mean[k], std::max(4 * error, 0.002 * eb.mean[k])) << "channel " << k;
        EXPECT_LT(error, more_noise * 0.01 * eb.mean[k]);
    }
    const Difference d = compare(a, b, 8);
    EXPECT_LT(d.chi_squared, 1.8);
    EXPECT_LT(d.worst, 7);
}

const std::string tint = R"(, "absorption": [0.2, 0.6, 1])";

TEST(Glass, a_block_of_glass_voxels_is_one_solid_without_inner_faces) {
    std::string cells;
    for (int i = 0; i < 64; ++i) cells += (i ? "," : "") + std::to_string(1 + (i * 7) % 3);
    const TestPicture voxels = render_stage(stage(
        R"({"geometry": {"type": "voxels", "size": [4, 4, 4], "cells": [)" + cells +
            R"(]}, "material": ["glass", "same", "glass"], "transform": [{"translate": [-2, -2, -2]}, {"scale": 0.4}]})",
        tint));
    const TestPicture box =
        render_stage(stage(R"({"geometry": {"type": "box", "size": [1.6, 1.6, 1.6]}, "material": "glass"})", tint));
    expect_same_glass(voxels, box);
}

TEST(Glass, water_against_glass_voxels_is_one_interface_as_of_nested_boxes) {
    const TestPicture voxels = render_stage(stage(
        R"({"geometry": {"type": "voxels", "layers": [["12", "12"], ["12", "12"]]}, "material": ["water", "glass"],
            "transform": [{"translate": [-1, -1, -1]}, {"scale": 0.8}]})",
        tint));
    // Water reaches into the glass; the glass has the higher priority.
    const TestPicture boxes = render_stage(stage(
        R"({"geometry": {"type": "box", "size": [1.2, 1.6, 1.6]}, "material": "water", "transform": [{"translate": [-0.2, 0, 0]}]},
           {"geometry": {"type": "box", "size": [0.8, 1.6, 1.6]}, "material": "glass", "transform": [{"translate": [0.4, 0, 0]}]})",
        tint));
    expect_same_glass(voxels, boxes);
}

TEST(Glass, a_voxel_of_nothing_is_no_neighbour_to_glass) {
    const auto picture = [](const std::string& row) {
        return render_stage(stage(R"({"geometry": {"type": "voxels", "layers": [[")" + row + R"("]]},
            "material": ["glass", null], "transform": [{"translate": [-1.5, -0.5, -0.5]}, {"scale": 0.8}]})",
                                  tint));
    };
    const TestPicture beside_air = picture("1.1"), beside_nothing = picture("121");
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) ASSERT_EQ(beside_nothing.at(x, y), beside_air.at(x, y)) << x << ", " << y;
}

// An axis-aligned box in triangles, wound outwards.
std::string box_mesh(dvec3 lower, dvec3 upper) {
    std::string positions, triangles;
    for (int i = 0; i < 8; ++i)
        positions += fmt::format("{}[{}, {}, {}]", i ? ", " : "", i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y,
                                 i & 4 ? upper.z : lower.z);
    for (const glm::ivec4 q : {glm::ivec4(0, 4, 6, 2), glm::ivec4(1, 3, 7, 5), glm::ivec4(0, 1, 5, 4),
                               glm::ivec4(2, 6, 7, 3), glm::ivec4(0, 2, 3, 1), glm::ivec4(4, 5, 7, 6)})
        triangles +=
            fmt::format("{}[{}, {}, {}], [{}, {}, {}]", triangles.empty() ? "" : ", ", q.x, q.y, q.z, q.x, q.z, q.w);
    return fmt::format(R"({{"geometry": {{"type": "mesh", "positions": [{}], "triangles": [{}]}}, )", positions,
                       triangles);
}

// A sparse set of 5×5×5: two layers of glass, and water around a notch of air in the others. The meshes overlap, and
// the glass has the higher priority.
TEST(Glass, water_touching_glass_touching_air_in_voxels_is_as_in_meshes) {
    std::string cells;
    for (int z = 0; z < 5; ++z)
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 5; ++x)
                cells += fmt::format("{}{}", cells.empty() ? "" : ",", x > 2 ? 2 : (y > 2 && z > 2 ? 0 : 1));
    const TestPicture voxels = render_stage(stage(
        R"({"geometry": {"type": "voxels", "size": [5, 5, 5], "cells": [)" + cells +
            R"(]}, "material": ["water", "glass"], "transform": [{"translate": [-2.5, -2.5, -2.5]}, {"scale": 0.36}]})",
        tint));
    // The water: an L of two boxes of the same water, which overlap; what is entered twice is left twice.
    const double s = 0.36;
    const TestPicture meshes = render_stage(
        stage(box_mesh(s * dvec3(-2.5, -2.5, -2.5), s * dvec3(1, 0.5, 2.5)) + R"("material": "water"}, )" +
                  box_mesh(s * dvec3(-2.5, -2.5, -2.5), s * dvec3(1, 2.5, 0.5)) + R"("material": "water"}, )" +
                  box_mesh(s * dvec3(0.5, -2.5, -2.5), s * dvec3(2.5, 2.5, 2.5)) + R"("material": "glass"})",
              tint));
    expect_same_glass(voxels, meshes);
}

TEST(Glass, a_glass_ball_in_water_displaces_it) {
    // Straight through the middle: air, water, glass, water, air; four bounces leave only the way without
    // reflections.
    const std::string text =
        R"({"version": 1, "film": {"size": [4, 4], "filter": "box", "filter_radius": 0.5},
        "integrator": {"max_bounces": 4},
        "camera": {"type": "orthographic", "from": [0, -0.0003, 3], "at": [0, -0.0003, 0], "height": 1e-4},
        "materials": {"glass": {"type": "dielectric", "ior": 1.5, "absorption": [0, 0.5, 1], "priority": 1},
                      "water": {"type": "dielectric", "ior": 1.33, "absorption": [1, 0.5, 0]},
                      "lamp": {"type": "diffuse", "color": 0, "emission": 1}},
        "objects": [ORDER, {"geometry": {"type": "rectangle", "size": [1, 1]}, "material": "lamp",
            "transform": [{"rotate": {"axis": [1, 0, 0], "degrees": 90}}, {"translate": [0, 0, -4]}]}]})";
    const std::string ball = R"({"geometry": {"type": "sphere", "radius": 0.5}, "material": "glass"})";
    const std::string pool =
        R"({"geometry": {"type": "box", "size": [2, 1, 2]}, "material": "water", "transform": [{"translate": [0, -0.4, 0]}]})";
    const auto passed = [](double n) { return 1 - (n - 1) * (n - 1) / ((n + 1) * (n + 1)); };
    const double t = std::pow(passed(1.33) * passed(1.5 / 1.33), 2);
    for (const std::string& order : {ball + ", " + pool, pool + ", " + ball}) {
        std::string scene = text;
        scene.replace(scene.find("ORDER"), 5, order);
        expect_mean(render_text(scene, 1024).mean(), t * dvec3(std::exp(-1.0), std::exp(-0.5 - 0.5), std::exp(-1.0)), 4,
                    0.01);
    }
}

TEST(Glass, spheres_are_the_same_as_implicit_surface_mesh_and_analytic) {
    for (const std::string& kind : {std::string(), tint, std::string(R"(, "interior": "milk")")}) {
        SCOPED_TRACE(kind);
        const TestPicture sphere = render_stage(stage(R"({"geometry": "ball", "material": "glass"})", kind));
        expect_same_glass(
            render_stage(
                stage(R"x({"geometry": {"type": "sdf", "expression": "sphere(1)"}, "material": "glass"})x", kind)),
            sphere);
        expect_same_glass(
            render_stage(
                stage(R"({"geometry": "mesh", "material": "glass"})", kind,
                      R"("mesh": {"type": "mesh", "positions": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0,1,2]]}, )"),
                128),
            sphere);
    }
}

TEST(Glass, turned_and_stretched_instances_are_the_same_of_a_mesh_and_of_a_sphere) {
    const std::string turned =
        R"(, "material": "glass", "transform": [{"scale": [1.1, 0.5, 0.8]}, {"rotate": {"axis": [1, 2, 3], "degrees": 50}}]})";
    const TestPicture sphere = render_stage(stage(R"({"geometry": "ball")" + turned, tint));
    const TestPicture mesh = render_stage(
        stage(R"({"geometry": "mesh")" + turned, tint,
              R"("mesh": {"type": "mesh", "positions": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0,1,2]]}, )"),
        128);
    expect_same_glass(mesh, sphere);
}

TEST(Glass, from_within_a_glass_ball_radiance_is_higher_by_the_square_of_the_index) {
    for (const double sigma : {0.0, 0.7}) {
        const TestPicture p = render_text(
            fmt::format(R"({{"version": 1, "film": {{"size": [4, 4], "filter": "box", "filter_radius": 0.5}},
            "camera": {{"type": "orthographic", "from": [0, 0, 0], "at": [1, 0.3, 0.2], "height": 1e-4}},
            "environment": {{"type": "constant", "radiance": 1}},
            "materials": {{"glass": {{"type": "dielectric", "ior": 1.5, "absorption": {}}}}},
            "objects": [{{"geometry": {{"type": "sphere", "radius": 1}}, "material": "glass"}}]}})",
                        sigma),
            1024);
        // Normal incidence; what is reflected comes back through the middle.
        const double f = 0.04, way = std::exp(-sigma);
        expect_mean(p.mean(), dvec3(2.25 * (1 - f) * way / (1 - f * way * way)), 4, 0.01);
    }
}

}  // namespace
}  // namespace spinel::glass_test
