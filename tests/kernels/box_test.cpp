#include "kernels/box.h"

#include <gtest/gtest.h>

#include "geometry/test_scene.h"
#include "render/reference.h"

namespace spinel::box_test {
namespace {

using namespace test;
using kernels::slab_entry;
using kernels::slab_padding;
using kernels::slab_ray;

bool slab_hit(const Box& box, const kernels::Ray& r) {
    return slab_entry(box.lower, box.upper, slab_ray(r, slab_padding(box.lower, box.upper, r.origin)), r.t_max) <
           kernels::INFINITE;
}

TEST(SlabTest, never_misses_a_box_through_one_of_its_points) {
    Random random(1);
    for (int i = 0; i < 200000; ++i) {
        const float scale = std::exp(random.uniform(-12, 12)), offset = std::exp(random.uniform(-12, 12));
        const vec3 center = offset * random.in_cube();
        const vec3 a = center + scale * random.in_cube(), b = center + scale * random.in_cube();
        Box box{glm::min(a, b), glm::max(a, b)};
        if (i % 3 == 0) box.upper[i % 9 / 3] = box.lower[i % 9 / 3];  // flat
        // A point of the box, often on its faces, edges and corners, and an origin that reaches it exactly:
        // the direction is a power of two times the difference, and where a component of it is zero, so it is
        // exactly.
        vec3 p;
        for (int axis = 0; axis < 3; ++axis) {
            const std::uint32_t where = random.below(3);
            const float f = random.uniform(0, 1);
            p[axis] = where == 0 ? box.lower[axis]
                      : where == 1
                          ? box.upper[axis]
                          : glm::clamp(glm::mix(box.lower[axis], box.upper[axis], f), box.lower[axis], box.upper[axis]);
        }
        const vec3 direction = scale * random.awkward_direction();
        const vec3 origin = p - direction;
        // The rounded origin bends the ray: the direction that really leads to p.
        const kernels::Ray r = ray(origin, p - origin);
        if (kernels::is_black(r.direction)) continue;
        EXPECT_TRUE(slab_hit(box, r)) << describe(r);
    }
}

TEST(SlabTest, rejects_boxes_beside_behind_and_beyond) {
    const Box box{vec3(1, -1, -1), vec3(2, 1, 1)};
    EXPECT_TRUE(slab_hit(box, ray(vec3(0), vec3(1, 0, 0))));
    EXPECT_FALSE(slab_hit(box, ray(vec3(0), vec3(-1, 0, 0))));
    EXPECT_FALSE(slab_hit(box, ray(vec3(0, 1.001f, 0), vec3(1, 0, -0.0f))));
    EXPECT_FALSE(slab_hit(box, ray(vec3(0), vec3(1, 0, 0), 0, 0.999f)));
    EXPECT_FALSE(slab_hit(box, ray(vec3(0), vec3(1, 0, 0), 2.001f)));
    EXPECT_FALSE(slab_hit(box, ray(vec3(0), vec3(1, 2, 0))));
}

TEST(SlabTest, a_ray_along_a_face_is_inside) {
    const Box box{vec3(-1, -1, -1), vec3(1, 1, 1)};
    for (const float face : {-1.0f, 1.0f}) {
        for (const float zero : {0.0f, -0.0f}) {
            EXPECT_TRUE(slab_hit(box, ray(vec3(-3, face, 0), vec3(1, zero, zero))));
            EXPECT_TRUE(slab_hit(box, ray(vec3(-3, face, face), vec3(1, zero, zero))));
        }
    }
}

TEST(SolidBox, equals_the_naive_twin) {
    TestScene parts;
    parts.place(kernels::GEOMETRY_BOX);
    const kernels::SceneView& scene = parts.view();
    Random random(2);
    int hits = 0;
    for (int i = 0; i < 200000; ++i) {
        const kernels::Ray r =
            ray(random.in_cube(i % 2 == 0 ? 3.0f : 1.0f), random.awkward_direction(), random.uniform(0, 1));
        kernels::Hit hit = kernels::no_hit(r.t_max);
        kernels::box_closest(r, hit);
        const ReferenceHit expected = reference_hit(scene, r, kernels::TRACE_ALL);
        const bool found = hit.t < r.t_max;
        ASSERT_EQ(found, expected.hit.instance == 0) << describe(r);
        if (!found) continue;
        ++hits;
        ASSERT_NEAR(hit.t, expected.t, 1e-5 * (1 + expected.t)) << describe(r);
        ASSERT_EQ(hit.primitive, expected.hit.primitive) << describe(r);
        ASSERT_EQ(hit.normal, expected.hit.normal);
        ASSERT_NEAR(hit.uv.x, expected.hit.uv.x, 1e-5 * (1 + expected.t));
        ASSERT_NEAR(hit.uv.y, expected.hit.uv.y, 1e-5 * (1 + expected.t));
    }
    EXPECT_GT(hits, 50000);
}

}  // namespace
}  // namespace spinel::box_test
