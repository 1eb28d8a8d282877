// The ways to follow light through media on grids agree with each other, with closed forms, and with a naive twin that
// knows neither local majorants nor light sampling nor roulette.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>
#include <random>

#include "kernels/phase.h"
#include "render/pictures.h"

namespace spinel::tracking_test {
namespace {

using namespace test;

constexpr int edge = 12;  // three coarse cells: some of them empty, some full, some of both
const char* const estimators[] = {"ratio", "residual", "delta"};

// A ball with a hollow in it, steps and slopes; at most 1.
float density_at(ivec3 i) {
    const vec3 p = (vec3(i) + 0.5f) / float(edge) - 0.5f;
    const float r = glm::length(p);
    if (r > 0.45f || glm::length(p - vec3(0.15f, 0.1f, 0)) < 0.12f) return 0;
    return r < 0.3f ? 0.8f + 0.2f * std::sin(20 * p.x) : 0.35f;
}

std::string values(float factor) {
    std::string list;
    for (int z = 0; z < edge; ++z)
        for (int y = 0; y < edge; ++y)
            for (int x = 0; x < edge; ++x)
                list += (list.empty() ? "" : ",") + fmt::format("{}", factor * density_at({x, y, z}));
    return list;
}

// The grid over [−½, ½]³. `contents`: media, objects and light.
std::string grid_scene(const std::string& integrator, const std::string& contents, float factor = 1, int size = 12) {
    return fmt::format(
        R"({{"version": 1, "film": {{"size": [{0}, {0}], "filter": "box", "filter_radius": 0.5}},
        "integrator": {{{1}}}, "camera": {{"from": [1.2, 0.9, 2], "at": [0, 0, 0], "fov": 30}},
        "geometries": {{"grid": {{"type": "volume", "size": [{2}, {2}, {2}], "values": [{3}],
            "transform": [{{"translate": [-6, -6, -6]}}, {{"scale": 0.083333333}}]}}}}, {4}}})",
        size, integrator, edge, values(factor), contents);
}
std::string estimator(const char* name, int max_bounces = -1) {
    return fmt::format(R"("transmittance": "{}", "max_bounces": {})", name, max_bounces);
}
const std::string volume = R"("objects": [{"geometry": "grid", "interior": "m"}], )";
// Light that both light sampling and scattering find, from near and far.
const std::string lamps = R"("environment": {"type": "sky", "sun_elevation": 40, "sun_angular_radius": 12},
    "materials": {"lamp": {"type": "diffuse", "color": 0, "emission": 6}}, )";
const std::string volume_and_lamp = R"("objects": [{"geometry": "grid", "interior": "m"},
    {"geometry": {"type": "sphere", "radius": 0.2}, "material": "lamp", "transform": [{"translate": [-0.8, 0.2, 0.1]}]}])";

TEST(Tracking, estimators_of_transmittance_agree_in_grey_and_in_coloured_media) {
    for (const char* medium : {R"("scattering": [6, 7, 8], "absorption": [3, 2, 1], "g": 0.5)",
                               R"("scattering": [2, 5, 9], "absorption": [0.3, 0.1, 0.5], "g": -0.3)"}) {
        const auto render_with = [&](const char* name) {
            return render_text(grid_scene(estimator(name), lamps + R"("media": {"m": {"density": "grid", )" + medium +
                                                               "}}, " + volume_and_lamp),
                               48);
        };
        const TestPicture ratio = render_with("ratio");
        expect_same(ratio, render_with("residual"));
        expect_same(ratio, render_with("delta"));
    }
}

TEST(Tracking, the_walk_of_one_grey_medium_equals_that_of_many) {
    // Twice half of it is the same; only one alone takes the short way.
    const std::string medium =
        R"("density": "grid", "scattering": 7, "absorption": [1, 1, 1], "g": 0.4, "emission": 1)";
    const std::string half =
        R"("density": "grid", "scattering": 3.5, "absorption": [0.5, 0.5, 0.5], "g": 0.4, "emission": 0.5)";
    for (const char* name : estimators) {
        const TestPicture one = render_text(
            grid_scene(estimator(name), lamps + "\"media\": {\"m\": {" + medium + "}}, " + volume_and_lamp), 32);
        const TestPicture two =
            render_text(grid_scene(estimator(name), lamps + "\"media\": {\"m\": {" + half + "}, \"n\": {" + half +
                                                        "}}, " + volume_and_lamp.substr(0, volume_and_lamp.size() - 1) +
                                                        R"(, {"geometry": "grid", "interior": "n"}])"),
                        32);
        expect_same(one, two);
    }
}

// -------------------------------------------------------------------------------------------------- the naive twin
double trilinear(dvec3 p) {  // in the grid's space
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
        double weight = 1;
        ivec3 index;
        for (int a = 0; a < 3; ++a) {
            const double q = p[a] - 0.5, base = std::floor(q);
            const int bit = (c >> a) & 1;
            weight *= bit ? q - base : 1 - (q - base);
            index[a] = std::clamp(int(base) + bit, 0, edge - 1);
        }
        sum += weight * double(density_at(index));
    }
    return sum;
}

struct NaiveCloud {
    double extinction, albedo, g;
    std::mt19937 random{5};
    double draw() { return std::uniform_real_distribution<double>(0, 1)(random); }

    bool inside(dvec3 p) const { return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < edge && p.y < edge && p.z < edge; }
    // Plain delta tracking by the one bound of the whole grid (Woodcock 1965). False: out of the box.
    bool flight(dvec3& p, dvec3 d) {
        while (true) {
            p += d * (-std::log(1 - draw()) / extinction * edge);
            if (!inside(p)) return false;
            if (draw() < trilinear(p)) return true;
        }
    }
    // Radiance from p along d in a sky of radiance 1, and of a sun of irradiance 1 from `to_sun`.
    double radiance(dvec3 p, dvec3 d, dvec3 to_sun, int max_bounces) {
        double weight = 1, sum = 0;
        for (int bounce = 0; flight(p, d); ++bounce) {
            if (max_bounces >= 0 && bounce >= max_bounces) return sum;
            weight *= albedo;
            dvec3 shadow = p;
            if (!flight(shadow, to_sun))
                sum += weight * double(kernels::phase_eval(float(g), float(glm::dot(d, to_sun))));
            d = dvec3(kernels::phase_sample(float(g), vec3(d), vec2(float(draw()), float(draw()))).direction);
            d = glm::normalize(d);
        }
        return sum + weight;
    }
};

void expect_naive(double extinction, double albedo, double g, int max_bounces, int spp, int paths) {
    const std::string text = fmt::format(
        R"({{"version": 1, "film": {{"size": [4, 4], "filter": "box", "filter_radius": 0.5}},
        "integrator": {{"max_bounces": {0}, "transmittance": "TRANSMITTANCE"}},
        "camera": {{"type": "orthographic", "from": [4.7, 5.4, 30], "at": [4.7, 5.4, 0], "height": 1e-4}},
        "environment": {{"type": "constant", "radiance": 1}},
        "lights": [{{"type": "directional", "direction": [-0.48, -0.64, -0.6], "irradiance": 1}}],
        "geometries": {{"grid": {{"type": "volume", "size": [{1}, {1}, {1}], "values": [{2}]}}}},
        "media": {{"m": {{"density": "grid", "scattering": {3}, "absorption": {4}, "g": {5}}}}},
        "objects": [{{"geometry": "grid", "interior": "m"}}]}})",
        max_bounces, edge, values(1), extinction * albedo / edge, extinction * (1 - albedo) / edge, g);
    NaiveCloud naive{extinction, albedo, g};
    double sum = 0, squares = 0;
    for (int i = 0; i < paths; ++i) {
        const double l = naive.radiance({4.7, 5.4, edge - 1e-9}, {0, 0, -1}, {0.48, 0.64, 0.6}, max_bounces);
        sum += l;
        squares += l * l;
    }
    const double mean = sum / paths, error = std::sqrt((squares / paths - mean * mean) / paths);
    for (const char* name : estimators) {
        std::string one = text;
        one.replace(one.find("TRANSMITTANCE"), 13, name);
        const Estimate e = render_text(one, spp).mean();
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(e.mean[k], mean, milder * 3.5 * std::sqrt(error * error + e.error[k] * e.error[k])) << name;
        EXPECT_LT(error, 0.02 * mean);
        EXPECT_LT(e.error.x, more_noise * 0.02 * mean);
    }
}

TEST(Tracking, equals_plain_delta_tracking_by_one_majorant) {
    expect_naive(4, 0.8, 0.6, 1, 256, 20000);
    expect_naive(10, 0.9, 0.3, -1, 512, 20000);
}
TEST(Tracking, hundreds_of_bounces_at_albedo_0_9999_equal_the_naive_twin) {
    expect_naive(60, 0.9999, 0.5, -1, 256, 4000);
}
TEST(TrackingSlow, hundreds_of_bounces_at_albedo_0_9999_equal_the_naive_twin_closely) {
    expect_naive(200, 0.9999, 0.8, -1, 2048, 40000);
}

// ------------------------------------------------------------------------------------------------------- furnaces
void expect_furnace(double depth, int spp) {
    for (const char* scattering : {"[1, 1, 1]", "[1, 0.6, 0.3]"}) {
        const double sigma = depth;  // over the edge of the box, at density 1
        const vec3 color = scattering[4] == '1' ? vec3(1) : vec3(1, 0.6f, 0.3f);
        const TestPicture p = render_text(
            grid_scene(estimator("ratio"),
                       fmt::format(R"("environment": {{"type": "constant", "radiance": 1}}, {}
            "media": {{"m": {{"density": "grid", "scattering": [{}, {}, {}], "g": 0.2}}}})",
                                   volume, sigma * double(color.x), sigma * double(color.y), sigma * double(color.z)),
                       1, 4),
            spp);
        expect_mean(p.mean(), dvec3(1), 3.5, 0.05);
    }
}
TEST(Tracking, white_clouds_on_grids_vanish_in_uniform_light) {
    expect_furnace(0.1, 16);
    expect_furnace(10, 64);
}
TEST(TrackingSlow, the_densest_white_clouds_vanish_too) {
    expect_furnace(100, 64);
    expect_furnace(1000, 32);
}

}  // namespace
}  // namespace spinel::tracking_test
