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

enum class TraceMethod {
    walk,         // as pictures are made: each ray through the structures that the scene was compiled into
    stream,       // all rays together from cell to cell of uniform grids; meshes have to be built into "grid"
    brute_force,  // the naive twin: every primitive in double precision, to test the others against
};

// A way to answer rays, by name: what meshes have to be built into (CompileOptions::accelerator), and how rays go.
struct Accelerator {
    std::string name;
    std::string description;
    std::string structure;  // of meshes
    TraceMethod method = TraceMethod::walk;
};

// All structures of meshes, the default first, and what answers rays in another way.
const std::vector<Accelerator>& accelerators();

// By name, or an error that lists what there is.
Result<const Accelerator*> find_accelerator(const std::string& name);

// How many rays were in which state in one pass of the streaming walk, all batches together.
struct StreamPass {
    std::uint64_t active = 0;    // have tested a cell's triangles and walk on
    std::uint64_t waiting = 0;   // stand in a cell whose triangles they test in this pass
    std::uint64_t inactive = 0;  // have found what they look for
    std::uint64_t overflow = 0;  // stand in a cell and find no room to test in this pass
    std::uint64_t dead = 0;      // have found nothing
};

struct TraceOptions {
    TraceMethod method = TraceMethod::walk;
    bool any = false;  // ask only whether something is hit: t = 0 if so, and all else as in a miss
    int threads = 0;   // 0: as many as the machine has
    std::vector<StreamPass>* passes = nullptr;  // of TraceMethod::stream: what is added to
};

// An interface without a material (the boundary of a mere volume) is no hit: the ray goes on behind it. Rays
// that are not finite, or without a direction, miss.
Result<std::vector<TraceHit>> trace_rays(const kernels::SceneView& scene, std::span<const TraceRay> rays,
                                         const TraceOptions& options = {});

}  // namespace spinel
