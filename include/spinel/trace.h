#pragma once
// Batches of rays in, hits out.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "kernels/scene_view.h"

namespace spinel {

// A segment origin + t·direction, t in the open interval (t_min, t_max), in units of |direction|. A row of
// `rays.npy`.
struct TraceRay {
    glm::vec3 origin;
    float t_min;
    glm::vec3 direction;
    float t_max;
};
static_assert(sizeof(TraceRay) == 8 * 4);

// A row of `hits.npy`. A miss: t = +∞, instance, primitive and material = kernels::NONE, the rest 0.
struct TraceHit {
    float t;
    std::uint32_t instance;
    std::uint32_t primitive;  // mesh: the triangle in the user's order; voxels: palette index; box: face; else 0
    float u, v;        // mesh: barycentric weights of vertices 1 and 2; voxels, box, rectangle: place on the face
    float nx, ny, nz;  // geometric unit normal in world space, outwards
    std::int32_t ix, iy, iz;  // voxels: the cell, else 0
    std::uint32_t material;   // index into the scene's materials
};
static_assert(sizeof(TraceHit) == 12 * 4);

// A way to answer rays: a row of accelerators(). A mask of TRACE_… (kernels/device.h) selects instances.
struct Accelerator {
    const char* name;
    const char* description;
    kernels::Hit (*closest)(const kernels::SceneView& scene, const kernels::Ray& ray, kernels::uint mask);
    bool (*any)(const kernels::SceneView& scene, const kernels::Ray& ray, kernels::uint mask);
};

// One row for each accelerator; the first is the default.
std::span<const Accelerator> accelerators();

// By name, or an error that lists what there is.
Result<const Accelerator*> find_accelerator(const std::string& name);

struct TraceOptions {
    std::string accelerator = "bvh2";
    bool any = false;  // ask only whether something is hit: t = 0 if so, and all else as in a miss
    int threads = 0;   // 0: as many as the machine has
};

// An interface without a material (the boundary of a mere volume) is no hit: the ray goes on behind it. Rays
// that are not finite, or without a direction, miss.
Result<std::vector<TraceHit>> trace_rays(const kernels::SceneView& scene, std::span<const TraceRay> rays,
                                         const TraceOptions& options = {});

}  // namespace spinel
