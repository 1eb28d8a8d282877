// `dvr` against sums from back to front, against closed forms, and the device's packets against the kernel.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <unistd.h>
#include <cmath>

#include <filesystem>
#include <fstream>

#include "image/metrics.h"
#include "kernels/camera.h"
#include "kernels/dvr.h"
#include "kernels/traverse.h"
#include "render/pictures.h"
#include "scene/transfer.h"

namespace spinel {
namespace {

using namespace test;

// A volume of `edge`³ samples in a file of its own.
class Dvr : public ::testing::Test {
  protected:
    Dvr()
        : file_(std::filesystem::temp_directory_path() /
                fmt::format("spinel_dvr_{}_{}.svol", getpid(),
                            ::testing::UnitTest::GetInstance()->current_test_info()->name())) {}
    ~Dvr() override { std::filesystem::remove(file_); }

    template <class Value>
    void write(int edge, const Value& value) {
        std::ofstream out(file_, std::ios::binary);
        out << fmt::format("spinel volume 1\nsize {0} {0} {0}\ntype f32\nspacing {1} {1} {1}\n\n", edge, 1.0 / edge);
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y)
                for (int x = 0; x < edge; ++x) {
                    const float v = value(x, y, z);
                    out.write(reinterpret_cast<const char*>(&v), sizeof v);
                }
    }

    // The unit cube seen from `from`, or along −z without perspective.
    std::string scene(const std::string& dvr, const std::string& camera, int pixels,
                      const std::string& more = "") const {
        return fmt::format(R"json({{"version": 1, "camera": {{{}}}, "film": {{"size": [{}, {}], "filter": "box",
          "filter_radius": 0.5}}, "integrator": {{"type": "dvr", "dvr": {{{}}}}},
          "media": {{"m": {{"scattering": 1, "density": "v"}}}},
          "materials": {{"grey": {{"type": "diffuse"}}}}, "geometries": {{"v": {{"type": "volume", "file": "{}"}}}},
          "objects": [{}{{"geometry": "v", "interior": "m"}}]}})json",
                           camera, pixels, pixels, dvr, file_.string(), more);
    }

    std::filesystem::path file_;
};

constexpr const char* straight =
    R"("type": "orthographic", "from": [0.5, 0.5, 3], "at": [0.5, 0.5, 0], "height": 0.01)";
constexpr const char* oblique = R"("from": [1.9, 1.5, 2.4], "at": [0.5, 0.5, 0.5], "fov": 30)";

float ball(int x, int y, int z) {
    const float r = glm::length(vec3(float(x), float(y), float(z)) - 15.5f);
    return std::max(0.0f, 100 - 6 * r) + 3 * std::sin(0.9f * float(x)) * std::sin(0.7f * float(y)) + 3;
}

constexpr const char* layers = R"("points": [{"value": 20, "color": [1, 0.2, 0.1], "opacity": 0},
    {"value": 40, "color": [1, 0.5, 0.1], "opacity": 0.15}, {"value": 60, "color": [0.2, 0.6, 1], "opacity": 0.01},
    {"value": 90, "color": [1, 1, 1], "opacity": 0.6}])";

// Samples at the same depths as the kernel's, summed from the far end.
vec3 back_to_front(const kernels::SceneView& view, const kernels::DvrSettings& s, const kernels::Ray& ray) {
    const kernels::DvrSpan span = kernels::dvr_span(view, s, ray, kernels::INFINITE);
    const kernels::Medium& m = view.media.at[s.medium];
    vec3 color = s.background;
    if (!(span.begin < span.end)) return color;
    const auto first = int(std::ceil(span.begin / s.step)), last = int(std::floor(span.end / s.step));
    const auto place = [&](float t) {
        return kernels::transfer_place(s, kernels::dvr_value(view, m, span.origin + t * span.direction));
    };
    for (int k = last; k > first; --k) {
        const float t0 = float(k - 1) * s.step, t1 = float(k) * s.step;
        const vec4 mean = kernels::transfer_between(view, s, place(t0), place(t1));
        const float opacity = 1 - std::exp(-mean.w * s.step);
        if (!(opacity > 0)) continue;
        vec3 gradient(0);
        const vec3 lit = kernels::dvr_lit(view, s, m, span.origin + 0.5f * (t0 + t1) * span.direction, ray.direction,
                                          vec3(mean) / mean.w, gradient);
        color = opacity * lit + (1 - opacity) * color;
    }
    return color;
}

TEST_F(Dvr, front_to_back_is_back_to_front) {
    write(32, ball);
    for (const char* shortcuts : {"true", "false"}) {
        const Result<CompiledScene> compiled = compile_text(scene(
            fmt::format("{}, \"shortcuts\": {}, \"background\": [0.1, 0.2, 0.3]", layers, shortcuts), oblique, 24));
        ASSERT_TRUE(compiled) << compiled.error().message;
        const TestPicture p = render_scene(*compiled, 1, 2, 7);
        const kernels::SceneView view = compiled->view();
        double worst = 0;
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 24; ++x) {
                // The ray of the first batch's only sample.
                kernels::Sampler numbers = kernels::make_sampler({x, y}, 0, 7);
                const vec2 u_film = kernels::sampler_2d(numbers), u_lens = kernels::sampler_2d(numbers);
                const vec3 expected =
                    back_to_front(view, compiled->dvr, kernels::camera_ray(view.camera, {x, y}, u_film, u_lens));
                const dvec3 got = p.batches[0][std::size_t(y * 24 + x)];
                for (int k = 0; k < 3; ++k) worst = std::max(worst, std::abs(got[k] - double(expected[k])));
            }
        EXPECT_LT(worst, 0.006) << shortcuts;  // early termination, faint steps, 16 bits
    }
}

TEST_F(Dvr, packets_show_what_the_kernel_shows) {
    write(32, ball);
    const char* cases[] = {
        "",
        R"(, "light": "scene", "specular": 0.6)",
        R"(, "shaded": false, "step": 0.5)",
        R"(, "step": 2.5, "jitter": true)",
        R"(, "clip_lower": [0.2, 0, 0], "clip_upper": [1, 0.7, 0.9], "clip_planes": [[0, 0.6, 0.8, 0.75]])",
        R"(, "color_map": "viridis", "opacity": 3)",
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

}  // namespace
}  // namespace spinel
