// Homogeneous slabs and balls, by themselves and cut out of grids, against closed forms: within three standard errors.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>

#include "render/pictures.h"

namespace spinel::slab_test {
namespace {

using namespace test;

constexpr int batches = 32;  // so that three standard errors are three
constexpr double sigmas = 3;
const char* const estimators[] = {"ratio", "residual", "delta"};

double henyey_greenstein(double g, double cosine) {
    return (1 - g * g) / (4 * M_PI * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

struct Coefficients {
    dvec3 scattering, absorption;
    double g;
    std::string text(double density = 1) const {
        const dvec3 s = scattering / density, a = absorption / density;
        return fmt::format(R"("scattering": [{}, {}, {}], "absorption": [{}, {}, {}], "g": {})", s.x, s.y, s.z, a.x,
                           a.y, a.z, g);
    }
};
const Coefficients media[] = {
    {{0.4, 0.8, 1.6}, {0.3, 0, 0.1}, 0}, {{0.9, 0.9, 0.9}, {0.1, 0.1, 0.1}, 0.7}, {{2, 1, 0.2}, {0, 0, 0.5}, -0.4}};

// One line of sight from `from` along `direction`. The medium fills `shape`: evenly, or as a grid of the density 2 that
// holds it.
std::string scene(dvec3 from, dvec3 direction, int max_bounces, const char* estimator, const Coefficients& c, bool grid,
                  const std::string& shape, const std::string& light) {
    const dvec3 at = from + direction;
    return fmt::format(
        R"({{"version": 1, "film": {{"size": [2, 2], "filter": "box", "filter_radius": 0.5}},
        "integrator": {{"max_bounces": {0}, "transmittance": "{1}"}},
        "camera": {{"type": "orthographic", "from": [{2}, {3}, {4}], "at": [{5}, {6}, {7}], "up": [0.1, 1, 0.2],
                    "height": 1e-4}},
        "geometries": {{"grid": {{"type": "volume", "size": [4, 4, 4], "values": [{8}],
                                "transform": [{{"scale": 60}}, {{"translate": [-2, -2, -2]}}]}}}},
        "media": {{"m": {{{9}{10}}}}},
        "objects": [{{"geometry": {11}, "material": null, "interior": "m"}}], {12}}})",
        max_bounces, estimator, from.x, from.y, from.z, at.x, at.y, at.z,
        [] {
            std::string twos = "2";
            for (int i = 1; i < 64; ++i) twos += ",2";
            return twos;
        }(),
        grid ? R"("density": "grid", )" : "", c.text(grid ? 2 : 1), shape, light);
}

// −1 ≤ y ≤ 1, and so wide that nobody finds its end.
const std::string slab = R"({"type": "box", "size": [100, 2, 100]})";
const std::string ball = R"({"type": "sphere", "radius": 1})";
const std::string sky = R"("environment": {"type": "constant", "radiance": 1})";

template <class Test>
void for_each_medium(const Test& test) {
    for (const Coefficients& c : media) {
        test(c, false, "ratio");
        for (const char* estimator : estimators) test(c, true, estimator);
    }
}

TEST(Slab, transmits_what_beer_and_lambert_say) {
    const dvec3 down = glm::normalize(dvec3(0.5, -1, 0.3));
    for_each_medium([&](const Coefficients& c, bool grid, const char* estimator) {
        const double way = 2 / -down.y;
        expect_mean(
            render_text(scene(-3.0 * down / -down.y, down, 0, estimator, c, grid, slab, sky), 256, batches).mean(),
            glm::exp(-(c.scattering + c.absorption) * way), sigmas, 0.05);
    });
}

// Sunlight scattered once: what comes back, and what goes through.
TEST(Slab, scatters_once_as_its_integral_says) {
    const dvec3 sun = glm::normalize(dvec3(-0.4, -1, 0.2));
    const std::string light = fmt::format(
        R"("lights": [{{"type": "directional", "direction": [{}, {}, {}], "irradiance": 4}}])", sun.x, sun.y, sun.z);
    for (const double side : {1.0, -1.0}) {
        const dvec3 eye = glm::normalize(dvec3(0.5, -side, 0.3));  // away from the camera
        const double mu_eye = std::abs(eye.y), mu_sun = -sun.y;
        for_each_medium([&](const Coefficients& c, bool grid, const char* estimator) {
            const dvec3 extinction = c.scattering + c.absorption;
            // Depth below the top at the way t: t·µ, or 2 − t·µ from below.
            const double rate = 1 + side * mu_eye / mu_sun, way = 2 / mu_eye;
            const dvec3 ahead = side > 0 ? dvec3(1) : glm::exp(-extinction * (2 / mu_sun));
            const dvec3 expected = 4 * henyey_greenstein(c.g, glm::dot(sun, -eye)) * c.scattering * ahead *
                                   (1.0 - glm::exp(-extinction * rate * way)) / (extinction * rate);
            expect_mean(
                render_text(scene(-3.0 * eye / mu_eye, eye, 1, estimator, c, grid, slab, light), 256, batches).mean(),
                expected, sigmas, 0.02);
        });
    }
}

TEST(Ball, transmits_what_beer_and_lambert_say) {
    for_each_medium([&](const Coefficients& c, bool grid, const char* estimator) {
        const double chord = 2 * std::sqrt(1 - 0.25);
        expect_mean(render_text(scene({0, 0.5, 3}, {0, 0, -1}, 0, estimator, c, grid, ball, sky), 256, batches).mean(),
                    glm::exp(-(c.scattering + c.absorption) * chord), sigmas, 0.05);
    });
}

TEST(Ball, scatters_once_as_its_integral_says) {
    const dvec3 sun = glm::normalize(dvec3(-0.4, -1, 0.2)), from(0, 0.5, 3);
    const std::string light = fmt::format(
        R"("lights": [{{"type": "directional", "direction": [{}, {}, {}], "irradiance": 4}}])", sun.x, sun.y, sun.z);
    const double half = std::sqrt(1 - 0.25);
    for_each_medium([&](const Coefficients& c, bool grid, const char* estimator) {
        const dvec3 extinction = c.scattering + c.absorption;
        dvec3 expected(0);
        constexpr int steps = 2000;  // Simpson
        for (int i = 0; i <= steps; ++i) {
            const double t = 2 * half * i / steps;
            const dvec3 x(0, 0.5, half - t);
            const double h = glm::dot(x, -sun), to_sun = -h + std::sqrt(std::max(h * h - glm::dot(x, x) + 1, 0.0));
            const double weight = i == 0 || i == steps ? 1 : i % 2 ? 4 : 2;
            expected += weight * glm::exp(-extinction * (t + to_sun));
        }
        expected *= 2 * half / steps / 3 * 4 * henyey_greenstein(c.g, sun.z) * c.scattering;
        expect_mean(render_text(scene(from, {0, 0, -1}, 1, estimator, c, grid, ball, light), 256, batches).mean(),
                    expected, sigmas, 0.02);
    });
}

// ------------------------------------------------------------------------------------------------------- furnaces
// White media in even light vanish, whatever they scatter and however often.
void expect_white(double depth, int spp) {
    for (const std::string& shape : {slab, ball})
        for (const Coefficients& c :
             {Coefficients{dvec3(1), dvec3(0), 0}, {dvec3(1), dvec3(0), 0.7}, {{1, 0.6, 0.3}, dvec3(0), 0.2}}) {
            const Coefficients thick{c.scattering * depth / 2.0, dvec3(0), c.g};
            const dvec3 eye = glm::normalize(dvec3(0.2, -0.6, 0.3));
            expect_mean(render_text(scene(-3.0 * eye, eye, -1, "ratio", thick, false, shape, sky), spp, batches).mean(),
                        dvec3(1), sigmas, 0.03);
        }
}
TEST(Furnace, white_media_of_any_optical_depth_vanish_in_even_light) {
    expect_white(0.1, 32);
    expect_white(1, 32);
    expect_white(10, 32);
}
TEST(FurnaceSlow, the_thickest_white_media_vanish_too) {
    expect_white(100, 64);
    expect_white(1000, 64);
}

}  // namespace
}  // namespace spinel::slab_test
