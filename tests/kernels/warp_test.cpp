#include "kernels/warp.h"

#include <gtest/gtest.h>

#include <random>

#include "kernels/frame.h"
#include "kernels/microfacet.h"
#include "sampling_statistics.h"

namespace spinel::warp_test {
namespace {

using namespace kernels;
using glm::dvec3;
using glm::vec2;
using glm::vec3;

struct DirectionWarp {
    const char* name;
    std::function<vec3(vec2)> sample;
    std::function<float(vec3)> pdf;
};

vec3 at_angle(float cosine) { return vec3(std::sqrt(1 - cosine * cosine), 0, cosine); }

std::vector<DirectionWarp> direction_warps() {
    std::vector<DirectionWarp> warps = {
        {"cosine hemisphere", square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf},
        {"sphere", square_to_sphere, [](vec3) { return square_to_sphere_pdf(); }},
        {"hemisphere", square_to_hemisphere, square_to_hemisphere_pdf},
        {"cone", [](vec2 u) { return square_to_cone(u, 0.3f); },
         [](vec3 d) { return d.z > 0.7f ? square_to_cone_pdf(0.3f) : 0.0f; }},
    };
    for (float alpha : {0.1f, 0.3f, 1.0f}) {
        for (float cosine : {0.1f, 0.6f, 1.0f}) {
            const vec3 wo = at_angle(cosine);
            warps.push_back({"visible GGX normals", [=](vec2 u) { return ggx_sample(alpha, wo, u); },
                             [=](vec3 m) { return ggx_sample_pdf(alpha, wo, m); }});
        }
    }
    return warps;
}

TEST(Warp, directions_follow_their_density) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0.0f, ONE_MINUS_EPSILON);
    const auto warps = direction_warps();
    for (const DirectionWarp& warp : warps) {
        test::SphereChiSquare chi(20, 20);
        for (int i = 0; i < 100000; ++i) {
            const float u = uniform(random);
            const vec3 d = warp.sample(vec2(u, uniform(random)));
            ASSERT_NEAR(glm::length(d), 1.0f, 1e-5f) << warp.name;
            chi.add(d);
        }
        EXPECT_GT(chi.p_value(warp.pdf), test::sidak_threshold(int(warps.size()))) << warp.name;
        EXPECT_NEAR(chi.integral(), 1.0, 2e-3) << warp.name;
    }
}

TEST(Warp, density_is_the_inverse_jacobian) {
    for (const DirectionWarp& warp : direction_warps()) {
        auto map = [&](double u, double v) { return dvec3(warp.sample(vec2(float(u), float(v)))); };
        for (double u : {0.13, 0.37, 0.62, 0.91}) {
            for (double v : {0.11, 0.29, 0.47, 0.83}) {
                const double density = test::density_of_direction_map(map, u, v, 2e-3);
                const double claimed = warp.pdf(vec3(map(u, v)));
                EXPECT_NEAR(density / claimed, 1.0, 0.01) << warp.name << " at " << u << ", " << v;
            }
        }
    }
}

TEST(Warp, narrow_cones_keep_their_digits) {
    const float angle = 0.00465f;  // the sun
    const float one_minus_cos = 2 * std::pow(std::sin(angle / 2), 2.0f);
    double mean = 0;
    for (int i = 0; i < 10000; ++i) {
        const vec3 d = square_to_cone(vec2(float(i % 100) / 100, (float(i) + 0.5f) / 10000), one_minus_cos);
        const double sine = std::hypot(d.x, d.y);
        ASSERT_LE(sine, std::sin(angle) * 1.00001);
        mean += sine / 10000;
    }
    EXPECT_NEAR(mean, 2.0 / 3 * angle, 1e-3 * angle);  // the mean radius of a disc
}

TEST(Warp, disc_is_uniform_and_inside) {
    std::vector<double> observed(64, 0.0);
    const int n = 1024;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const vec2 p = square_to_disc(vec2((i + 0.5f) / n, (j + 0.5f) / n));
            ASSERT_LE(glm::length(p), 1.0f + 1e-6f);
            const int ring = std::min(int(glm::dot(p, p) * 8), 7);  // equal areas
            const int sector = std::min(int((std::atan2(p.y, p.x) + PI) / (2 * PI) * 8), 7);
            observed[std::size_t(ring * 8 + sector)] += 1;
        }
    }
    for (double count : observed) EXPECT_NEAR(count, n * n / 64.0, 0.03 * n * n / 64.0);
    EXPECT_EQ(square_to_disc(vec2(0.5f, 0.5f)), vec2(0.0f));
    EXPECT_FLOAT_EQ(square_to_disc_pdf() * PI, 1.0f);
}

TEST(Warp, triangle_is_uniform_and_inside) {
    const int n = 400;
    std::vector<double> observed(16, 0.0);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const vec2 b = square_to_triangle(vec2((i + 0.5f) / n, (j + 0.5f) / n));
            ASSERT_GE(b.x, 0.0f);
            ASSERT_GE(b.y, 0.0f);
            ASSERT_LE(b.x + b.y, 1.0f + 1e-6f);
            // Sixteen congruent triangles: four cells to an edge, each but the diagonal ones split in two.
            const int x = std::min(int(b.x * 4), 3), y = std::min(int(b.y * 4), 3);
            const bool upper = b.x * 4 - float(x) + b.y * 4 - float(y) > 1.0f;
            const int cell = y * 8 - y * y + 2 * x + (upper ? 1 : 0);
            ASSERT_LT(cell, 16);
            observed[std::size_t(cell)] += 1;
        }
    }
    for (double count : observed) EXPECT_NEAR(count, n * n / 16.0, 0.03 * n * n / 16.0);
    EXPECT_EQ(square_to_triangle_pdf(), 2.0f);
}

TEST(Warp, tent_and_gaussian_have_their_densities) {
    const int n = 20000;
    std::vector<double> tent(20, 0.0), gauss(20, 0.0);
    double variance = 0;
    for (int i = 0; i < n; ++i) {
        const float x = interval_to_tent((i + 0.5f) / n);
        tent[std::size_t(glm::clamp(int((x + 1) * 10), 0, 19))] += 1;
        const vec2 g = square_to_gaussian(vec2((i + 0.5f) / n, std::fmod(i * 0.61803398875f, 1.0f)));
        variance += glm::dot(g, g) / (2.0 * n);
        if (std::abs(g.x) < 3) gauss[std::size_t((g.x + 3) / 6 * 20)] += 1;
    }
    for (int i = 0; i < 20; ++i) {
        const float x = (i + 0.5f) / 10 - 1;
        EXPECT_NEAR(tent[std::size_t(i)], n * 0.1 * interval_to_tent_pdf(x), 5.0);
        const double a = -3 + 0.3 * i, b = a + 0.3;
        const double mass = 0.5 * (std::erf(b / std::sqrt(2.0)) - std::erf(a / std::sqrt(2.0)));
        EXPECT_NEAR(gauss[std::size_t(i)], n * mass, 4 * std::sqrt(n * mass) + 4);
    }
    EXPECT_NEAR(variance, 1.0, 0.01);
    const double total = test::integrate(
        [](double x, double y) { return square_to_gaussian_pdf(vec2(float(x), float(y))); }, -7, 7, -7, 7, 1e-6);
    EXPECT_NEAR(total, 1.0, 1e-4);
    EXPECT_TRUE(std::isfinite(square_to_gaussian(vec2(1.0f, 0.5f)).x));
}

TEST(Warp, corners_of_the_square_are_safe) {
    for (float u : {0.0f, ONE_MINUS_EPSILON}) {
        for (float v : {0.0f, ONE_MINUS_EPSILON}) {
            for (const DirectionWarp& warp : direction_warps()) {
                const vec3 d = warp.sample(vec2(u, v));
                EXPECT_NEAR(glm::length(d), 1.0f, 1e-4f) << warp.name;
            }
            EXPECT_GT(square_to_cosine_hemisphere(vec2(u, v)).z, 0.0f);
        }
    }
}

TEST(Frame, is_orthonormal_everywhere) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> uniform(0.0f, ONE_MINUS_EPSILON);
    for (int i = 0; i < 10000; ++i) {
        const float u = uniform(random);
        vec3 z = square_to_sphere(vec2(u, uniform(random)));
        if (i == 0) z = vec3(0, 0, -1);
        if (i == 1) z = vec3(0, 0, 1);
        if (i == 2) z = glm::normalize(vec3(1e-5f, -1e-6f, -1));
        const float s = uniform(random);
        const vec3 tangent = square_to_sphere(vec2(s, uniform(random)));
        for (const Frame& f : {make_frame(z), make_frame_along(z, tangent), make_frame_along(z, vec3(0))}) {
            ASSERT_NEAR(glm::dot(f.x, f.y), 0, 2e-6f);
            ASSERT_NEAR(glm::dot(f.y, f.z), 0, 2e-6f);
            ASSERT_NEAR(glm::dot(f.z, f.x), 0, 2e-6f);
            ASSERT_NEAR(glm::length(f.x), 1, 2e-6f);
            ASSERT_NEAR(glm::length(f.y), 1, 2e-6f);
            ASSERT_NEAR(glm::dot(glm::cross(f.x, f.y), f.z), 1, 2e-6f);
            ASSERT_NEAR(glm::length(to_world(f, to_local(f, tangent)) - tangent), 0, 4e-6f);
        }
        ASSERT_GE(glm::dot(make_frame_along(z, tangent).x, tangent), 0.0f);
    }
}

}  // namespace
}  // namespace spinel::warp_test
