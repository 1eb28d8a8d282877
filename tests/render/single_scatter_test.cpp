// `single-scatter` against closed forms; the device's shortcuts against the straight march.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>
#include <ctime>

#include "image/metrics.h"
#include "kernels/path.h"
#include "render/pictures.h"
#include "render/reference_march.h"

namespace spinel::single_scatter_test {
namespace {

using namespace test;

// A layer one unit thick, seen and lit from straight above.
std::string layer(const char* medium, const char* march, const char* more = "") {
    return fmt::format(R"json({{"version": 1,
      "camera": {{"type": "orthographic", "from": [0, 5, 0], "at": [0, 0, 0], "up": [0, 0, -1], "height": 0.1}},
      "film": {{"size": [2, 2], "filter": "box", "filter_radius": 0.5}},
      "integrator": {{"type": "single-scatter", "march": {{{}}}}},
      "media": {{"fog": {{{}}}}},
      "lights": [{{"type": "directional", "direction": [0, -1, 0], "irradiance": [10, 10, 10]}}],
      "materials": {{"white": {{"type": "diffuse", "color": 0.5}}}},
      "objects": [{}{{"geometry": {{"type": "box", "size": [9, 1, 9]}}, "material": null, "interior": "fog"}}]}})json",
                       march, medium, more);
}

TEST(SingleScatter, a_layer_is_as_bright_as_the_closed_form) {
    const TestPicture p = render_text(
        layer(R"("scattering": [1, 2, 4], "absorption": [0, 1, 2])", R"("step": 0.005, "shadow_step": 0.005)"), 1, 2);
    for (int k = 0; k < 3; ++k) {
        const double scattering = k == 0 ? 1 : k == 1 ? 2 : 4, extinction = k == 0 ? 1 : k == 1 ? 3 : 6;
        const double expected = scattering / (4 * M_PI) * 10 * (1 - std::exp(-2 * extinction)) / (2 * extinction);
        EXPECT_NEAR(p.mean().mean[k] / expected, 1, 0.005) << k;
    }
}

TEST(SingleScatter, naive_integration_is_brighter_by_what_a_step_absorbs) {
    const char* medium = R"("scattering": 4)";
    const double exact =
        render_text(layer(medium, R"("step": 0.1, "shadow_step": 0.001, "jitter": false)"), 1, 2).mean().mean.x;
    const double naive =
        render_text(layer(medium, R"("step": 0.1, "shadow_step": 0.001, "jitter": false, "integration": "naive")"), 1,
                    2)
            .mean()
            .mean.x;
    EXPECT_NEAR(naive / exact, 0.4 / (1 - std::exp(-0.4)), 0.002);
}

TEST(SingleScatter, the_ground_lies_in_the_shadow_of_the_medium) {
    const char* ground =
        R"({"geometry": {"type": "plane"}, "material": "white", "transform": [{"translate": [0, -2, 0]}]},)";
    const char* march = R"("step": 0.01, "surface_shadow_step": 0.01)";
    const double open = render_text(layer(R"("absorption": 0.0001)", march, ground), 1, 2).mean().mean.x;
    const double shadowed = render_text(layer(R"("absorption": 0.5)", march, ground), 1, 2).mean().mean.x;
    EXPECT_NEAR(open, 10 * 0.5 / M_PI, 0.002);
    EXPECT_NEAR(shadowed / open, std::exp(-1.0), 0.002);  // down and up again
}

TEST(SingleScatter, lamps_fade_out_at_their_reach) {
    const auto lamp = [](const char* reach) {
        return fmt::format(R"json({{"version": 1,
          "camera": {{"type": "orthographic", "from": [0, 5, 0], "at": [0, 0, 0], "up": [0, 0, -1], "height": 0.001}},
          "film": {{"size": [1, 1]}},
          "integrator": {{"type": "single-scatter", "march": {{"light_reach": {}}}}},
          "materials": {{"white": {{"type": "diffuse", "color": 1}}}},
          "lights": [{{"type": "point", "position": [0, 2, 0], "intensity": 8}}],
          "objects": [{{"geometry": {{"type": "plane"}}, "material": "white"}}]}})json",
                           reach);
    };
    EXPECT_NEAR(render_text(lamp("0"), 1, 2).mean().mean.x, 2 / M_PI, 1e-4);
    EXPECT_NEAR(render_text(lamp("3"), 1, 2).mean().mean.x, 2 / M_PI / 9, 1e-4);
    EXPECT_EQ(render_text(lamp("1.9"), 1, 2).mean().mean.x, 0);
}

TEST(SingleScatter, shortcuts_lead_to_the_same_picture) {
    for (const char* erosion : {R"("type": "fbm", "strength": 1)", R"("type": "value", "strength": 1.3)"}) {
        Image images[2];
        for (int i = 0; i < 2; ++i) {
            const std::string text = fmt::format(R"json({{"version": 1,
              "camera": {{"from": [0.5, 1.2, 2], "at": [0.5, 0.45, 0.5], "fov": 45}},
              "film": {{"size": [48, 27], "filter": "box", "filter_radius": 0.5}},
              "integrator": {{"type": "single-scatter", "march": {{"step": 0.02, "shadow_step": 0.1, "shadow_reach": 1,
                "surface_shadow_step": 0.05, "surface_shadow_reach": 2, "light_reach": 3, "shortcuts": {}}}}},
              "environment": {{"type": "constant", "radiance": 0.05}},
              "media": {{"bunny": {{"scattering": [22, 17, 12], "absorption": [1, 2, 4], "g": 0.3, "density": "bunny",
                "erosion": {{{}}}}}}},
              "materials": {{"grey": {{"type": "diffuse", "color": 0.3}}}},
              "geometries": {{"bunny": {{"type": "volume", "file": "{}/bunny32.bits"}}}},
              "objects": [
                {{"geometry": {{"type": "plane"}}, "material": "grey"}},
                {{"geometry": {{"type": "sphere", "radius": 0.1}}, "material": "grey",
                  "transform": [{{"translate": [0.9, 1.2, 0.6]}}]}},
                {{"geometry": "bunny", "interior": "bunny"}}],
              "lights": [{{"type": "point", "position": [0.85, 1.5, 0.2], "intensity": 14}},
                         {{"type": "directional", "direction": [1, -1, -1], "irradiance": 2}}]}})json",
                                                 i == 0, erosion, SPINEL_SOURCE_DIR "/examples");
            images[i] = render_text(text, 4, 2).image();
        }
        const Result<double> difference = rmse(images[0], images[1]);
        ASSERT_TRUE(difference);
        EXPECT_LT(*difference, 0.005) << erosion;
    }
}

// A hundred thousand steps through a box are more than a march may take; half of them are not.
TEST(SingleScatter, marches_that_are_cut_short_are_counted) {
    const auto scene = [](const char* step, bool shortcuts) {
        return compile_text(fmt::format(R"json({{"version": 1,
          "camera": {{"type": "orthographic", "from": [0.5, 0.3, 3], "at": [0.5, 0.3, 0], "height": 0.001}},
          "film": {{"size": [1, 1]}},
          "integrator": {{"type": "single-scatter", "march": {{"step": {}, "shortcuts": {}}}}},
          "environment": {{"type": "constant", "radiance": 1}},
          "media": {{"bunny": {{"scattering": 0.1, "density": "bunny"}}}},
          "geometries": {{"bunny": {{"type": "volume", "file": "{}/bunny32.bits"}}}},
          "objects": [{{"geometry": "bunny", "interior": "bunny"}}]}})json",
                                        step, shortcuts, SPINEL_SOURCE_DIR "/examples"));
    };
    for (const bool shortcuts : {false, true})
        for (const auto& [step, cut] : {std::pair("0.00001", 1u), std::pair("0.00002", 0u)}) {
            const Result<CompiledScene> compiled = scene(step, shortcuts);
            ASSERT_TRUE(compiled) << compiled.error().message;
            const Result<std::unique_ptr<Device>> device = make_device("cpu");
            const std::atomic<bool> stop{false};
            RenderOptions asked;
            asked.spp = 1;
            const Result<RenderResult> result = render(**device, *compiled, asked, stop);
            ASSERT_TRUE(result);
            EXPECT_EQ(result->film.bound_reached, cut) << step << shortcuts;
            if (shortcuts) continue;
            kernels::PathSettings settings = {};
            settings.march = march_settings(*compiled);
            const kernels::PathState s = kernels::path_generate(compiled->view(), settings, {0, 0}, 0);
            EXPECT_EQ(
                reference_single_scatter(compiled->view(), settings.march, s.ray, s.inside, s.numbers).bound_reached,
                cut == 1)
                << step;
        }
}

// The whole example against the naive twin; what both take is printed.
TEST(SlowSingleScatter, the_bunny_is_ten_times_as_fast_as_the_naive_march) {
    const ivec2 size = fewer_samples > 1 ? ivec2(64, 36) : ivec2(1280, 720);
    LoadOptions options;
    options.frame = 20;
    const Result<Scene> scene = load_scene(SPINEL_SOURCE_DIR "/examples/bunny.json", size, options);
    ASSERT_TRUE(scene) << scene.error().message;
    const Result<CompiledScene> compiled = compile(*scene);
    ASSERT_TRUE(compiled);
    const Result<std::unique_ptr<Device>> device = make_device("cpu");
    ASSERT_TRUE(device);
    const std::atomic<bool> stop{false};
    RenderOptions asked;
    asked.spp = 1;
    asked.seed = 5;
    const Result<RenderResult> fast = render(**device, *compiled, asked, stop);
    ASSERT_TRUE(fast);
    const kernels::SceneView view = compiled->view();
    kernels::PathSettings settings = {};
    settings.seed = 5;
    settings.march = march_settings(*compiled);
    Image images[2] = {{size.x, size.y, 3, {}}, {size.x, size.y, 3, {}}};
    const std::clock_t start = std::clock();
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const kernels::PathState s = kernels::path_generate(view, settings, {x, y}, 0);
            const vec3 c = reference_single_scatter(view, settings.march, s.ray, s.inside, s.numbers).radiance;
            for (int k = 0; k < 3; ++k) images[1].values.push_back(c[k]);
            const FilmPixel& p = fast->film.at(x, y);
            for (int k = 0; k < 3; ++k) images[0].values.push_back(float(p.sum[k] / double(p.count)));
        }
    const double naive = double(std::clock() - start) / CLOCKS_PER_SEC;
    const Result<double> difference = rmse(images[0], images[1]);
    ASSERT_TRUE(difference);
    EXPECT_LT(*difference, 0.005);
    fmt::print("naive {:.3f} s, shortcuts {:.3f} s of processor time: {:.1f} times; RMSE {:.5f}\n", naive,
               fast->cpu_seconds, naive / fast->cpu_seconds, *difference);
    if (fewer_samples == 1) { EXPECT_GT(naive / fast->cpu_seconds, 10); }
}

}  // namespace
}  // namespace spinel::single_scatter_test
