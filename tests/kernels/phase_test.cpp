#include "kernels/phase.h"

#include <gtest/gtest.h>

#include <random>

#include "sampling_statistics.h"

namespace spinel::phase_test {
namespace {

using namespace kernels;
using glm::dvec3;
using glm::vec2;
using glm::vec3;

const float asymmetries[] = {-0.999f, -0.9f, -0.4f, -1e-4f, 0.0f, 1e-6f, 1e-3f, 0.3f, 0.8f, 0.95f, 0.999f, 1.0f, -1.0f};

TEST(Phase, integrates_to_one_with_mean_cosine_g) {
    for (float g : asymmetries) {
        if (std::abs(g) > 0.9999f) continue;
        double sum = 0, mean = 0;
        const int n = 200000;
        for (int i = 0; i < n; ++i) {  // steps that crowd at the peak: t = 2 s³ from it
            const double s = (i + 0.5) / n, t = 2 * s * s * s, dt = 6 * s * s / n;
            const double cosine = g < 0 ? t - 1 : 1 - t;
            const double p = 2 * M_PI * phase_eval(g, float(cosine)) * dt;
            sum += p;
            mean += p * cosine;
        }
        // In float 1 − cosine has no digits left where the peak of |g| = 0.999 is.
        const double tolerance = std::abs(g) > 0.99f ? 0.05 : 1e-4;
        EXPECT_NEAR(sum, 1, tolerance) << g;
        EXPECT_NEAR(mean, g, tolerance) << g;
    }
}

TEST(Phase, samples_follow_the_density) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(0.0f, ONE_MINUS_EPSILON);
    const std::vector<float> tested = {-0.8f, -0.3f, 0.0f, 1e-4f, 0.5f, 0.8f};
    const std::vector<vec3> forwards = {vec3(0, 0, 1), glm::normalize(vec3(1, -2, 0.5f))};
    for (float g : tested) {
        for (vec3 forward : forwards) {
            test::SphereChiSquare chi(20, 20);
            for (int i = 0; i < 100000; ++i) {
                const float u = uniform(random);
                chi.add(phase_sample(g, forward, vec2(u, uniform(random))).direction);
            }
            const double p = chi.p_value([&](vec3 d) { return double(phase_pdf(g, glm::dot(d, forward))); });
            EXPECT_GT(p, test::sidak_threshold(int(tested.size() * forwards.size()))) << g;
            EXPECT_NEAR(chi.integral(), 1, 1e-3);
        }
    }
}

TEST(Phase, density_is_the_inverse_jacobian) {
    for (float g : {-0.9f, -0.3f, 0.0f, 1e-5f, 0.5f, 0.9f}) {
        auto map = [&](double u, double v) {
            return dvec3(phase_sample(g, vec3(0, 0, 1), vec2(float(u), float(v))).direction);
        };
        for (double u : {0.1, 0.5, 0.8}) {
            for (double v : {0.2, 0.7}) {
                const double claimed = phase_sample(g, vec3(0, 0, 1), vec2(float(u), float(v))).pdf;
                EXPECT_NEAR(test::density_of_direction_map(map, u, v, 2e-3) / claimed, 1, 0.01) << g;
            }
        }
    }
}

TEST(Phase, sampled_mean_cosine_is_g_at_the_extremes_too) {
    for (float g : asymmetries) {
        double mean = 0;
        const int n = 20000;
        for (int i = 0; i < n; ++i) {
            const PhaseSample s = phase_sample(g, vec3(0, 1, 0), vec2((float(i) + 0.5f) / n, 0.3f));
            ASSERT_TRUE(std::isfinite(s.pdf) && s.pdf > 0) << g;
            ASSERT_NEAR(glm::length(s.direction), 1, 1e-5f) << g;
            mean += s.direction.y / double(n);
        }
        EXPECT_NEAR(mean, g, 1e-3) << g;
    }
}

TEST(Phase, forward_is_along_the_direction_of_travel) {
    EXPECT_GT(phase_eval(0.5f, 1), 10 * phase_eval(0.5f, -1));
    EXPECT_FLOAT_EQ(phase_eval(0, 0.3f), 1 / (4 * PI));
    EXPECT_FLOAT_EQ(phase_eval(-0.5f, -0.4f), phase_eval(0.5f, 0.4f));
    EXPECT_FLOAT_EQ(phase_eval(0.5f, 0.2f), 0.25f / PI * 0.75f / std::pow(1.25f - 0.2f, 1.5f));
}

}  // namespace
}  // namespace spinel::phase_test
