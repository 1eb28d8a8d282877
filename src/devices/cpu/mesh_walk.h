#pragma once
// Rays against the wide hierarchy of a mesh (WideUnit). The answer is that of kernels::triangle_watertight()
// asked of every triangle, bit for bit: the least t, and of triangles met at the same t the one with the lowest index.

#include <algorithm>
#include <cmath>

#include "accel/wide_bvh.h"
#include "kernels/ray.h"

namespace spinel {

// What a walk needs of a mesh.
struct WideMesh {
    const WideUnit* units;  // the root
    glm::vec3 lower;        // bounds of all its triangles
    glm::vec3 upper;
};

struct WideHit {
    float t;                 // the ray's t_max if there is none
    float u, v;              // weights of vertices 1 and 2
    std::uint32_t triangle;  // NONE: nothing in (t_min, t_max)
};

WideHit wide_closest(const WideMesh& mesh, const kernels::Ray& ray);
bool wide_any(const WideMesh& mesh, const kernels::Ray& ray);

// The same for machines without AVX2, which the others are on them.
WideHit wide_closest_portable(const WideMesh& mesh, const kernels::Ray& ray);
bool wide_any_portable(const WideMesh& mesh, const kernels::Ray& ray);

// How far boxes are widened on all sides, so that none is missed that holds a triangle which triangle_watertight()
// finds, nor entered later than its t. Let e = 2⁻²⁴, and E be the greatest distance along an axis from the ray's origin
// to the farther side of the mesh. The test moves vertices by at most 10·e·E across the ray (Woop et al. 2013,
// section 3.3), its t is wrong by at most 13·e·E of the largest component; where rays meet planes is wrong by 2·e·E and
// e·|origin|.
inline float wide_padding(const WideMesh& mesh, const kernels::Ray& ray) {
    float extent = 0, far_off = 0;
    for (int a = 0; a < 3; ++a) {
        const float below = std::abs(mesh.lower[a] - ray.origin[a]), above = std::abs(mesh.upper[a] - ray.origin[a]);
        extent = std::max(extent, std::max(below, above));
        far_off = std::max(far_off, std::abs(ray.origin[a]));
    }
    return 0x1p-19f * extent + 0x1p-22f * far_off;
}

// 1/d, of a finite size: components of the direction that are 10⁸ times smaller than the largest are made as large as
// that, by which a ray moves less than wide_padding() on its way through the mesh.
inline glm::vec3 wide_inverse(glm::vec3 d) {
    const float tiny = 1e-8f * std::max(std::max(std::abs(d.x), std::abs(d.y)), std::abs(d.z));
    for (int a = 0; a < 3; ++a) d[a] = 1.0f / (std::abs(d[a]) < tiny ? std::copysign(tiny, d[a]) : d[a]);
    return d;
}

// A node is left by at most seven other children still to visit.
inline constexpr int wide_stack_size = 7 * 60 + 8;

}  // namespace spinel
