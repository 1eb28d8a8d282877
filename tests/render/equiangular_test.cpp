// Places next to lamps: sampled with the density that is said, and without a change of what a picture means.

#include "kernels/equiangular.h"

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>
#include <random>

#include "render/pictures.h"

namespace spinel::equiangular_test {
namespace {

using namespace test;

TEST(Equiangular, samples_its_density_near_and_far_and_on_the_ray) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const kernels::vec3 light : {kernels::vec3(0.3f, 0, 2), kernels::vec3(0, 40, -30), kernels::vec3(0, 1e-3f, 1),
                                      kernels::vec3(0, 0, 1.5f), kernels::vec3(0, 2, 0)})
        for (const float end : {0.5f, 3.0f, 1e4f, kernels::INFINITE}) {
            const kernels::Equiangular e = kernels::equiangular_begin(kernels::vec3(0), {0, 0, 1}, end, light);
            const double beside = double(e.beside), along = double(light.z), last = std::min(double(end), 1e15);
            // The density's integral up to t is the number that t was sampled from.
            const auto below = [&](double t) {
                return std::atan2(beside * t, beside * beside - along * (t - along)) /
                       std::atan2(beside * last, beside * beside - along * (last - along));
            };
            double before = -1;
            for (int i = 0; i < 200; ++i) {
                const double u = (i + unit(random)) / 200;
                const float t = kernels::equiangular_sample(e, float(u));
                ASSERT_GE(t, before);
                ASSERT_LE(t, end * 1.0001f);
                EXPECT_NEAR(below(double(t)), u, 2e-4 + 2e-7 * std::abs(along) / beside)
                    << "light at " << light.x << " " << light.y << " " << light.z;
                const double step = 1e-4 * (beside + std::abs(double(t) - along));
                const double slope = (below(double(t) + step) - below(double(t) - step)) / (2 * step);
                if (double(t) > 2 * step && beside > 1e-4) {
                    EXPECT_NEAR(double(kernels::equiangular_pdf(e, t)) / slope, 1, 2e-3) << t;
                }
                before = double(t);
            }
        }
}

// The lamps stand a little outside of the media: within, distance sampling alone would take for ever to agree.
std::string lamp_scene(bool equiangular, const std::string& contents, int max_bounces) {
    return fmt::format(
        R"({{"version": 1, "film": {{"size": [24, 24], "filter": "box", "filter_radius": 0.5}},
        "integrator": {{"max_bounces": {}, "equiangular": {}}},
        "camera": {{"from": [0.2, 0.4, 3.4], "at": [0, 0, 0], "fov": 44}},
        "lights": [{{"type": "point", "position": [0.3, 0.6, 1.8], "intensity": [1, 2, 3]}},
                   {{"type": "spot", "position": [-1, 1.9, 0.2], "direction": [0.6, -1, 0], "intensity": 9,
                     "inner_angle": 12, "outer_angle": 20}},
                   {{"type": "directional", "direction": [1, -1, -1], "irradiance": 0.3}}],
        "materials": {{"stone": {{"type": "diffuse", "color": [0.7, 0.6, 0.5]}}, 
                      "lamp": {{"type": "diffuse", "color": 0, "emission": 2}}}},
        {}}})",
        max_bounces, equiangular, contents);
}
std::string box_of(const char* medium) {
    return fmt::format(
        R"("objects": [{{"geometry": {{"type": "box", "size": [3, 3, 3]}}, "material": null, "interior": "{}"}},
        {{"geometry": {{"type": "box", "size": [0.7, 0.7, 0.7]}}, "material": "stone", "transform": [{{"rotate": {{"axis": [0, 1, 0], "degrees": 30}}}}]}},
        {{"geometry": {{"type": "sphere", "radius": 0.2}}, "material": "lamp", "transform": [{{"translate": [-0.8, -0.5, 0.5]}}]}}])",
        medium);
}
std::string uneven_grid() {
    std::string list;
    for (int i = 0; i < 216; ++i)
        list += (i ? "," : "") + fmt::format("{}", ((i * 104729) % 97) / 60.0 * ((i * 31) % 5 > 0));
    return R"("geometries": {"grid": {"type": "volume", "size": [6, 6, 6], "values": [)" + list +
           R"(], "transform": [{"translate": [-3, -3, -3]}, {"scale": 0.5}]}}, )";
}

// Means with and without, within three standard errors, of which there are few enough to tell.
void expect_no_change(const std::string& contents, int max_bounces, int spp, const char* estimator = "ratio") {
    const auto picture = [&](bool on, std::uint32_t first_seed) {
        std::string text = lamp_scene(on, contents, max_bounces);
        text.insert(text.find("\"max_bounces\""), fmt::format("\"transmittance\": \"{}\", ", estimator));
        return render_text(text, on ? spp : 2 * spp, 32, first_seed).mean();
    };
    const Estimate without = picture(false, 1), with = picture(true, 101);
    for (int k = 0; k < 3; ++k) {
        const double error = std::hypot(without.error[k], with.error[k]);
        EXPECT_NEAR(with.mean[k], without.mean[k], milder * 3 * error) << estimator << ", channel " << k;
        EXPECT_LT(error, more_noise * 0.02 * without.mean[k]);
    }
}

TEST(Equiangular, changes_nothing_but_noise_in_even_fog) {
    expect_no_change(R"("media": {"m": {"scattering": [0.3, 0.3, 0.3], "absorption": 0.1, "g": 0.5}}, )" + box_of("m"),
                     1, 24);
    expect_no_change(
        R"("media": {"m": {"scattering": [0.6, 0.3, 0.1], "absorption": [0, 0.1, 0.3], "g": -0.3}}, )" + box_of("m"),
        -1, 24);
}
TEST(EquiangularSlow, changes_nothing_but_noise_in_clouds) {
    for (const char* estimator : {"ratio", "residual", "delta"})
        for (const char* medium : {R"("scattering": 0.7, "absorption": 0.1, "g": 0.4)",
                                   R"("scattering": [0.9, 0.4, 0.1], "absorption": [0, 0.1, 0.3])"})
            expect_no_change(uneven_grid() + R"("media": {"m": {"density": "grid", )" + medium + "}}, " + box_of("m"),
                             3, 16, estimator);
}
TEST(EquiangularSlow, changes_nothing_but_noise_where_media_overlap) {
    expect_no_change(
        uneven_grid() +
            R"("media": {"m": {"density": "grid", "scattering": [0.9, 0.4, 0.1], "g": 0.6}, "haze": {"scattering": [0.1, 0.2, 0.4], "absorption": 0.05}},
        "objects": [{"geometry": "grid", "interior": "m"},
        {"geometry": {"type": "sphere", "radius": 1.3}, "material": null, "interior": "haze"}])",
        2, 64);
}

// One line of sight past a lamp: by quadrature, within three standard errors, where distance sampling alone is far off
// that precision.
TEST(Equiangular, light_next_to_a_lamp_is_its_integral) {
    const double sigma = 0.05, beside = 0.02;
    const auto text = [&](bool on) {
        return fmt::format(
            R"({{"version": 1, "film": {{"size": [2, 2], "filter": "box", "filter_radius": 0.5}},
            "integrator": {{"max_bounces": 1, "equiangular": {}}},
            "camera": {{"type": "orthographic", "from": [0, 0, 3], "at": [0, 0, 0], "height": 1e-5}},
            "lights": [{{"type": "point", "position": [0, {}, 0.3], "intensity": 1}}],
            "media": {{"m": {{"scattering": {}}}}},
            "objects": [{{"geometry": {{"type": "sphere", "radius": 2}}, "material": null, "interior": "m"}}]}})",
            on, beside, sigma);
    };
    double expected = 0;  // over the angle, in which the integrand is smooth
    const double first = std::atan((-2 - 0.3) / beside), last = std::atan((2 - 0.3) / beside);
    constexpr int steps = 20000;
    for (int i = 0; i <= steps; ++i) {
        const double theta = first + (last - first) * i / steps, s = beside * std::tan(theta), z = 0.3 + s;
        const double weight = i == 0 || i == steps ? 1 : i % 2 ? 4 : 2;
        expected += weight * std::exp(-sigma * ((2 - z) + beside / std::cos(theta))) * sigma / (4 * M_PI * beside);
    }
    expected *= (last - first) / steps / 3;
    const Estimate with = render_text(text(true), 256, 32).mean(), without = render_text(text(false), 256, 32).mean();
    expect_mean(with, dvec3(expected), 3, 0.002);
    EXPECT_LT(with.error.x, 0.1 * without.error.x);
}

}  // namespace
}  // namespace spinel::equiangular_test
