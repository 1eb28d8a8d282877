// The integrators of the laboratory: `whitted`, `direct`, `depth`, `heatmap`.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>

#include "kernels/heatmap.h"
#include "render/pictures.h"

namespace spinel::gauge_test {
namespace {

using namespace test;

std::string scene_with(const std::string& integrator, const std::string& rest, int size = 16) {
    return fmt::format(R"json({{"version": 1,
      "camera": {{"from": [0, 3, 6], "at": [0, 0.5, 0], "fov": 40}},
      "film": {{"size": [{0}, {0}], "filter": "box", "filter_radius": 0.5}},
      "integrator": {{{1}}}, {2}}})json",
                       size, integrator, rest);
}

constexpr const char* ball_and_floor = R"json("environment": {"type": "constant", "radiance": 0.25},
  "lights": [{"type": "directional", "direction": [1, -2, 0.5], "irradiance": 3}],
  "materials": {"grey": {"type": "diffuse", "color": 0.5}, "red": {"type": "diffuse", "color": [0.8, 0.1, 0.1]}},
  "objects": [{"geometry": {"type": "sphere", "radius": 1}, "material": "red", "transform": [{"translate": [0, 1, 0]}]},
              {"geometry": {"type": "plane"}, "material": "grey"}])json";

TEST(Direct, is_the_path_tracers_first_bounce) {
    const TestPicture direct = render_text(scene_with(R"("type": "direct")", ball_and_floor), 4, 1);
    const TestPicture once = render_text(scene_with(R"("type": "path", "max_bounces": 1)", ball_and_floor), 4, 1);
    const TestPicture all = render_text(scene_with(R"("type": "path")", ball_and_floor), 4, 1);
    EXPECT_EQ(direct.batches, once.batches);
    EXPECT_NE(direct.batches, all.batches);
}

TEST(Whitted, where_nothing_is_polished_it_is_direct_light_to_the_last_bit) {
    const TestPicture tree = render_text(scene_with(R"("type": "whitted")", ball_and_floor), 4, 2);
    const TestPicture direct = render_text(scene_with(R"("type": "direct")", ball_and_floor), 4, 2);
    EXPECT_EQ(tree.batches, direct.batches);
}

TEST(Whitted, nothing_is_lost_in_glass_and_nothing_is_noisy) {
    const std::string rest = R"json("environment": {"type": "constant", "radiance": 1},
      "materials": {"glass": {"type": "dielectric", "ior": 1.5}},
      "objects": [{"geometry": {"type": "box", "size": [2, 2, 2]}, "material": "glass",
                   "transform": [{"rotate": {"axis": [1, 2, 3], "degrees": 30}}]}])json";
    // What is left of the noise is what rays that carry little add by chance.
    const TestPicture p = render_text(scene_with(R"("type": "whitted")", rest), 4, 2);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) EXPECT_NEAR(p.at(x, y).x, 1, 0.005) << x << ' ' << y;
}

TEST(Whitted, glass_absorbs_along_the_way) {
    const std::string text = R"json({"version": 1,
      "camera": {"type": "orthographic", "from": [0, 0, 9], "at": [0, 0, 0], "height": 1},
      "film": {"size": [4, 4], "filter": "box", "filter_radius": 0.5}, "integrator": {"type": "whitted"},
      "environment": {"type": "constant", "radiance": 1},
      "materials": {"glass": {"type": "dielectric", "ior": 1.0001, "absorption": [0, 0.5, 1]}},
      "objects": [{"geometry": {"type": "box", "size": [4, 4, 2]}, "material": "glass"}]})json";
    const dvec3 seen = render_text(text, 4, 2).mean().mean;
    EXPECT_NEAR(seen.x, 1, 1e-3);
    EXPECT_NEAR(seen.y, std::exp(-1.0), 1e-3);
    EXPECT_NEAR(seen.z, std::exp(-2.0), 1e-3);
}

// Mirrors and panes of glass in a row: the tree's mean is that of paths that go one way by chance, its noise is not.
TEST(Whitted, is_the_mean_of_paths_where_all_surfaces_are_polished) {
    const std::string rest = R"json("environment": {"type": "sky", "sun_elevation": 40, "sun": false},
      "materials": {"glass": {"type": "dielectric", "ior": 1.6, "absorption": [0.3, 0.1, 0]},
                    "mirror": {"type": "metal", "preset": "silver", "roughness": 0}},
      "objects": [{"geometry": {"type": "sphere", "radius": 1}, "material": "glass", "transform": [{"translate": [0, 1, 0]}]},
                  {"geometry": {"type": "sphere", "radius": 0.6}, "material": "mirror", "transform": [{"translate": [1.5, 0.6, 1]}]},
                  {"geometry": {"type": "plane"}, "material": "mirror"}])json";
    const auto picture = [&](const char* integrator, int spp) {
        return render_text(scene_with(integrator, rest), spp, 8);
    };
    const TestPicture tree = picture(R"("type": "whitted")", 4);
    expect_same(tree, picture(R"("type": "path", "max_bounces": 64)", 64), 4, 0.02);
    const TestPicture as_many = picture(R"("type": "path", "max_bounces": 64)", 4);
    EXPECT_LT(tree.mean().error.x, 0.8 * as_many.mean().error.x);
}

// The coat's reflection is followed, the base gets direct light: what paths with one bounce have, where what is
// reflected is the sky.
TEST(Whitted, coats_count_with_the_base_below) {
    const auto scene = [](const char* integrator) {
        return scene_with(integrator, R"json("environment": {"type": "constant", "radiance": 0.5},
          "lights": [{"type": "directional", "direction": [1, -2, -0.5], "irradiance": 3}],
          "materials": {"coat": {"type": "plastic", "color": [0.6, 0.3, 0.1]}},
          "objects": [{"geometry": {"type": "sphere", "radius": 1.5}, "material": "coat"}])json");
    };
    const TestPicture tree = render_text(scene(R"("type": "whitted")"), 64, 8);
    const TestPicture once = render_text(scene(R"("type": "path", "max_bounces": 1)"), 256, 8);
    expect_same(tree, once);
}

TEST(Depth, falls_evenly_from_the_camera) {
    const std::string text = R"json({"version": 1,
      "camera": {"type": "orthographic", "from": [0, 8, 0], "at": [0, 0, 0], "up": [0, 0, -1], "height": 2},
      "film": {"size": [4, 4], "filter": "box", "filter_radius": 0.5},
      "integrator": {"type": "depth", "depth_end": 10}, "environment": {"type": "constant", "radiance": 1},
      "materials": {"grey": {"type": "diffuse", "color": 0.5}},
      "objects": [{"geometry": {"type": "rectangle", "size": [9, 9]}, "material": "grey",
                   "transform": [{"translate": [0, 2, 0]}]}]})json";
    const TestPicture p = render_text(text, 2, 2);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(p.at(i, 3 - i).x, 0.4, 1e-5);
}

// A closed ball of many triangles in front of nothing, rays beside it and through it.
TEST(Heatmap, shows_what_is_counted_and_that_structures_differ) {
    const auto picture = [&](const std::string& structure, int counter) {
        const std::string rest = fmt::format(R"json("accelerator": {{"type": "{}"}},
          "materials": {{"grey": {{"type": "diffuse", "color": 0.5}}}},
          "objects": [{{"geometry": {{"type": "mesh", "file": "{}/examples/knot.ply"}}, "material": "grey"}}])json",
                                             structure, SPINEL_SOURCE_DIR);
        const std::string integrator =
            fmt::format(R"("type": "heatmap", "heat_counter": {}, "heat_most": 60)", counter);
        return render_text(scene_with(integrator, rest), 1, 2);
    };
    const auto linear = [](const vec3& c) {
        return dvec3(kernels::srgb_to_linear(c.x), kernels::srgb_to_linear(c.y), kernels::srgb_to_linear(c.z));
    };
    const dvec3 nothing = linear(kernels::heat_color(0));
    for (const int counter : {0, 1, 2, 3}) {
        const TestPicture p = picture("bvh2", counter), q = picture("grid", counter);
        EXPECT_GT(glm::length(p.mean().mean - nothing), 0.02) << counter;
        EXPECT_NE(p.batches, q.batches) << counter;
    }
    EXPECT_LT(glm::length(picture("bvh2", 3).at(0, 0) - nothing), 1e-4) << "a corner that sees no triangle tests none";
}

}  // namespace
}  // namespace spinel::gauge_test
