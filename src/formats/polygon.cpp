#include "formats/polygon.h"

#include <cmath>

namespace spinel {
namespace {

using glm::dvec2;
using glm::dvec3;

// Twice the signed area: positive where a, b, c run counter-clockwise.
double area(dvec2 a, dvec2 b, dvec2 c) { return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y); }

// Newell's method: right for any flat polygon, a good mean for others.
dvec3 newell_normal(std::span<const vec3> positions, std::span<const unsigned> polygon) {
    dvec3 normal(0.0);
    const dvec3 origin(positions[polygon[0]]);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const dvec3 a = dvec3(positions[polygon[i]]) - origin;
        const dvec3 b = dvec3(positions[polygon[(i + 1) % polygon.size()]]) - origin;
        normal += glm::cross(a, b);
    }
    return normal;
}

bool is_ear(const std::vector<dvec2>& points, const std::vector<std::size_t>& left, std::size_t i) {
    const std::size_t n = left.size();
    const std::size_t previous = left[(i + n - 1) % n], current = left[i], next = left[(i + 1) % n];
    const dvec2 a = points[previous], b = points[current], c = points[next];
    if (!(area(a, b, c) > 0.0)) return false;  // reflex, flat or NaN
    for (const std::size_t other : left) {
        const dvec2 p = points[other];
        // Corners of the ear itself, or at the same place (a bridge to a hole), do not block it.
        if (other == previous || other == current || other == next || p == a || p == b || p == c) continue;
        if (area(a, b, p) >= 0.0 && area(b, c, p) >= 0.0 && area(c, a, p) >= 0.0) return false;
    }
    return true;
}

}  // namespace

void triangulate(std::span<const vec3> positions, std::span<const unsigned> polygon, std::vector<uvec3>& triangles) {
    constexpr std::size_t largest = 1024;
    const std::size_t n = polygon.size();
    if (n == 3 || n > largest) {
        for (std::size_t i = 2; i < n; ++i) triangles.emplace_back(polygon[0], polygon[i - 1], polygon[i]);
        return;
    }
    // Seen along the normal, by dropping the axis it is longest along.
    const dvec3 normal = newell_normal(positions, polygon);
    const dvec3 size = glm::abs(normal);
    const int z = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    const int x = (z + 1) % 3, y = (z + 2) % 3;
    std::vector<dvec2> points;
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < n; ++i) {
        const vec3 p = positions[polygon[i]];
        points.push_back(normal[z] < 0.0 ? dvec2(-double(p[x]), p[y]) : dvec2(p[x], p[y]));
        left.push_back(i);
    }
    std::size_t i = 1;  // so that a convex polygon becomes the fan about its first corner
    while (left.size() > 3) {
        const std::size_t m = left.size();
        std::size_t ear = i % m;
        for (std::size_t tries = 0; tries < m && !is_ear(points, left, ear); ++tries) ear = (ear + 1) % m;
        // Without an ear (it crosses itself, or has no area) any corner goes: the count of triangles stays n
        // − 2.
        triangles.emplace_back(polygon[left[(ear + m - 1) % m]], polygon[left[ear]], polygon[left[(ear + 1) % m]]);
        left.erase(left.begin() + std::ptrdiff_t(ear));
        i = ear == m - 1 ? 0 : ear;
    }
    triangles.emplace_back(polygon[left[0]], polygon[left[1]], polygon[left[2]]);
}

}  // namespace spinel
