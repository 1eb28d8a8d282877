// Participating media against closed forms and numeric integrals.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>
#include <functional>

#include "geometry/sphere_mesh.h"
#include "kernels/phase.h"
#include "render/pictures.h"

namespace spinel::media_test {
namespace {

using namespace test;

// Looks along one line with no width to speak of, at whatever `contents` says; the box filter keeps it there.
std::string line_of_sight(vec3 from, vec3 at, int max_bounces, const std::string& contents, int pixels = 4) {
    return fmt::format(
        R"({{"version": 1, "film": {{"size": [{0}, {0}], "filter": "box", "filter_radius": 0.5}},
        "integrator": {{"max_bounces": {1}}},
        "camera": {{"type": "orthographic", "from": [{2}, {3}, {4}], "at": [{5}, {6}, {7}], "up": [0.1, 1, 0.2], "height": 1e-4}},
        {8}}})",
        pixels, max_bounces, from.x, from.y, from.z, at.x, at.y, at.z, contents);
}
const std::string white_sky = R"("environment": {"type": "constant", "radiance": 1}, )";
std::string ball(const std::string& medium, double radius = 1) {
    return fmt::format(
        R"("media": {{"m": {{{}}}}}, "objects": [{{"geometry": {{"type": "sphere", "radius": {}}}, "material": null,
        "interior": "m"}}])",
        medium, radius);
}
double simpson(const std::function<double(double)>& f, double a, double b, int n = 2000) {
    double sum = f(a) + f(b);
    for (int i = 1; i < n; ++i) sum += f(a + (b - a) * i / n) * (i % 2 ? 4 : 2);
    return sum * (b - a) / (3 * n);
}
dvec3 per_channel(const std::function<double(int)>& f) { return {f(0), f(1), f(2)}; }

// ---------------------------------------------------------------------------------------------------
// transmittance
TEST(Media, absorption_follows_beer_and_lambert_without_noise) {
    const TestPicture p =
        render_text(line_of_sight({0, 0.5f, 3}, {0, 0.5f, 0}, -1, white_sky + ball(R"("absorption": [0.3, 1, 4])")), 4);
    const double d = std::sqrt(3.0);
    for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(p.mean().mean[k], std::exp(-dvec3(0.3, 1, 4)[k] * d),
                    3e-5 * std::exp(-dvec3(0.3, 1, 4)[k] * d) + 1e-7);
}

TEST(Media, what_is_not_scattered_passes_as_beer_and_lambert_say) {
    const TestPicture p =
        render_text(line_of_sight({0, 0, 3}, {0, 0, 0}, 0,
                                  white_sky + ball(R"("absorption": [0.1, 0.2, 0], "scattering": [0.2, 0.5, 1.5])")),
                    2048);
    expect_mean(p.mean(), {std::exp(-0.6), std::exp(-1.4), std::exp(-3.0)}, 4, 0.02);
}

TEST(Media, the_camera_may_stand_in_a_medium) {
    const TestPicture absorbing =
        render_text(line_of_sight({0.3f, 0, 0}, {1, 0, 0}, -1, white_sky + ball(R"("absorption": [0.3, 1, 4])")), 4);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(absorbing.mean().mean[k], std::exp(-dvec3(0.3, 1, 4)[k] * 0.7), 3e-5);
    const TestPicture scattering =
        render_text(line_of_sight({0.3f, 0, 0}, {1, 0, 0}, 0, white_sky + ball(R"("scattering": [0.3, 1, 2])")), 1024);
    expect_mean(scattering.mean(), {std::exp(-0.21), std::exp(-0.7), std::exp(-1.4)}, 4, 0.02);
}

// A small grid of irregular values and its trilinear interpolant, written anew here: sample i at i + ½,
// clamped at the faces.
const int n = 5;
std::vector<float> irregular_values() {
    std::vector<float> values;
    for (int i = 0; i < n * n * n; ++i) values.push_back(float((i * 7919) % 11 < 4 ? 0 : ((i * 104729) % 97) / 40.0));
    return values;
}
double trilinear(const std::vector<float>& values, dvec3 p) {
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
        double weight = 1;
        int index[3];
        for (int a = 0; a < 3; ++a) {
            const double q = p[a] - 0.5, base = std::floor(q);
            const int bit = (c >> a) & 1;
            weight *= bit ? q - base : 1 - (q - base);
            index[a] = std::clamp(int(base) + bit, 0, n - 1);
        }
        sum += weight * double(values[std::size_t(index[0] + n * (index[1] + n * index[2]))]);
    }
    return sum;
}
std::string cloud(const std::string& medium, const std::vector<float>& values, const std::string& rest = "") {
    std::string list;
    for (const float v : values) list += (list.empty() ? "" : ",") + fmt::format("{}", v);
    return fmt::format(
        R"("geometries": {{"grid": {{"type": "volume", "size": [{0}, {0}, {0}], "values": [{1}]}}}},
        "media": {{"m": {{"density": "grid", {2}}}}}, "objects": [{{"geometry": "grid", "interior": "m"}}{3}])",
        n, list, medium, rest);
}

TEST(Media, a_trilinear_grid_transmits_as_its_integral_says) {
    const std::vector<float> values = irregular_values();
    const dvec3 sigma(0.1, 0.3, 0.6);
    for (const vec3 at : {vec3(2.5f, 2.5f, 2.5f), vec3(1.1f, 3.2f, 4.4f)}) {
        const vec3 from(9, 7.3f, -6);
        const dvec3 d = glm::normalize(dvec3(at) - dvec3(from));
        double enter = 0, leave = 1e9;
        for (int a = 0; a < 3; ++a) {
            const double t0 = -double(from[a]) / d[a], t1 = (n - double(from[a])) / d[a];
            enter = std::max(enter, std::min(t0, t1));
            leave = std::min(leave, std::max(t0, t1));
        }
        ASSERT_LT(enter, leave);
        const double depth = simpson([&](double t) { return trilinear(values, dvec3(from) + t * d); }, enter + 1e-9,
                                     leave - 1e-9, 20000);
        const dvec3 expected = per_channel([&](int k) { return std::exp(-sigma[k] * depth); });
        expect_mean(
            render_text(line_of_sight(from, at, 0, white_sky + cloud(R"("absorption": [0.1, 0.3, 0.6])", values)), 1024)
                .mean(),
            expected, 4, 0.03);
        expect_mean(
            render_text(line_of_sight(from, at, 0, white_sky + cloud(R"("scattering": [0.1, 0.3, 0.6])", values)), 1024)
                .mean(),
            expected, 4, 0.03);
    }
}

TEST(Media, shadows_through_media_are_their_transmittance) {
    // A sun straight above a plane; the eye looks in below the medium.
    const std::string sun =
        R"("lights": [{"type": "directional", "direction": [0, -1, 0], "irradiance": 3.14159265}],
        "materials": {"floor": {"type": "diffuse", "color": 0.5}}, )";
    const std::string floor =
        R"({"geometry": {"type": "plane"}, "material": "floor", "transform": [{"translate": [0, -1, 0]}]})";
    const vec3 from(1.1f + 3, -0.5f, 2.3f), at(1.1f, -1, 2.3f);
    const TestPicture slab = render_text(
        line_of_sight(
            from, at, 1,
            sun + R"("media": {"m": {"scattering": [0.3, 0.1, 0], "absorption": [0, 0.4, 1]}}, "objects": [)" + floor +
                R"(, {"geometry": {"type": "box", "size": [9, 2, 9]}, "material": null, "interior": "m",
            "transform": [{"translate": [0, 3, 0]}]}])"),
        16);
    expect_mean(slab.mean(), 0.5 * dvec3(std::exp(-0.6), std::exp(-1.0), std::exp(-2.0)), 4, 1e-3);
    const std::vector<float> values = irregular_values();
    const double depth = simpson(
        [&](double y) {
            return trilinear(values, {double(at.x), y, double(at.z)});
        },
        0, n, 20000);
    const dvec3 sigma(0.3, 0.6, 1);
    expect_mean(render_text(line_of_sight(from, at, 1,
                                          sun + cloud(R"("scattering": [0.1, 0.6, 0.5], "absorption": [0.2, 0, 0.5])",
                                                      values, ", " + floor)),
                            16384)
                    .mean(),
                per_channel([&](int k) { return 0.5 * std::exp(-sigma[k] * depth); }), 4, 0.03);
}

// ------------------------------------------------------------------------------------------------ single
// scattering
TEST(Media, single_scattering_of_a_point_light_equals_its_integral) {
    const dvec3 scattering(0.4, 0.8, 1.6), extinction = scattering + dvec3(0.3, 0, 0.1);
    const dvec3 lamp(0.2, 0.5, -0.1);
    for (const double g : {0.0, 0.7, -0.4}) {
        const TestPicture p = render_text(
            line_of_sight(
                {0, 0, 3}, {0, 0, 0}, 1,
                R"("lights": [{"type": "point", "position": [0.2, 0.5, -0.1], "intensity": 4}], )" +
                    ball(fmt::format(R"("scattering": [0.4, 0.8, 1.6], "absorption": [0.3, 0, 0.1], "g": {})", g))),
            2048);
        expect_mean(p.mean(), per_channel([&](int k) {
                        return simpson(
                            [&](double t) {
                                const dvec3 x(0, 0, 1 - t), to = lamp - x;
                                const double d = glm::length(to), cosine = to.z / d * -1;
                                const double phase =
                                    (1 - g * g) / (4 * M_PI * std::pow(1 + g * g - 2 * g * cosine, 1.5));
                                return scattering[k] * std::exp(-extinction[k] * (t + d)) * phase * 4 / (d * d);
                            },
                            0, 2);
                    }),
                    4, 0.01);
    }
}

TEST(Media, overlapping_media_scatter_each_with_its_own_phase_function_and_colour) {
    // Forward-scattering red smoke in backward-scattering blue: the sun's light turned by 60°.
    const std::string text =
        line_of_sight({0, 0, 3}, {0, 0, 0}, 1,
                      R"("lights": [{"type": "directional", "direction": [0.8660254, 0, 0.5], "irradiance": 4}],
           "media": {"a": {"scattering": [0.9, 0.3, 0.1], "g": 0.6}, "b": {"scattering": [0.1, 0.2, 0.7], "absorption": 0.1, "g": -0.5}},
           "objects": [{"geometry": {"type": "sphere"}, "material": null, "interior": "a"},
                       {"geometry": {"type": "box", "size": [2.5, 2.5, 2.5]}, "material": null, "interior": "b"}])");
    const dvec3 a(0.9, 0.3, 0.1), b(0.1, 0.2, 0.7);
    const auto phase = [](double g) { return (1 - g * g) / (4 * M_PI * std::pow(1 + g * g - 2 * g * 0.5, 1.5)); };
    const dvec3 to_sun(-std::sqrt(0.75), 0, -0.5);
    const auto in_box = [&](dvec3 x) { return std::min((x.x + 1.25) / -to_sun.x, (x.z + 1.25) / -to_sun.z); };
    const auto in_ball = [&](dvec3 x) {
        const double h = glm::dot(x, to_sun), c = glm::dot(x, x) - 1;
        return c < 0 ? -h + std::sqrt(h * h - c) : h < 0 && h * h > c ? 2 * std::sqrt(h * h - c) : 0.0;
    };
    const dvec3 expected = per_channel([&](int k) {
        return simpson(
            [&](double t) {
                const dvec3 x(0, 0, 1.25 - t);
                const bool inside = std::abs(x.z) < 1;
                const double before = b[k] + 0.1,
                             depth = before * (t + in_box(x)) + a[k] * (std::clamp(t - 0.25, 0.0, 2.0) + in_ball(x));
                return 4 * std::exp(-depth) * (b[k] * phase(-0.5) + (inside ? a[k] * phase(0.6) : 0));
            },
            0, 2.5, 40000);
    });
    expect_mean(render_text(text, 4096).mean(), expected, 4, 0.01);
}

// --------------------------------------------------------------------------------------------------------
// emission
TEST(Media, a_glowing_medium_gives_its_emission_less_what_it_absorbs) {
    expect_mean(
        render_text(
            line_of_sight({0, 0, 3}, {0, 0, 0}, -1, ball(R"("emission": [3, 2, 1], "absorption": [0.5, 1, 3])")), 1024)
            .mean(),
        {6 * (1 - std::exp(-1.0)), 2 * (1 - std::exp(-2.0)), (1 - std::exp(-6.0)) / 3}, 4, 0.01);
}

TEST(Media, a_glowing_medium_that_does_not_absorb_glows_in_proportion_to_its_depth) {
    expect_mean(render_text(line_of_sight({0, 0, 3}, {0, 0, 0}, -1, ball(R"("emission": [3, 2, 1])")), 1024).mean(),
                {6, 4, 2}, 4, 0.01);
    // In one channel only; and with little absorption in all.
    expect_mean(
        render_text(line_of_sight({0, 0, 3}, {0, 0, 0}, -1, ball(R"("emission": 1, "absorption": [0.5, 0, 0])")), 1024)
            .mean(),
        {2 * (1 - std::exp(-1.0)), 2, 2}, 4, 0.02);
    const std::vector<float> values = irregular_values();
    const double depth = simpson([&](double z) { return trilinear(values, {1.1, 3.2, z}); }, 0, n, 20000);
    expect_mean(
        render_text(line_of_sight({1.1f, 3.2f, 9}, {1.1f, 3.2f, 0}, -1, cloud(R"("emission": [3, 2, 1])", values)),
                    1024)
            .mean(),
        dvec3(3, 2, 1) * depth, 4, 0.01);
}

TEST(Media, a_glow_behind_smoke_is_dimmed_by_it) {
    // A glowing ball in a bigger absorbing one: emission and absorption overlap.
    expect_mean(
        render_text(
            line_of_sight(
                {0, 0, 3}, {0, 0, 0}, -1,
                R"("media": {"glow": {"emission": 2, "absorption": 0.5}, "smoke": {"absorption": [0.2, 0.5, 1]}},
        "objects": [{"geometry": {"type": "sphere", "radius": 0.5}, "material": null, "interior": "glow"},
                    {"geometry": {"type": "sphere", "radius": 1}, "material": null, "interior": "smoke"}])"),
            1024)
            .mean(),
        per_channel([&](int k) {
            const double s = dvec3(0.2, 0.5, 1)[k], a = s + 0.5;
            return std::exp(-0.5 * s) * 2 / a * (1 - std::exp(-a));
        }),
        4, 0.01);
}

// ------------------------------------------------------------------------------------------- two ways to the
// same
std::string stage(const std::string& definitions, const std::string& things, int size = 32) {
    return fmt::format(
        R"({{"version": 1, "film": {{"size": [{0}, {0}], "filter": "box", "filter_radius": 0.5}},
        "camera": {{"from": [1, 1.4, 3.6], "at": [0, 0, 0], "fov": 42}},
        "environment": {{"type": "constant", "radiance": [0.3, 0.4, 0.5]}},
        "lights": [{{"type": "directional", "direction": [-1, -2, -0.5], "irradiance": 3, "angular_radius": 4}}],
        "materials": {{"floor": {{"type": "diffuse", "color": [0.7, 0.6, 0.5]}}}}, {1},
        "objects": [{{"geometry": {{"type": "plane"}}, "material": "floor", "transform": [{{"translate": [0, -1, 0]}}]}}, {2}]}})",
        size, definitions, things);
}
const std::string smoke = R"("scattering": [2, 1.2, 0.6], "absorption": [0.1, 0.3, 0.2], "g": 0.4)";

TEST(Media, a_constant_grid_equals_the_homogeneous_medium) {
    const TestPicture homogeneous = render_text(
        stage("\"media\": {\"m\": {" + smoke + "}}",
              R"({"geometry": {"type": "box", "size": [1.6, 1.6, 1.6]}, "material": null, "interior": "m"})"),
        24);
    std::string ones;
    for (int i = 0; i < 6 * 5 * 4; ++i) ones += i ? ",2" : "2";
    const TestPicture grid =
        render_text(stage(R"("geometries": {"grid": {"type": "volume", "size": [6, 5, 4], "values": [)" + ones +
                              R"(], "transform": [{"translate": [-3, -2.5, -2]}, {"scale": [0.26666667, 0.32, 0.4]}]}},
        "media": {"m": {"density": "grid", "scattering": [1, 0.6, 0.3], "absorption": [0.05, 0.15, 0.1], "g": 0.4}})",
                          R"({"geometry": "grid", "interior": "m"})"),
                    24);
    expect_same(homogeneous, grid);
}

TEST(Media, overlapping_volumes_equal_the_sum_of_their_coefficients) {
    const auto box = [](const char* size, const char* medium) {
        return fmt::format(
            R"({{"geometry": {{"type": "box", "size": [{0}, {0}, {0}]}}, "material": null, "interior": "{1}"}})", size,
            medium);
    };
    const TestPicture one = render_text(stage("\"media\": {\"m\": {" + smoke + "}}", box("1.6", "m")), 24);
    const TestPicture three = render_text(stage(R"("media": {"a": {"scattering": [1.5, 0.2, 0], "g": 0.4},
        "b": {"scattering": [0.5, 1, 0.6], "absorption": [0, 0.2, 0.1], "g": 0.4}, "c": {"absorption": [0.1, 0.1, 0.1]}})",
                                                box("1.6", "a") + ", " + box("1.6", "b") + ", " + box("1.6", "c")),
                                          24);
    expect_same(one, three);
    const TestPicture twice =
        render_text(stage(R"("media": {"h": {"scattering": [1, 0.6, 0.3], "absorption": [0.05, 0.15, 0.1], "g": 0.4}})",
                          box("1.6", "h") + ", " + box("1.6", "h")),
                    24);
    expect_same(one, twice);
}

TEST(Media, a_medium_in_a_mesh_equals_the_medium_in_the_sphere) {
    const std::string media = "\"media\": {\"m\": {" + smoke + "}}";
    const auto in = [&](const std::string& geometry) {
        return stage(media, "{\"geometry\": " + geometry + R"(, "material": null, "interior": "m"})");
    };
    const TestPicture sphere = render_text(in(R"({"type": "sphere", "radius": 1})"), 24);
    Result<Scene> scene =
        read_scene_json(in(R"({"type": "mesh", "positions": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0,1,2]]})"),
                        "test.json", {load_model, read_pixels});
    ASSERT_TRUE(scene) << scene.error().message;
    for (Geometry& g : scene->geometries)
        if (auto* mesh = std::get_if<MeshGeometry>(&g.data)) *mesh = sphere_mesh(160);
    const Result<CompiledScene> compiled = compile(*scene);
    ASSERT_TRUE(compiled) << compiled.error().message;
    expect_same(sphere, render_scene(*compiled, 24));
    expect_same(sphere, render_text(in(R"x({"type": "sdf", "expression": "sphere(1)"})x"), 24));
}

// --------------------------------------------------------------------------------------------------------
// furnaces
TEST(Media, white_clouds_vanish_in_uniform_light) {
    const std::string bunny = SPINEL_SOURCE_DIR "/examples/bunny32.bits";
    for (const char* medium :
         {R"("scattering": 30, "g": 0.3, "erosion": {"type": "fbm", "strength": 1, "frequency": 14, "octaves": 4})",
          R"("scattering": [30, 12, 3], "g": -0.3, "erosion": {"type": "value", "strength": 1, "frequency": 9})",
          R"("scattering": [3, 0, 9], "g": 0.8)"}) {
        const TestPicture p =
            render_text(fmt::format(
                            R"({{"version": 1, "film": {{"size": [24, 24], "filter": "box", "filter_radius": 0.5}},
            "camera": {{"from": [0.6, 0.7, 2.4], "at": [0.5, 0.5, 0.5], "fov": 26}},
            "environment": {{"type": "constant", "radiance": 1}},
            "geometries": {{"bunny": {{"type": "volume", "file": "{}"}}}},
            "media": {{"white": {{"density": "bunny", {}}}}},
            "objects": [{{"geometry": "bunny", "interior": "white"}}]}})",
                            bunny, medium),
                        160);
        const Estimate e = p.mean();
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(e.mean[k], 1, std::min(more_noise * 0.005, 4.5 * e.error[k] + 1e-5))
                << medium << " channel " << k;
            EXPECT_LT(e.error[k], more_noise * 0.0025);
        }
    }
}

}  // namespace
}  // namespace spinel::media_test
