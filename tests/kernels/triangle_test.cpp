#include "kernels/triangle.h"

#include <gtest/gtest.h>

#include "geometry/test_scene.h"

namespace spinel::triangle_test {
namespace {

using namespace test;
using kernels::Triangle;
using kernels::TriangleHit;

bool watertight(const kernels::Ray& r, const Triangle& triangle, TriangleHit& hit) {
    return kernels::triangle_watertight(kernels::triangle_ray(r), triangle, r.t_min, r.t_max, hit);
}

// Sizes and offsets from tiny to huge.
Triangle random_triangle(Random& random, float& scale) {
    scale = std::exp(random.uniform(-15, 15));
    const vec3 center = scale * random.in_cube(4);
    return {center + scale * random.in_cube(), center + scale * random.in_cube(), center + scale * random.in_cube()};
}

TEST(TriangleTest, both_tests_find_t_and_barycentric_weights) {
    Random random(3);
    int compared = 0;
    for (int i = 0; i < 100000; ++i) {
        float scale;
        const Triangle triangle = random_triangle(random, scale);
        float u = random.uniform(0, 1), v = random.uniform(0, 1);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        if (u < 0.01f || v < 0.01f || u + v > 0.99f) continue;
        const vec3 p = (1 - u - v) * triangle.a + u * triangle.b + v * triangle.c;
        const vec3 direction = random.awkward_direction();
        const float distance = scale * random.uniform(0.5f, 3);
        const kernels::Ray r = ray(p - distance * direction, 2.0f * direction);
        const vec3 normal = glm::cross(triangle.b - triangle.a, triangle.c - triangle.a);
        const float cosine = std::abs(glm::dot(glm::normalize(normal), glm::normalize(direction)));
        if (cosine < 0.1f || glm::length(normal) < 0.1f * scale * scale) continue;
        ++compared;
        TriangleHit hit;
        ASSERT_TRUE(watertight(r, triangle, hit)) << describe(r);
        ASSERT_NEAR(hit.t / scale, 0.5f * distance / scale, 1e-4);
        ASSERT_NEAR(hit.u, u, 1e-3);
        ASSERT_NEAR(hit.v, v, 1e-3);
        ASSERT_TRUE(kernels::triangle_moller_trumbore(r, triangle, r.t_min, r.t_max, hit)) << describe(r);
        ASSERT_NEAR(hit.t / scale, 0.5f * distance / scale, 1e-4);
        ASSERT_NEAR(hit.u, u, 1e-3);
        ASSERT_NEAR(hit.v, v, 1e-3);
    }
    EXPECT_GT(compared, 20000);
}

TEST(TriangleTest, both_tests_reject_what_passes_beside_and_what_lies_outside_the_segment) {
    const Triangle triangle{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
    for (const vec3 origin : {vec3(-0.01f, 0.3f, 0), vec3(0.3f, -0.01f, 0), vec3(0.51f, 0.5f, 0)}) {
        TriangleHit hit;
        const kernels::Ray r = ray(origin, vec3(0, 0, 1));
        EXPECT_FALSE(watertight(r, triangle, hit));
        EXPECT_FALSE(kernels::triangle_moller_trumbore(r, triangle, r.t_min, r.t_max, hit));
    }
    // The interval is open: a hit at t_min or at t_max is none.
    for (const auto& [t_min, t_max, expected] : {std::tuple(0.0f, 2.0f, true), std::tuple(1.0f, 2.0f, false),
                                                 std::tuple(0.0f, 1.0f, false), std::tuple(1.5f, 2.0f, false)}) {
        TriangleHit hit;
        const kernels::Ray r = ray(vec3(0.25f, 0.25f, 0), vec3(0, 0, 1), t_min, t_max);
        EXPECT_EQ(watertight(r, triangle, hit), expected);
        EXPECT_EQ(kernels::triangle_moller_trumbore(r, triangle, t_min, t_max, hit), expected);
    }
}

// Two triangles share an edge, four quads a vertex, and rays are aimed at them: one of the sharers must
// answer.
TEST(TriangleTest, no_ray_passes_between_the_triangles_of_a_fan) {
    Random random(4);
    for (int i = 0; i < 20000; ++i) {
        const float scale = std::exp(random.uniform(-15, 15));
        const vec3 offset = scale * random.in_cube(50);
        // A bumpy fan around a centre, its rim around the ray.
        constexpr int spokes = 7;
        const vec3 center = offset + scale * 0.1f * random.in_cube();
        vec3 rim[spokes];
        for (int k = 0; k < spokes; ++k) {
            const float angle = 2 * kernels::PI * float(k) / spokes;
            rim[k] = offset + scale * (vec3(std::cos(angle), std::sin(angle), 0) + 0.2f * random.in_cube());
        }
        const int k = int(random.below(spokes));
        const float f = random.below(4) == 0 ? 0.0f : random.uniform(0, 0.9f);
        const vec3 target = glm::mix(center, rim[k], f);  // the centre, or on a spoke
        const vec3 direction = glm::normalize(vec3(0.3f * random.in_cube().x, 0.3f * random.in_cube().y, 1));
        const kernels::Ray r = ray(target - scale * random.uniform(0.5f, 100) * direction, direction);
        bool found = false;
        for (int j = 0; j < spokes; ++j) {
            TriangleHit hit;
            found = found || watertight(r, {center, rim[j], rim[(j + 1) % spokes]}, hit);
        }
        ASSERT_TRUE(found) << describe(r);
    }
}

TEST(TriangleTest, neighbours_agree_exactly_about_the_side_of_their_edge) {
    Random random(5);
    for (int i = 0; i < 100000; ++i) {
        const float ax = random.uniform(-1, 1), ay = random.uniform(-1, 1);
        // Nearly parallel: the difference is far below the rounding of its products.
        const float f = random.uniform(0.5f, 2), bx = f * ax, by = f * ay;
        const float one = kernels::difference_of_products(ax, by, ay, bx);
        const float other = kernels::difference_of_products(bx, ay, by, ax);
        ASSERT_EQ(one > 0, other < 0);
        ASSERT_EQ(one<0, other> 0);
        const double exact = double(ax) * double(by) - double(ay) * double(bx);
        ASSERT_EQ(one > 0, exact > 0);
        ASSERT_EQ(one < 0, exact < 0);
    }
}

TEST(TriangleTest, degenerate_triangles_and_slivers_give_no_hit_or_a_finite_one) {
    Random random(6);
    for (int i = 0; i < 100000; ++i) {
        const vec3 a = random.in_cube(), b = random.in_cube();
        const vec3 sliver = glm::mix(a, b, random.uniform(-1, 2)) + 1e-30f * random.in_cube();
        const kernels::Ray r =
            ray(random.in_cube(3), i % 2 ? glm::mix(a, b, 0.3f) - random.in_cube(3) : random.awkward_direction());
        TriangleHit hit{};
        for (const Triangle& triangle : {Triangle{a, a, a}, Triangle{a, a, b}, Triangle{a, b, a}, Triangle{b, a, a}}) {
            ASSERT_FALSE(watertight(r, triangle, hit)) << describe(r);
            ASSERT_FALSE(kernels::triangle_moller_trumbore(r, triangle, r.t_min, r.t_max, hit) &&
                         !std::isfinite(hit.t));
        }
        if (watertight(r, {a, b, sliver}, hit)) {
            ASSERT_TRUE(std::isfinite(hit.t) && hit.t > r.t_min && hit.t < r.t_max);
            ASSERT_TRUE(hit.u >= 0 && hit.v >= 0 && hit.u + hit.v <= 1.00001f);
        }
    }
    const float nan = std::nanf("");
    TriangleHit hit;
    EXPECT_FALSE(watertight(ray(vec3(0), vec3(0, 0, 1)), {vec3(nan), vec3(1, 0, 1), vec3(0, 1, 1)}, hit));
}

}  // namespace
}  // namespace spinel::triangle_test
