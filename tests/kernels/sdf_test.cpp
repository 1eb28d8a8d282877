#include "kernels/sdf.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/sdf_test_scene.h"

namespace spinel::sdf_test {
namespace {

using kernels::Hit;
using kernels::INFINITE;
using kernels::Ray;

// -------------------------------------------------------------------------------------------------------
// closed forms
TEST(SdfKernel, distances_equal_closed_forms) {
    struct Case {
        const char* text;
        vec3 p;
        float expected;
    };
    const float sqrt2 = std::sqrt(2.0f);
    for (const Case& c : {
             Case{"sphere(2)", {3, 0, 0}, 1},
             Case{"sphere(2)", {0, 0, 0}, -2},
             Case{"box(2, 4, 6)", {0, 0, 0}, -1},
             Case{"box(2, 4, 6)", {2, 3, 0}, sqrt2},
             Case{"box(2, 4, 6)", {0, 0, -5}, 2},
             Case{"box(2, 4, 6)", {0.75f, 1.5f, 0}, -0.25f},
             Case{"rounded_box(2, 2, 2, 0.5)", {1.5f, 0, 0}, 0.5f},
             Case{"rounded_box(2, 2, 2, 0.5)", {1, 1, 0}, std::sqrt(0.5f) - 0.5f},
             Case{"torus(2, 0.5)", {2, 0, 0}, -0.5f},
             Case{"torus(2, 0.5)", {0, 0, 0}, 1.5f},
             Case{"torus(2, 0.5)", {0, 3, 2}, 2.5f},
             Case{"cylinder(1, 4)", {0, 3, 0}, 1},
             Case{"cylinder(1, 4)", {2, 3, 0}, sqrt2},
             Case{"cylinder(1, 4)", {0, 0, 0.5f}, -0.5f},
             Case{"translate(1, 2, 3, sphere(1))", {1, 2, 5}, 1},
             Case{"scale(3, sphere(1))", {5, 0, 0}, 2},
             Case{"rotate(0, 0, 1, 90, translate(2, 0, 0, sphere(1)))", {0, 4, 0}, 1},
             Case{"union(sphere(1), translate(4, 0, 0, sphere(1)))", {3.5f, 0, 0}, -0.5f},
             Case{"intersection(sphere(1), translate(1, 0, 0, sphere(1)))", {0, 0, 0}, 0},
             Case{"difference(sphere(2), sphere(1))", {0, 0, 0}, 1},
             Case{"difference(sphere(2), sphere(1))", {1.5f, 0, 0}, -0.5f},
             Case{"smooth_union(1, sphere(1), sphere(1))", {2, 0, 0}, 0.75f},
             Case{"smooth_intersection(1, sphere(1), sphere(1))", {2, 0, 0}, 1.25f},
             Case{"shell(0.5, sphere(2))", {2, 0, 0}, -0.25f},
             Case{"shell(0.5, sphere(2))", {0, 0, 0}, 1.75f},
             Case{"offset(0.5, sphere(2))", {4, 0, 0}, 1.5f},
             Case{"elongate(2, 0, 0, sphere(1))", {3, 0, 0}, 1},
             Case{"repeat(4, 0, 0, 3, 0, 0, sphere(1))", {4, 1.5f, 0}, 0.5f},
             Case{"repeat(4, 0, 0, 2, 0, 0, sphere(1))", {2, 1.5f, 0}, 0.5f},
             Case{"repeat(4, 0, 0, 2, 0, 0, sphere(1))", {-7, 0, 0}, 4},
         }) {
        EXPECT_NEAR(SdfTestScene(c.text).distance(c.p), c.expected, 1e-6f) << c.text;
    }
    auto bounds = std::pair(vec3(-9), vec3(9));
    EXPECT_NEAR(SdfTestScene("plane(0, 2, 0, 1)", bounds).distance({3, 4, 5}), 3, 1e-6f);
    EXPECT_NEAR(SdfTestScene("plane(3, 4, 0, 1)", bounds).distance({0, 0, 5}), -1, 1e-6f);
    // sin x cos y + … = 1 at x = π/2, y = z = 0: a quarter of the period 4.
    EXPECT_NEAR(SdfTestScene("gyroid(4, 0.2)", bounds).distance({1, 0, 0}),
                1 / (std::sqrt(3.0f) * 3.14159265f / 2) - 0.1f, 1e-6f);
}

// ------------------------------------------------------------------------------------------------------------
// tracing
TEST(SdfKernel, sphere_hits_equal_analytic_hits_from_outside_and_inside) {
    SdfTestScene scene("translate(0.3, -0.2, 0.5, sphere(1.5))");
    vec3 centre(0.3f, -0.2f, 0.5f);
    SdfRandom random(1);
    int hits = 0;
    for (int i = 0; i < 50000; i++) {
        vec3 o = random.in_box(vec3(-4), vec3(4));
        vec3 d = random.direction() * random.uniform(0.2f, 5);
        vec3 m = o - centre;
        double a = glm::dot(d, d), b = glm::dot(m, d), c = glm::dot(glm::dvec3(m), glm::dvec3(m)) - 1.5 * 1.5;
        double disc = b * b - a * c;
        Hit hit = scene.closest(Ray(o, 0, d, INFINITE));
        if (std::abs(disc) < 1e-3 * a || std::abs(c) < 1e-4) continue;  // grazes, or starts at the surface
        double t = c < 0 ? (-b + std::sqrt(disc)) / a : (-b - std::sqrt(disc)) / a;
        if (disc < 0 || t < 0) {
            EXPECT_FALSE(is_hit(hit));
            continue;
        }
        hits++;
        ASSERT_TRUE(is_hit(hit));
        EXPECT_NEAR(hit.t * std::sqrt(a), t * std::sqrt(a), 1e-5 / std::sqrt(disc / a));
        vec3 n = glm::normalize(o + hit.t * d - centre);
        EXPECT_GT(glm::dot(n, hit.normal), 0.9999f);
        EXPECT_EQ(scene.any(Ray(o, 0, d, INFINITE)), true);
    }
    EXPECT_GT(hits, 3000);
}

TEST(SdfKernel, hits_lie_strictly_inside_the_segment) {
    SdfTestScene scene("sphere(1)");
    vec3 o(-3, 0, 0), d(1, 0, 0);
    EXPECT_TRUE(is_hit(scene.closest(Ray(o, 0, d, 2.001f))));
    EXPECT_FALSE(is_hit(scene.closest(Ray(o, 0, d, 1.999f))));
    EXPECT_FALSE(scene.any(Ray(o, 0, d, 1.999f)));
    EXPECT_NEAR(scene.closest(Ray(o, 2.5f, d, INFINITE)).t, 4, 1e-5f);
    EXPECT_FALSE(is_hit(scene.closest(Ray(o, 4.5f, d, INFINITE))));
    Hit nearer = kernels::no_hit(INFINITE);
    nearer.t = 1.5f;
    nearer.instance = 7;
    kernels::sdf_closest(scene.view, 0, Ray(o, 0, d, INFINITE), nearer);
    EXPECT_EQ(nearer.t, 1.5f);
    EXPECT_EQ(nearer.instance, 7u);
    EXPECT_FALSE(is_hit(scene.closest(Ray(o, 0, vec3(0), INFINITE))));
}

TEST(SdfKernel, far_and_scaled_rays_hit_as_well) {
    SdfTestScene scene("box(2, 2, 2)");
    for (float scale : {1e-4f, 1.0f, 1e4f}) {
        for (float away : {10.0f, 1e3f, 1e5f}) {
            Hit hit = scene.closest(Ray(vec3(away, 0.3f, 0.2f), 0, vec3(-scale, 0, 0), INFINITE));
            ASSERT_TRUE(is_hit(hit)) << scale << " " << away;
            EXPECT_NEAR(hit.t * scale, away - 1, 2e-7f * away + 1e-6f);
            EXPECT_EQ(hit.normal, vec3(1, 0, 0));
        }
    }
}

// Follows a ray through surfaces as through glass: at each, it goes on from the other side, in `turn`'s
// direction. False: it did not end outside, or hits did not alternate between entering and leaving.
template <class Turn>
bool passes_through(const SdfTestScene& scene, vec3 o, vec3 d, int& crossings, Turn turn) {
    bool inside = scene.distance(o) < 0;
    for (int i = 0; i < 2000; i++) {
        Hit hit = scene.closest(Ray(o, 0, d, INFINITE));
        if (!is_hit(hit)) return !inside;
        crossings++;
        bool enters = glm::dot(hit.normal, d) < 0;
        if (enters == inside) return false;
        inside = enters;
        vec3 p = o + hit.t * d;
        float error = 1e-6f * (glm::length(p) + scene.size());
        o = kernels::sdf_offset_point(scene.view, 0, p, hit.normal, inside ? -1.0f : 1.0f, error);
        if ((scene.distance(o) < 0) != inside) return false;
        d = turn(d, hit.normal, inside);
    }
    return false;
}

const char* const GLASS[] = {
    "sphere(1)",
    "box(2, 1.5, 1)",
    "torus(1, 0.3)",
    "shell(0.01, sphere(1))",
    "intersection(sphere(1.2), gyroid(0.7, 0.06))",
    "difference(box(2, 2, 2), cylinder(0.7, 3), rotate(1, 0, 0, 90, cylinder(0.7, 3)))",
    "smooth_union(0.3, sphere(0.7), translate(0.8, 0.3, 0, box(0.8, 0.8, 0.8)))",
    "twist(2, box(1, 2, 0.5))",
    "displace(0.05, 12, sphere(1))",
    "repeat(0.7, 0.7, 0.7, 3, 3, 3, rotate(1, 1, 0, 30, box(0.5, 0.4, 0.45)))",
    "difference(union(box(2, 2, 2), translate(2, 0, 0, box(2, 2, 2))), translate(1, 1, 0, box(1, 1, 3)))",
};

TEST(SdfKernel, straight_rays_cross_glass_an_even_number_of_times) {
    SdfRandom random(2);
    for (const char* text : GLASS) {
        SdfTestScene scene(text);
        int crossings = 0;
        for (int i = 0; i < 10000; i++) {
            vec3 target = random.in_box(scene.lower(), scene.upper());
            vec3 d = random.direction();
            vec3 o = target - 2 * scene.size() * d;
            int before = crossings;
            ASSERT_TRUE(passes_through(scene, o, d, crossings, [](vec3 d, vec3, bool) { return d; }))
                << text << ", ray " << i;
            ASSERT_EQ((crossings - before) % 2, 0) << text;
            ASSERT_EQ(crossings > before, scene.any(Ray(o, 0, d, INFINITE))) << text;
        }
        EXPECT_GT(crossings, 2000) << text;
    }
}

TEST(SdfKernel, refracted_rays_never_get_stuck_in_glass) {
    SdfRandom random(3);
    for (const char* text : GLASS) {
        SdfTestScene scene(text);
        int crossings = 0;
        for (int i = 0; i < 10000; i++) {
            vec3 target = random.in_box(scene.lower(), scene.upper());
            vec3 d = random.direction();
            vec3 o = target - 2 * scene.size() * d;
            // Any direction of the far hemisphere, grazing ones too.
            auto turn = [&](vec3, vec3 n, bool inside) {
                vec3 v = random.direction();
                bool along = glm::dot(v, n) > 0;
                return along == inside ? -v : v;
            };
            ASSERT_TRUE(passes_through(scene, o, d, crossings, turn)) << text << ", path " << i;
        }
        EXPECT_GT(crossings, 2000) << text;
    }
}

TEST(SdfKernel, axis_aligned_rays_along_faces_agree_with_the_box) {
    SdfTestScene scene("box(2, 2, 2)");
    for (float height : {1 - 1e-3f, 1 - 1e-5f, 1 + 1e-5f, 1 + 1e-3f}) {
        Ray ray(vec3(-5, height, 0), 0, vec3(1, 0, 0), INFINITE);
        EXPECT_EQ(is_hit(scene.closest(ray)), height < 1) << height;
        EXPECT_EQ(scene.any(ray), height < 1) << height;
    }
    for (float height : {1 - 1e-7f, 1.0f, 1 + 1e-7f}) {  // either answer is right; pairs of crossings only
        int crossings = 0;
        EXPECT_TRUE(
            passes_through(scene, vec3(-5, height, 0), vec3(1, 0, 0), crossings, [](vec3 d, vec3, bool) { return d; }));
        EXPECT_EQ(crossings % 2, 0);
    }
}

TEST(SdfKernel, coplanar_faces_of_differences_are_not_hit) {
    // A channel whose lid has been taken away by a box that ends exactly where the solid does; all of it
    // moved to where the same planes round differently. Rays from above must reach the bottom at y = 0.
    SdfTestScene scene(
        "translate(0.1, 0.3, 0.7, difference(box(2, 2, 2), translate(0, 0.5, 0, box(1, 1, 2)), "
        "translate(0.1, 0.75, 0.1, box(0.7, 0.5, 0.9))))");
    SdfRandom random(4);
    for (int i = 0; i < 50000; i++) {
        vec3 target(random.uniform(-0.49f, 0.49f) + 0.1f, 0.3f, random.uniform(-0.99f, 0.99f) + 0.7f);
        vec3 o = target + vec3(random.uniform(-0.01f, 0.01f), 3, random.uniform(-0.01f, 0.01f));
        Hit hit = scene.closest(Ray(o, 0, target - o, INFINITE));
        ASSERT_TRUE(is_hit(hit));
        ASSERT_NEAR(hit.t, 1, 2e-6f) << "ray " << i;
    }
    // Two blocks that share a face are one solid: nothing to hit in between.
    SdfTestScene blocks("union(translate(0.05, 0, 0, box(0.7, 1, 1)), translate(0.75, 0, 0, box(0.7, 1, 1)))");
    for (int i = 0; i < 50000; i++) {
        vec3 o(0, random.uniform(-0.4f, 0.4f), random.uniform(-0.4f, 0.4f));
        vec3 d(1, random.uniform(-0.05f, 0.05f), random.uniform(-0.05f, 0.05f));
        Hit hit = blocks.closest(Ray(o, 0, d, INFINITE));
        ASSERT_TRUE(is_hit(hit));
        ASSERT_NEAR(hit.t, 1.1f, 1e-5f) << "ray " << i;
    }
}

TEST(SdfKernel, thin_sheets_are_not_missed) {
    SdfTestScene scene("shell(0.0005, box(2, 2, 2))");
    SdfRandom random(5);
    for (int i = 0; i < 20000; i++) {
        vec3 target(random.uniform(-0.9f, 0.9f), 1, random.uniform(-0.9f, 0.9f));
        vec3 o = target + vec3(random.uniform(-3, 3), random.uniform(0.1f, 5), random.uniform(-3, 3));
        Hit hit = scene.closest(Ray(o, 0, target - o, INFINITE));
        ASSERT_TRUE(is_hit(hit));
        ASSERT_LT(hit.t, 1) << "ray " << i;
    }
}

TEST(SdfKernel, a_solid_ends_at_its_bounds) {
    SdfTestScene scene("plane(0, 1, 0, 0)", std::pair(vec3(-1, -2, -1), vec3(1, 5, 1)));
    Hit side = scene.closest(Ray(vec3(-4, -1, 0.2f), 0, vec3(1, 0, 0), INFINITE));
    ASSERT_TRUE(is_hit(side));
    EXPECT_NEAR(side.t, 3, 1e-5f);
    EXPECT_EQ(side.normal, vec3(-1, 0, 0));
    Hit exit = scene.closest(Ray(vec3(0, -1, 0), 0, vec3(0, -1, 0), INFINITE));
    ASSERT_TRUE(is_hit(exit));
    EXPECT_NEAR(exit.t, 1, 1e-5f);
    EXPECT_EQ(exit.normal, vec3(0, -1, 0));
    Hit top = scene.closest(Ray(vec3(0.5f, 4, 0.5f), 0, vec3(0, -2, 0), INFINITE));
    ASSERT_TRUE(is_hit(top));
    EXPECT_NEAR(top.t, 2, 1e-5f);
    EXPECT_EQ(top.normal, vec3(0, 1, 0));
}

TEST(SdfKernel, offset_points_lie_on_the_wanted_side) {
    SdfRandom random(6);
    for (const char* text : GLASS) {
        SdfTestScene scene(text);
        for (int i = 0; i < 2000; i++) {
            vec3 d = random.direction();
            vec3 o = random.in_box(scene.lower(), scene.upper()) - 2 * scene.size() * d;
            Hit hit = scene.closest(Ray(o, 0, d, INFINITE));
            if (!is_hit(hit)) continue;
            vec3 p = o + hit.t * d;
            for (float side : {-1.0f, 1.0f}) {
                vec3 q = kernels::sdf_offset_point(scene.view, 0, p, hit.normal, side, 1e-6f);
                ASSERT_GT(scene.distance(q) * side, 0) << text;
                ASSERT_LT(glm::length(q - p), 1e-3f) << text;
            }
        }
    }
}

}  // namespace
}  // namespace spinel::sdf_test
