#include "geometry/mesh/triangle_clip.h"

#include <array>
#include <cmath>
#include <limits>

namespace spinel {

Box clipped_bounds(const kernels::Triangle& triangle, const Box& region) {
    struct Polygon {
        std::array<glm::dvec3, 9> corners;  // three, and one more for each plane
        std::size_t count = 0;
        void add(const glm::dvec3& p) { corners[count++] = p; }
    };
    Polygon polygon;
    for (const glm::vec3& corner : {triangle.a, triangle.b, triangle.c}) polygon.add(glm::dvec3(corner));
    constexpr float inf = std::numeric_limits<float>::infinity();
    for (int plane = 0; plane < 6 && polygon.count > 0; ++plane) {
        const int axis = plane / 2;
        const double sign = plane % 2 ? -1 : 1;
        const double limit = double(plane % 2 ? region.upper[axis] : region.lower[axis]);
        const Polygon whole = polygon;
        polygon.count = 0;
        for (std::size_t i = 0; i < whole.count; ++i) {
            const glm::dvec3 &p = whole.corners[i], &q = whole.corners[(i + 1) % whole.count];
            const double dp = sign * (p[axis] - limit), dq = sign * (q[axis] - limit);
            if (dp >= 0) polygon.add(p);
            if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) {
                glm::dvec3 cut = p + (q - p) * (dp / (dp - dq));
                cut[axis] = limit;
                polygon.add(cut);
            }
        }
    }
    Box bounds{glm::vec3(inf), glm::vec3(-inf)};
    for (std::size_t i = 0; i < polygon.count; ++i)
        for (int a = 0; a < 3; ++a) {
            const double x = polygon.corners[i][a];
            const auto nearest = float(x);
            const float below = double(nearest) > x ? std::nextafter(nearest, -inf) : nearest;
            const float above = double(nearest) < x ? std::nextafter(nearest, inf) : nearest;
            bounds.lower[a] = std::min(bounds.lower[a], below);
            bounds.upper[a] = std::max(bounds.upper[a], above);
        }
    if (polygon.count > 0) {
        bounds.lower = glm::max(bounds.lower, region.lower);
        bounds.upper = glm::min(bounds.upper, region.upper);
    }
    return bounds;
}

}  // namespace spinel
