#pragma once
// Rays against the wide hierarchy of a mesh (kernels::WideUnit). The answer is that of kernels::triangle_watertight()
// asked of every triangle, bit for bit: the least t, and of triangles met at the same t the one with the lowest index.

#include "kernels/scene_view.h"

namespace spinel {

// What a walk needs of a mesh.
struct WideMesh {
    const kernels::WideUnit* units;  // the root
    glm::vec3 lower;                 // bounds of all its triangles
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

}  // namespace spinel
