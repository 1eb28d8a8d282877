// `dvr` against closed forms, and the device's packets against the kernel.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>

#include "devices/cpu/dvr_packet.h"
#include "image/metrics.h"
#include "kernels/dvr.h"
#include "kernels/traverse.h"
#include "render/dvr_volumes.h"
#include "scene/transfer.h"

namespace spinel::dvr_test {
namespace {

using namespace test;

TEST_F(Dvr, packets_show_what_the_kernel_shows) {
    write(32, ball);
    const char* cases[] = {
        "",
        R"(, "light": "scene", "specular": 0.6)",
        R"(, "shaded": false, "step": 0.5)",
        R"(, "step": 2.5, "jitter": true)",
        R"(, "clip_lower": [0.2, 0, 0], "clip_upper": [1, 0.7, 0.9], "clip_planes": [[0, 0.6, 0.8, 0.75]])",
        R"(, "color_map": "viridis", "opacity": 3)",
        R"(, "light": "scene", "shadow": 0.8)",
        R"(, "shadow": 0.5, "shadow_reach": 12, "shaded": false, "clip_upper": [0.8, 1, 1])",
        R"(, "mode": "maximum")",
        R"(, "mode": "maximum", "step": 0.3, "jitter": true, "clip_planes": [[1, 0.2, 0, 0.7], [0, -1, 0, -0.1]])",
        R"(, "mode": "average", "clip_lower": [0.2, 0.2, 0.2], "clip_upper": [0.8, 0.8, 0.8])",
        R"(, "mode": "average", "step": 0.4, "jitter": true, "clip_lower": [0.3, 0.3, 0.3])",
        R"(, "mode": "isosurface", "iso": 50)",
        R"(, "mode": "isosurface", "iso": 20.5, "light": "scene", "shadow": 1, "jitter": true, "step": 0.7)",
        R"(, "mode": "isosurface", "iso": 30, "clip_planes": [[0, 0.6, 0.8, 0.75]], "clip_upper": [0.7, 1, 1])",
    };
    const char* more =
        R"({"geometry": {"type": "sphere", "radius": 0.2}, "material": "grey", "transform": [{"translate": [0.5, 1, 0.5]}]},)";
    for (const char* options : cases)
        for (const char* objects : {"", more}) {
            Image images[2];
            for (int i = 0; i < 2; ++i)
                images[i] = render_text(scene(fmt::format("{}{}, \"shortcuts\": {}", layers, options, i == 0), oblique,
                                              32, objects),
                                        4, 2)
                                .image();
            const Result<double> difference = rmse(images[0], images[1]);
            ASSERT_TRUE(difference);
            EXPECT_LT(*difference, 5e-4) << options;
            EXPECT_GT(channel_means(images[0])[0], 0.01) << options;
        }
}

// Rays leap together as far as the nearest obstacle of any of them; what each comes to may not depend on its company.
TEST_F(Dvr, a_crop_is_that_part_of_the_whole_bit_by_bit) {
    write(32, ball);
    for (const char* options :
         {R"(, "jitter": true, "step": 0.7)", R"(, "light": "scene", "shadow": 0.7)", R"(, "mode": "maximum")",
          R"(, "mode": "average", "clip_upper": [1, 1, 0.6])", R"(, "mode": "isosurface", "iso": 33.3)"}) {
        const Result<CompiledScene> compiled = compile_text(scene(std::string(layers) + options, oblique, 40));
        ASSERT_TRUE(compiled) << compiled.error().message;
        const Result<std::unique_ptr<Device>> device = make_device("cpu");
        const std::atomic<bool> stop{false};
        RenderOptions asked;
        asked.spp = 3;
        const Result<RenderResult> whole = render(**device, *compiled, asked, stop);
        asked.crop = {{9, 13}, {30, 34}};
        const Result<RenderResult> part = render(**device, *compiled, asked, stop);
        ASSERT_TRUE(whole && part);
        for (int y = 13; y < 34; ++y)
            for (int x = 9; x < 30; ++x) EXPECT_EQ(part->film.at(x, y).sum, whole->film.at(x, y).sum) << options;
    }
}

// Opacity is told of a layer of one voxel; 32 of them.
TEST_F(Dvr, opacity_does_not_depend_on_the_step) {
    write(32, [](int, int, int) { return 5.0f; });
    for (const char* step : {"0.25", "1", "3"}) {
        const TestPicture p = render_text(
            scene(fmt::format(R"("points": [{{"value": 0, "color": 1, "opacity": 0.02}}, {{"value": 10, "color": 1,
                              "opacity": 0.02}}], "shaded": false, "step": {})",
                              step),
                  straight, 1),
            4, 2);
        EXPECT_NEAR(p.mean().mean.x, 1 - std::pow(0.98, 32), 0.025) << step;
    }
}

// A layer far thinner than a step, between two values: pre-integration finds it whole.
TEST_F(Dvr, thin_layers_are_not_missed) {
    write(32, [](int, int, int z) { return 10.0f * float(z); });
    double means[2];
    for (int i = 0; i < 2; ++i)
        means[i] =
            render_text(scene(fmt::format(R"("points": [{{"value": 0}}, {{"value": 154}}, {{"value": 155, "color": 1,
              "opacity": 0.9}}, {{"value": 156}}, {{"value": 310}}], "shaded": false, "step": {}, "jitter": true)",
                                          i == 0 ? "0.01" : "2"),
                              straight, 4),
                        16, 2)
                .mean()
                .mean.x;
    EXPECT_GT(means[0], 0.1);
    EXPECT_NEAR(means[1] / means[0], 1, 0.03);
}

TEST_F(Dvr, projections_show_the_greatest_and_the_mean_value) {
    write(32, [](int, int, int z) { return float(z); });
    const auto shown = [&](const char* mode) {
        return render_text(
                   scene(
                       fmt::format(R"("mode": "{}", "step": 0.1, "points": [{{"value": 0, "color": 0, "opacity": 0.5}},
              {{"value": 31, "color": 1, "opacity": 0.5}}])",
                                   mode),
                       straight, 1),
                   4, 2)
            .mean()
            .mean.x;
    };
    EXPECT_NEAR(shown("maximum"), 1, 0.01);
    EXPECT_NEAR(shown("average"), 0.5, 0.01);
}

TEST_F(Dvr, isosurfaces_are_met_where_they_are) {
    write(32, [](int, int, int z) { return float(z); });  // from +z: 31 first
    const Result<CompiledScene> compiled =
        compile_text(scene(R"("mode": "isosurface", "iso": 20.3, "iso_color": [0.5, 0.6, 0.7])", straight, 1));
    ASSERT_TRUE(compiled);
    const kernels::SceneView view = compiled->view();
    kernels::Sampler numbers = kernels::make_sampler({0, 0}, 0, 1);
    const kernels::PixelSample seen =
        kernels::dvr(view, compiled->dvr, kernels::Ray(vec3(0.5f, 0.5f, 3), 0, vec3(0, 0, -1), kernels::INFINITE),
                     kernels::no_hit(kernels::INFINITE), numbers);
    // The first surface is the upper face, where the value is above already.
    EXPECT_NEAR(seen.first.depth, 2.0f, 1e-4f);
    const kernels::PixelSample from_below =
        kernels::dvr(view, compiled->dvr, kernels::Ray(vec3(0.5f, 0.5f, -2), 0, vec3(0, 0, 1), kernels::INFINITE),
                     kernels::no_hit(kernels::INFINITE), numbers);
    EXPECT_NEAR(from_below.first.depth, 2 + (20.3f + 0.5f) / 32, 1e-5f);
    EXPECT_NEAR(from_below.first.normal.z, -1, 1e-5f);
    EXPECT_NEAR(from_below.radiance.y, 0.6f * (0.25f + 0.75f) + 0.2f, 1e-4f);
}

// Whole numbers are kept as they are in 16 bits, so a plateau of just the surface's value is above it for both.
TEST_F(Dvr, plateaus_of_whole_numbers_are_on_the_side_that_the_kernel_has_them_on) {
    write(32, [](int x, int y, int z) { return float(2000 + 10 * (x / 8) + (y / 16) + 3 * (z / 4)); });
    Image images[2];
    for (int i = 0; i < 2; ++i)
        images[i] =
            render_text(
                scene(fmt::format(R"("mode": "isosurface", "iso": 2031, "shortcuts": {})", i == 0), oblique, 48), 4, 1)
                .image();
    const Result<double> difference = rmse(images[0], images[1]);
    ASSERT_TRUE(difference);
    EXPECT_LT(*difference, 1e-3);
    EXPECT_GT(channel_means(images[0])[0], 0.05);
}

// Values that mean "no data" lie so far off that 16 bits over the whole range have few units for the rest.
TEST_F(Dvr, surfaces_stay_where_they_are_beside_values_that_mean_no_data) {
    const auto value = [](int x, int y, int z) {
        return 1.5f - 0.08f * glm::length(vec3(float(x), float(y), float(z)) - 15.5f);
    };
    for (const float no_data : {-9999.0f, -600.0f, -300.0f, -150.0f, 1.5f, -1e30f}) {
        write(32, [&](int x, int y, int z) {
            const bool lost = (x * 7919 + y * 104729 + z * 1299709) % 101 == 0;
            return lost ? no_data : std::max(value(x, y, z), 0.0f);
        });
        Image images[2];
        for (int i = 0; i < 2; ++i)
            images[i] = render_text(scene(fmt::format(R"("mode": "isosurface", "iso": 0.7, "shortcuts": {})", i == 0),
                                          oblique, 48),
                                    4, 1)
                            .image();
        const Result<double> difference = rmse(images[0], images[1]);
        ASSERT_TRUE(difference);
        EXPECT_LT(*difference, 0.005) << no_data;
        EXPECT_GT(channel_means(images[0])[0], 0.05) << no_data;
    }
}

TEST_F(Dvr, packets_take_surfaces_whose_slopes_16_bits_tell_apart) {
    const auto taken = [&](float iso) {
        const Result<CompiledScene> compiled =
            compile_text(scene(fmt::format(R"("mode": "isosurface", "iso": {})", iso), oblique, 8));
        EXPECT_TRUE(compiled) << compiled.error().message;
        return compiled && DvrPackets::make(*compiled, compiled->dvr) != nullptr;
    };
    write(32, ball);
    EXPECT_TRUE(taken(40));
    EXPECT_TRUE(taken(1000)) << "nothing is there";
    // A cliff, half-empty, with values far off: units are no coarser than they need to be for it.
    write(32, [](int x, int y, int z) { return ball(x, y, z) < 50 ? -9999.5f : 2000.0f; });
    EXPECT_TRUE(taken(40));
    write(32, [](int x, int y, int z) { return x == 0 ? -9999.0f : 0.01f * ball(x, y, z); });
    EXPECT_FALSE(taken(0.4f));
}

// A needle of 2×2×1000 samples along the view, in steps of a hundredth: more than a march may take.
TEST_F(Dvr, marches_that_are_cut_short_are_counted) {
    write({2, 2, 1000}, [](int, int, int z) { return 0.5f + 0.0005f * float(999 - z); });
    const auto cut = [&](const char* dvr, bool shortcuts) {
        const Result<CompiledScene> compiled = compile_text(scene(
            fmt::format(R"("points": [{{"value": 0.4, "opacity": 1e-7}}, {{"value": 1, "opacity": 1e-7}}],
                              "shaded": false, "shortcuts": {}, {})",
                        shortcuts, dvr),
            R"("type": "orthographic", "from": [0.001, 0.001, 3], "at": [0.001, 0.001, 0], "height": 0.0005)", 1));
        EXPECT_TRUE(compiled) << compiled.error().message;
        const Result<std::unique_ptr<Device>> device = make_device("cpu");
        const std::atomic<bool> stop{false};
        RenderOptions options;
        options.spp = 1;
        const Result<RenderResult> result = render(**device, *compiled, options, stop);
        EXPECT_TRUE(result);
        return result ? result->film.bound_reached : 0;
    };
    const auto expect_counted = [&](const char* mode) {
        for (const bool shortcuts : {false, true}) {
            EXPECT_EQ(cut(fmt::format("{}, \"step\": 0.01", mode).c_str(), shortcuts), 1u) << mode << shortcuts;
            EXPECT_EQ(cut(fmt::format("{}, \"step\": 0.02", mode).c_str(), shortcuts), 0u) << mode << shortcuts;
        }
    };
    for (const char* mode : {R"("mode": "composite")", R"("mode": "maximum")", R"("mode": "average")"})
        expect_counted(mode);
    // Just not a surface in any of the bricks.
    write({2, 2, 1000}, [](int, int, int z) { return z % 2 == 0 ? 0.5f : 1.0f; });
    expect_counted(R"("mode": "isosurface", "iso": 1.000002)");
}

TEST(Transfer, windows_move_what_is_told) {
    DvrOptions o;
    o.points = {{0, vec3(0), 0}, {0.5f, vec3(1), 0.5f}, {1, vec3(1), 0.5f}};
    o.level = 40, o.width = 400;
    const std::vector<TransferPoint> points = transfer_points(o, 0, 1);
    EXPECT_EQ(points[0].value, -160);
    EXPECT_EQ(points[1].value, 40);
    EXPECT_EQ(points[2].value, 240);
    o.points.clear();
    o.width = 0;
    EXPECT_EQ(transfer_points(o, -5, 7).front().value, -5);  // a ramp over what the data holds
    o.preset = DvrOptions::Preset::ct_bone;
    EXPECT_EQ(transfer_points(o, -5, 7).front().value, 150);  // Hounsfield, whatever the data holds
}

// What the kernel reads between entries, against the points themselves: linear between them, constant outside; and the
// mean over a piece against a sum of thousands of look-ups.
TEST(Transfer, tables_are_the_points_that_were_told) {
    DvrOptions o;
    o.points = {{-1000, {0, 0, 1}, 0}, {-200, {1, 0, 0}, 0.3f}, {300, {1, 1, 0}, 0.1f}, {1500, {1, 1, 1}, 0.9f}};
    const std::vector<TransferPoint> points = transfer_points(o, 0, 1);
    const TransferTable table = transfer_table(points, 0.5f, 2);
    CompiledScene scene;
    scene.floats = table.values;
    kernels::DvrSettings s = {};
    s.table_size = transfer_size;
    s.low = table.low;
    s.scale = table.scale;
    const kernels::SceneView view = scene.view();
    const auto expected = [&](double value) {
        std::size_t i = 1;
        while (i + 1 < points.size() && points[i].value < value) ++i;
        const double u = std::clamp((value - points[i - 1].value) / (points[i].value - points[i - 1].value), 0.0, 1.0);
        const double opacity = (1 - u) * points[i - 1].opacity + u * points[i].opacity;
        const double extinction = -2 * std::log(1 - opacity) / 0.5;
        return glm::dvec4(glm::mix(glm::dvec3(points[i - 1].color), glm::dvec3(points[i].color), u) * extinction,
                          extinction);
    };
    for (double value = -1300; value < 1900; value += 7.3) {
        const vec4 got = kernels::transfer_at(view, s, kernels::transfer_place(s, float(value)));
        for (int k = 0; k < 4; ++k) EXPECT_NEAR(double(got[k]), expected(value)[k], 0.02) << value;
    }
    for (double from = -1100; from < 1500; from += 61)
        for (const double to : {from + 11, from + 150, from + 900, from - 333}) {
            glm::dvec4 mean(0);
            const int count = 4000;
            for (int i = 0; i < count; ++i) mean += expected(from + (to - from) * (i + 0.5) / count) / double(count);
            const vec4 got = kernels::transfer_between(view, s, kernels::transfer_place(s, float(from)),
                                                       kernels::transfer_place(s, float(to)));
            if (std::min(from, to) < -1000 || std::max(from, to) > 1500) continue;  // moved to the table's ends
            for (int k = 0; k < 4; ++k) EXPECT_NEAR(double(got[k]), mean[k], 0.02) << from << " " << to;
        }
}

// Of each preset of CT: what it shows of air, fat, water and compact bone, a layer of a voxel.
TEST(Transfer, presets_of_ct_tell_tissues_apart) {
    using Preset = DvrOptions::Preset;
    const auto opacity = [](Preset preset, float hounsfield) {
        DvrOptions o;
        o.preset = preset;
        const std::vector<TransferPoint> points = transfer_points(o, 0, 1);
        if (hounsfield <= points.front().value) return points.front().opacity;
        for (std::size_t i = 1; i < points.size(); ++i)
            if (hounsfield < points[i].value)
                return glm::mix(points[i - 1].opacity, points[i].opacity,
                                (hounsfield - points[i - 1].value) / (points[i].value - points[i - 1].value));
        return points.back().opacity;
    };
    constexpr float air = -1000, lung = -600, fat = -90, muscle = 50, contrast = 330, bone = 1200;
    for (const Preset preset :
         {Preset::ct_bone, Preset::ct_skin, Preset::ct_muscle, Preset::ct_lung, Preset::ct_angio, Preset::ct_xray}) {
        EXPECT_EQ(opacity(preset, air), 0);
        EXPECT_GT(opacity(preset, bone), 0.04f);
    }
    EXPECT_EQ(opacity(Preset::ct_bone, muscle), 0);
    EXPECT_GT(opacity(Preset::ct_bone, bone), 0.8f);
    EXPECT_GT(opacity(Preset::ct_skin, fat), 0.6f);
    EXPECT_GT(opacity(Preset::ct_muscle, muscle), 10 * opacity(Preset::ct_muscle, fat));
    EXPECT_GT(opacity(Preset::ct_lung, lung), 0.05f);
    EXPECT_LT(opacity(Preset::ct_lung, muscle), 0.005f);
    EXPECT_GT(opacity(Preset::ct_angio, contrast), 0.4f);
    EXPECT_EQ(opacity(Preset::ct_angio, muscle), 0);
    EXPECT_LT(opacity(Preset::ct_xray, bone), 0.06f);
}

// Colours of the maps at the ends of the window, as their authors publish them (sRGB of 8 bits), and rising brightness
// of those that are made for it.
TEST(Transfer, colour_maps_are_those_of_their_names) {
    using Map = DvrOptions::ColorMap;
    const auto at = [](Map map, float x) {
        DvrOptions o;
        o.color_map = map;
        o.level = 5, o.width = 10;
        const std::vector<TransferPoint> points = transfer_points(o, 0, 1);
        vec3 color = points.front().color;
        for (std::size_t i = 1; i < points.size(); ++i)
            if (10 * x >= points[i].value) color = points[i].color;
        return color;
    };
    const auto srgb = [](vec3 c) {
        vec3 out;
        for (int k = 0; k < 3; ++k)
            out[k] = 255 * (c[k] <= 0.0031308f ? 12.92f * c[k] : 1.055f * std::pow(c[k], 1 / 2.4f) - 0.055f);
        return out;
    };
    struct Row {
        Map map;
        vec3 first, last;
    };
    for (const Row& row : {Row{Map::grey, {0, 0, 0}, {255, 255, 255}}, Row{Map::viridis, {68, 1, 84}, {253, 231, 37}},
                           Row{Map::inferno, {0, 0, 4}, {252, 255, 164}}, Row{Map::hot, {0, 0, 0}, {255, 255, 255}},
                           Row{Map::cool_warm, {59, 76, 192}, {180, 4, 38}}})
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(srgb(at(row.map, 0))[k], row.first[k], 1.5) << int(row.map);
            EXPECT_NEAR(srgb(at(row.map, 1))[k], row.last[k], 1.5) << int(row.map);
        }
    for (const Map map : {Map::grey, Map::viridis, Map::inferno, Map::hot}) {
        float before = -1;
        for (float x = 0; x <= 1; x += 0.1f) {
            const vec3 c = at(map, x + 0.001f);
            const float luminance = 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
            EXPECT_GE(luminance, before) << int(map) << " " << x;
            before = luminance;
        }
    }
}

}  // namespace
}  // namespace spinel::dvr_test
