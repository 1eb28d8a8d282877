#include "formats/polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace spinel::polygon_test {
namespace {

vec3 area_vector(const std::vector<vec3>& p, uvec3 t) { return 0.5f * glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]); }

// Every triangle faces the way of the polygon and their areas add up: nothing is covered twice.
void expect_exact_cover(const std::vector<vec3>& corners, vec3 area) {
    std::vector<unsigned> polygon(corners.size());
    std::iota(polygon.begin(), polygon.end(), 0u);
    for (std::size_t shift = 0; shift < corners.size(); ++shift) {
        std::vector<uvec3> triangles;
        triangulate(corners, polygon, triangles);
        ASSERT_EQ(triangles.size(), corners.size() - 2);
        vec3 sum(0);
        for (const uvec3& t : triangles) {
            EXPECT_GE(glm::dot(area_vector(corners, t), area), 0.0f);
            sum += area_vector(corners, t);
        }
        EXPECT_LT(glm::length(sum - area), 1e-4f * glm::length(area));
        std::rotate(polygon.begin(), polygon.begin() + 1, polygon.end());
    }
}

TEST(Polygon, concave_polygons_are_covered_once_from_any_corner_and_in_any_plane) {
    const std::vector<vec3> arrow = {{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {0.5f, 1, 0}};
    const std::vector<vec3> comb = {{0, 0, 0}, {5, 0, 0}, {5, 3, 0}, {4, 1, 0},
                                    {3, 3, 0}, {2, 1, 0}, {1, 3, 0}, {0, 3, 0}};
    for (const auto& shape : {arrow, comb}) {
        float area = 0;
        for (std::size_t i = 0; i < shape.size(); ++i) {
            const vec3 a = shape[i], b = shape[(i + 1) % shape.size()];
            area += 0.5f * (a.x * b.y - b.x * a.y);
        }
        for (int axis = 0; axis < 3; ++axis) {
            for (const float side : {1.0f, -1.0f}) {
                std::vector<vec3> turned;
                vec3 normal(0);
                normal[axis] = side;
                for (const vec3& p : shape) {
                    vec3 q(0);
                    q[(axis + 1) % 3] = side * p.x;
                    q[(axis + 2) % 3] = p.y;
                    turned.push_back(q + vec3(7, 8, 9));
                }
                expect_exact_cover(turned, area * normal);
            }
        }
    }
}

TEST(Polygon, a_convex_polygon_is_a_fan_whatever_its_size) {
    for (const unsigned n : {3u, 4u, 9u, 1024u, 1025u}) {
        std::vector<vec3> corners;
        std::vector<unsigned> polygon;
        for (unsigned i = 0; i < n; ++i) {
            const float angle = 6.2831853f * float(i) / float(n);
            corners.emplace_back(std::cos(angle), std::sin(angle), 0);
            polygon.push_back(i);
        }
        std::vector<uvec3> triangles;
        triangulate(corners, polygon, triangles);
        ASSERT_EQ(triangles.size(), n - 2);
        for (unsigned i = 2; i < n; ++i) EXPECT_GT(area_vector(corners, triangles[i - 2]).z, 0.0f);
    }
}

TEST(Polygon, what_crosses_itself_or_has_no_area_still_ends) {
    const unsigned polygon[] = {0, 1, 2, 3, 4};
    for (const auto& corners : {std::vector<vec3>(5, vec3(1)),
                                {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}},
                                {{0, 1, 0}, {0.6f, -0.8f, 0}, {-1, 0.3f, 0}, {1, 0.3f, 0}, {-0.6f, -0.8f, 0}}}) {
        std::vector<uvec3> triangles;
        triangulate(corners, polygon, triangles);
        EXPECT_EQ(triangles.size(), 3u);
    }
}

}  // namespace
}  // namespace spinel::polygon_test
