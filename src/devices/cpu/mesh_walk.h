#pragma once
// Rays against the wide hierarchy of a mesh (kernels::WideUnit). The answer is that of kernels::triangle_watertight()
// asked of every triangle, bit for bit: the least t, and of triangles met at the same t the one with the lowest index.

#include "devices/cpu/packet_trace.h"
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
    // Where it stands; null if there is none.
    const float* block = nullptr;
    int lane = 0;
};

// cross(b − a, c − a) of the triangle that was hit.
glm::vec3 wide_normal(const WideHit& hit);

WideHit wide_closest(const WideMesh& mesh, const kernels::Ray& ray);
bool wide_any(const WideMesh& mesh, const kernels::Ray& ray);

// Eight rays, of which those count whose bit is set in `lanes`; they may be any, but are faster than one by one if they
// are coherent: of one octant, side by side. Hits of the others are left alone; returned are those that meet anything.
void wide_closest8(const WideMesh& mesh, const kernels::Ray rays[packet_size], unsigned lanes,
                   WideHit hits[packet_size]);
unsigned wide_any8(const WideMesh& mesh, const kernels::Ray rays[packet_size], unsigned lanes);

// Of hierarchies in the compact layout (accel/compact_bvh.h).
WideHit compact_closest(const WideMesh& mesh, const kernels::Ray& ray);
bool compact_any(const WideMesh& mesh, const kernels::Ray& ray);
glm::vec3 compact_normal(const WideHit& hit);

// The same for machines without AVX2, which the others are on them.
WideHit wide_closest_portable(const WideMesh& mesh, const kernels::Ray& ray);
bool wide_any_portable(const WideMesh& mesh, const kernels::Ray& ray);
WideHit compact_closest_portable(const WideMesh& mesh, const kernels::Ray& ray);
bool compact_any_portable(const WideMesh& mesh, const kernels::Ray& ray);

// Whether a mesh of a scene has more from packets than from one ray after the other.
bool walks_in_packets(const kernels::Mesh& mesh);

// As kernels::mesh_closest and mesh_any for each ray, in the mesh's space; returned are those that found something
// nearer than their t_max, to whose hits `instance` is written.
unsigned cpu_mesh_closest8(const kernels::SceneView& scene, kernels::uint mesh, kernels::uint instance,
                           const kernels::Ray rays[packet_size], unsigned lanes, kernels::Hit hits[packet_size]);
unsigned cpu_mesh_any8(const kernels::SceneView& scene, kernels::uint mesh, const kernels::Ray rays[packet_size],
                       unsigned lanes);

}  // namespace spinel
