// The preview integrators against closed forms and against the path tracer.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>
#include <cstring>
#include <fstream>

#include "kernels/constants.h"
#include "render/pictures.h"

namespace spinel::preview_test {
namespace {

using namespace test;

// A picture from straight above of x in [x0, x1] at z = 0, one row of pixels as wide as high.
std::string from_above(double x0, double x1, int pixels, const std::string& rest) {
    const double edge = (x1 - x0) / pixels;
    return fmt::format(R"json({{"version": 1,
      "camera": {{"type": "orthographic", "from": [{}, 50, 0], "at": [{}, 0, 0], "up": [0, 0, -1], "height": {}}},
      "film": {{"size": [{}, 1], "filter": "box", "filter_radius": 0.01}}, {}}})json",
                       0.5 * (x0 + x1), 0.5 * (x0 + x1), edge, pixels, rest);
}

// A floor of 40×40 voxels about the origin whose top is y = 0, with a wall of 12 voxels where x < 0.
std::string floor_and_wall(const char* integrator, const char* light, const char* wall_color = "0.5") {
    std::string cells;
    for (int z = 0; z < 40; ++z)
        for (int y = 0; y < 13; ++y)
            for (int x = 0; x < 40; ++x) cells += y == 0 ? "1," : x < 20 ? "2," : "0,";
    cells.pop_back();
    return fmt::format(R"json("integrator": {{{}}}, {},
      "materials": {{"floor": {{"type": "diffuse", "color": 0.5}}, "wall": {{"type": "diffuse", "color": {}}}}},
      "objects": [{{"geometry": {{"type": "voxels", "size": [40, 13, 40], "cells": [{}]}}, "material": ["floor", "wall"],
                    "transform": [{{"translate": [-20, -1, -20.5]}}]}}])json",
                       integrator, light, wall_color, cells);
}

constexpr const char* white_sky = R"("environment": {"type": "constant", "radiance": 1})";
constexpr const char* low_sun =
    R"("lights": [{"type": "directional", "direction": [1, -1, 0], "irradiance": 3}],
       "environment": {"type": "constant", "radiance": 0.25})";

TEST(PreviewAo, voxels_darken_linearly_towards_a_wall) {
    const TestPicture p = render_text(from_above(0, 4, 32, floor_and_wall(R"("type": "ao")", white_sky)), 1, 2);
    for (int i = 0; i < 32; ++i) {
        const double x = (i + 0.5) / 8;  // one side and the cell across it are occupied: a third is left in the corner
        const double open = x < 1 ? 1 / 3.0 + 2 / 3.0 * x : 1;
        EXPECT_NEAR(p.at(i, 0).x, 0.5 * open, 0.004) << "x = " << x;
    }
}

// A single layer hides nothing from itself, and its sky is the same everywhere: on rounded edges too.
TEST(PreviewAo, rounded_voxels_on_a_plain_floor_lose_nothing) {
    const std::string scene = fmt::format(R"json("integrator": {{"type": "ao"}}, {},
      "materials": {{"grey": {{"type": "diffuse", "color": 0.5}}}},
      "objects": [{{"geometry": {{"type": "voxels", "layers": [["1.111", "11111", ".11.1"]], "rounding": 0.4}},
                    "material": "grey", "transform": [{{"translate": [0, -1, -1.5]}}]}}])json",
                                          white_sky);
    const TestPicture p = render_text(from_above(0, 5, 100, scene), 1, 2);
    for (int i = 0; i < 100; ++i) EXPECT_NEAR(p.at(i, 0).x, 0.5, 0.004) << "pixel " << i;
}

TEST(PreviewAo, strength_takes_as_much_as_it_says) {
    const TestPicture p =
        render_text(from_above(0, 4, 32, floor_and_wall(R"("type": "ao", "ao_strength": 0.5)", white_sky)), 1, 2);
    EXPECT_NEAR(p.at(0, 0).x, 0.5 * (1 - 0.5 * (1 - 1 / 3.0 - 2 / 3.0 / 16)), 0.004);
}

TEST(PreviewAo, rays_lose_half_of_the_sky_at_the_foot_of_a_high_wall_and_nothing_beyond_the_radius) {
    const char* rest = R"json("integrator": {{"type": "ao", "ao_radius": {}}}, {},
      "materials": {{"grey": {{"type": "diffuse", "color": 0.5}}}},
      "objects": [{{"geometry": {{"type": "plane"}}, "material": "grey"}},
                  {{"geometry": {{"type": "box", "size": [2, 80, 400]}}, "material": "grey",
                    "transform": [{{"translate": [-1, 0, 0]}}]}}])json";
    const auto at = [&](double x, double radius) {
        const std::string scene = fmt::format(fmt::runtime(rest), radius, white_sky);
        return render_text(from_above(x - 0.01, x + 0.01, 4, scene), 1024, 4).mean();
    };
    EXPECT_NEAR(at(0.1, 30).mean.x, 0.25, 0.003);
    expect_mean(at(1.1, 1), dvec3(0.5));
}

TEST(PreviewAo, meshes_darken_as_planes_and_boxes_do) {
    const std::string file = std::string(SPINEL_BINARY_DIR) + "/ao_corner.obj";
    std::ofstream(file) << "v -200 0 -200\nv 200 0 -200\nv 200 0 200\nv -200 0 200\n"  // a floor …
                           "v 0 0 -200\nv 0 80 -200\nv 0 80 200\nv 0 0 200\n"          // … and a wall on it
                           "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\n";
    for (const char* structure : {"wide-bvh8", "kd-tree", "grid"}) {
        const auto at = [&](double x, double radius) {
            const std::string scene = fmt::format(R"json("integrator": {{"type": "ao", "ao_radius": {}}}, {},
              "accelerator": {{"type": "{}"}}, "materials": {{"grey": {{"type": "diffuse", "color": 0.5}}}},
              "objects": [{{"geometry": {{"type": "mesh", "file": "{}"}}, "material": "grey"}}])json",
                                                  radius, white_sky, structure, file);
            return render_text(from_above(x - 0.01, x + 0.01, 4, scene), 1024, 4).mean();
        };
        EXPECT_NEAR(at(0.1, 30).mean.x, 0.25, 0.003) << structure;
        expect_mean(at(1.1, 1), dvec3(0.5));
    }
}

TEST(PreviewFaces, a_face_is_as_bright_as_sun_and_sky_make_it_without_grain) {
    const TestPicture p = render_text(from_above(0, 20, 20, floor_and_wall(R"("type": "faces")", low_sun)), 1, 2);
    // The wall's shadow is as long as it is high.
    const double shadow = 0.5 * 0.25, lit = shadow + 0.5 * 3 * std::sqrt(0.5) / M_PI;
    for (int i = 0; i < 19; ++i) {
        EXPECT_NEAR(p.at(i, 0).x, i < 12 ? shadow : lit, 1e-4) << i;
        EXPECT_EQ(p.batches[0][std::size_t(i)], p.batches[1][std::size_t(i)]);
    }
}

TEST(PreviewCone, an_open_floor_gets_the_whole_sky) {
    const TestPicture p =
        render_text(from_above(14, 16, 8, floor_and_wall(R"("type": "cone")", white_sky, "0")), 256, 4);
    // But for the wall, black, 15 away, 12 high and 40 long: the configuration factor of an element to a rectangle at
    // right angles to it, twice for its halves.
    const double d = 15, h = 12, b = 20, e = std::hypot(d, h);
    const double wall = (std::atan(b / d) - d / e * std::atan(b / e)) / M_PI;
    EXPECT_NEAR(p.mean().mean.x, 0.5 * (1 - wall), 0.015);
}

TEST(PreviewCone, sky_beside_a_black_wall_is_that_of_the_path_tracer) {
    for (const double x : {0.5, 2.5, 6.5, 12.5}) {
        const auto scene = [&](const char* integrator) {
            return from_above(x - 0.4, x + 0.4, 8, floor_and_wall(integrator, white_sky, "0"));
        };
        const double cone = render_text(scene(R"("type": "cone")"), 256, 4).mean().mean.x;
        const double path = render_text(scene(R"("type": "path")"), 256, 4).mean().mean.x;
        EXPECT_NEAR(cone / path, 1, 0.1) << "x = " << x << ", cone " << cone << ", path " << path;
    }
}

TEST(PreviewCone, bounced_light_is_near_that_of_one_bounce) {
    const auto scene = [&](const char* integrator) {
        return from_above(0.5, 10.5, 40,
                          floor_and_wall(integrator, R"("lights": [{"type": "directional", "direction": [-1, -1, 0],
                                                        "irradiance": 3}])",
                                         "0.8"));
    };
    const double cone = render_text(scene(R"("type": "cone")"), 256, 4).mean().mean.x;
    const double path = render_text(scene(R"("type": "path", "max_bounces": 2)"), 1024, 4).mean().mean.x;
    const double direct = render_text(scene(R"("type": "path", "max_bounces": 1)"), 1024, 4).mean().mean.x;
    EXPECT_GT(path, 1.1 * direct) << "there is something to see";
    EXPECT_NEAR((cone - direct) / (path - direct), 1, 0.35) << cone << ' ' << path << ' ' << direct;
}

TEST(PreviewCone, the_shadow_of_the_sun_ends_where_the_wall_says) {
    const TestPicture p = render_text(from_above(0, 20, 20, floor_and_wall(R"("type": "cone")", low_sun, "0")), 256, 4);
    const double sun = 0.5 * 3 * std::sqrt(0.5) / M_PI;
    for (const int dark : {2, 6, 10}) EXPECT_LT(p.at(dark, 0).x, 0.5 * 0.25 + 0.02 * sun) << dark;
    for (const int lit : {14, 16, 18}) EXPECT_GT(p.at(lit, 0).x, 0.97 * sun) << lit;
}

TEST(PreviewCone, a_set_that_is_turned_and_scaled_looks_the_same) {
    const auto mean = [](const char* transform, const char* camera) {
        std::string cells;
        for (int i = 0; i < 16 * 16 * 16; ++i) cells += i / 256 < 6 || (i % 16 > 9 && i / 256 < 11) ? "1," : "0,";
        cells.pop_back();
        return render_text(fmt::format(R"json({{"version": 1, "film": {{"size": [24, 24]}}, "camera": {},
          "integrator": {{"type": "cone"}}, "environment": {{"type": "constant", "radiance": 1}},
          "materials": {{"grey": {{"type": "diffuse", "color": 0.7}}}},
          "objects": [{{"geometry": {{"type": "voxels", "size": [16, 16, 16], "cells": [{}]}}, "material": "grey",
                        "transform": {}}}]}})json",
                                       camera, cells, transform),
                           64, 4)
            .mean()
            .mean.x;
    };
    const double plain = mean(R"([{"translate": [-8, -8, -8]}])", R"({"from": [20, 18, 30], "at": [0, 0, 0]})");
    const double turned =
        mean(R"([{"translate": [-8, -8, -8]}, {"scale": 0.1}, {"rotate": {"axis": [0, 1, 0], "degrees": 90}},
                                   {"translate": [5, 0, 0]}])",
             R"({"from": [8, 1.8, -2], "at": [5, 0, 0]})");
    EXPECT_NEAR(turned / plain, 1, 0.01);
}

// ∫ of the kernel along the line past one voxel, by small steps.
double halo(double b, double radius, double strength, double radiance) {
    double sum = 0;
    const double step = 1e-4;
    for (double s = -radius; s < radius; s += step) {
        const double k = 1 - (b * b + s * s) / (radius * radius);
        if (k > 0) sum += k * k * step;
    }
    return strength * radiance * sum * 105 / (32 * M_PI * std::pow(radius, 3)) / radius;
}

std::string lamp_in_set(int size, int lamp, const char* integrator) {
    // The lamp's middle is at the origin; the camera looks down past it.
    return fmt::format(R"json("integrator": {{{}}},
      "materials": {{"lamp": {{"type": "diffuse", "color": 0, "emission": 6}}}},
      "objects": [{{"geometry": {{"type": "voxels", "size": [{}, {}, {}], "cells": [{}]}}, "material": "lamp",
                    "transform": [{{"translate": [{}, {}, {}]}}]}}])json",
                       integrator, size, size, size,
                       [&] {
                           std::string cells;
                           for (int i = 0; i < size * size * size; ++i)
                               cells += i == lamp * (1 + size + size * size) ? "1," : "0,";
                           cells.pop_back();
                           return cells;
                       }(),
                       -lamp - 0.5, -lamp - 0.5, -lamp - 0.5);
}

TEST(PreviewGlow, the_halo_of_a_voxel_is_the_integral_along_the_ray) {
    for (const char* integrator :
         {R"("type": "faces", "glow": 2)", R"("type": "ao", "glow": 2)", R"("type": "cone", "glow": 2)"}) {
        const TestPicture p = render_text(from_above(0.6, 4.6, 16, lamp_in_set(4, 1, integrator)), 1, 2);
        for (int i = 0; i < 16; ++i)
            EXPECT_NEAR(p.at(i, 0).x, halo(0.6 + 4 * (i + 0.5) / 16, 4, 2, 6), 2e-4) << integrator << ' ' << i;
        EXPECT_GT(p.at(0, 0).x, 0.05);
    }
}

TEST(PreviewGlow, does_not_depend_on_how_the_set_is_divided_or_where_the_voxel_sits) {
    const char* integrator = R"("type": "faces", "glow": 1, "glow_radius": 3)";
    const TestPicture a = render_text(from_above(0.6, 4.6, 16, lamp_in_set(2, 1, integrator)), 1, 2);
    for (const auto& [size, lamp] : {std::pair(5, 0), std::pair(21, 15), std::pair(21, 16)}) {
        const TestPicture b = render_text(from_above(0.6, 4.6, 16, lamp_in_set(size, lamp, integrator)), 1, 2);
        for (int i = 0; i < 16; ++i) EXPECT_NEAR(a.at(i, 0).x, b.at(i, 0).x, 1e-6) << size << ' ' << lamp << ' ' << i;
    }
}

TEST(PreviewGlow, a_wide_halo_of_many_voxels_may_take_them_together) {
    // 8³ glowing cells seen with a radius of 40: nodes of 4³ count as one. Against the sum over the voxels.
    const TestPicture p = render_text(from_above(10, 30, 8,
                                                 fmt::format(R"json(
      "integrator": {{"type": "faces", "glow": 1, "glow_radius": 40}},
      "materials": {{"lamp": {{"type": "diffuse", "color": 0, "emission": 6}}}},
      "objects": [{{"geometry": {{"type": "voxels", "size": [8, 8, 8], "cells": [{}]}}, "material": "lamp",
                    "transform": [{{"translate": [-4, -4, -4]}}]}}])json",
                                                             [] {
                                                                 std::string cells;
                                                                 for (int i = 0; i < 512; ++i) cells += i ? ",1" : "1";
                                                                 return cells;
                                                             }())),
                                      1, 2);
    for (int i = 0; i < 8; ++i) {
        const double x = 10 + 20 * (i + 0.5) / 8;
        double sum = 0;
        for (int a = 0; a < 8; ++a)
            for (int c = 0; c < 8; ++c) sum += 8 * halo(std::hypot(x - (a - 3.5), c - 3.5), 40, 1, 6);
        EXPECT_NEAR(p.at(i, 0).x / sum, 1, 0.01) << x;
    }
}

TEST(Preview, a_scene_without_sun_and_sky_is_not_black) {
    for (const char* integrator : {"ao", "faces", "cone"}) {
        const TestPicture p = render_text(
            from_above(10, 14, 4,
                       floor_and_wall(fmt::format(R"("type": "{}")", integrator).c_str(), R"("lights": [])")),
            4, 2);
        EXPECT_GT(p.mean().mean.x, 0.1) << integrator;
    }
}

TEST(Preview, is_refused_for_a_scene_that_was_compiled_for_something_else) {
    Result<CompiledScene> scene = compile_text(from_above(0, 4, 4, floor_and_wall(R"("type": "ao")", white_sky)));
    ASSERT_TRUE(scene);
    const auto device = make_device("cpu");
    const std::atomic<bool> stop{false};
    const auto result = render(**device, *scene, {.spp = 1, .integrator = "cone"}, stop);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().message, "the scene was compiled for another integrator than 'cone'");
}

// --------------------------------------------------------------------------------------------------- level of detail
std::string hills(double pixels, const char* extra = "") {
    std::string cells;
    for (int z = 0; z < 96; ++z)
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 96; ++x) {
                const double h = 10 + 5 * std::sin(0.13 * x) + 4 * std::sin(0.21 * z + 0.05 * x);
                cells += y >= h ? "0," : y + 1 >= h ? "2," : "1,";
            }
    cells.pop_back();
    return fmt::format(R"json({{"version": 1, "film": {{"size": [64, 36]}},
      "camera": {{"from": [48, 60, 200], "at": [48, 5, 48], "fov": 30}},
      "environment": {{"type": "sky", "sun_elevation": 30, "sun_azimuth": 60}},
      "materials": {{"earth": {{"type": "diffuse", "color": [0.3, 0.2, 0.1]}}, "grass": {{"type": "diffuse", "color": [0.2, 0.4, 0.1]{}}}}},
      "objects": [{{"geometry": {{"type": "voxels", "size": [96, 24, 96], "level_of_detail": {}, "cells": [{}]}},
                    "material": ["earth", "grass"]}}]}})json",
                       extra, pixels, cells);
}

TEST(LevelOfDetail, off_is_the_same_to_the_last_bit) {
    const Result<CompiledScene> without = compile_text(hills(0)), tiny = compile_text(hills(1e-3));
    ASSERT_TRUE(without) << without.error().message;
    ASSERT_TRUE(tiny);
    EXPECT_EQ(without->words, tiny->words);
    ASSERT_EQ(without->voxel_nodes.size(), tiny->voxel_nodes.size());
    EXPECT_EQ(std::memcmp(without->voxel_nodes.data(), tiny->voxel_nodes.data(),
                          tiny->voxel_nodes.size() * sizeof(kernels::VoxelNode)),
              0);
}

TEST(LevelOfDetail, what_is_smaller_than_a_pixel_takes_no_room_and_the_picture_hardly_changes) {
    const Result<CompiledScene> whole = compile_text(hills(0)), coarse = compile_text(hills(3)),
                                coarsest = compile_text(hills(24));
    ASSERT_TRUE(whole && coarse && coarsest);
    EXPECT_LT(coarse->voxel_nodes.size() + coarse->words.size(), whole->voxel_nodes.size() + whole->words.size());
    EXPECT_LT(coarsest->voxel_nodes.size(), whole->voxel_nodes.size() / 4);
    const dvec3 a = render_scene(*whole, 64).mean().mean, b = render_scene(*coarse, 64).mean().mean;
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(b[k] / a[k], 1, 0.04) << k;
}

TEST(LevelOfDetail, lamps_stay_what_they_are) {
    const char* glowing = R"(, "emission": 4)";
    const Result<CompiledScene> whole = compile_text(hills(0, glowing)), coarse = compile_text(hills(4, glowing));
    ASSERT_TRUE(whole && coarse);
    ASSERT_GT(whole->lights.size(), 1000u);
    ASSERT_EQ(whole->lights.size(), coarse->lights.size());
    for (std::size_t i = 0; i < whole->lights.size(); ++i) {
        ASSERT_EQ(whole->lights[i].position, coarse->lights[i].position);
        ASSERT_EQ(whole->lights[i].key, coarse->lights[i].key);
    }
}

}  // namespace
}  // namespace spinel::preview_test
