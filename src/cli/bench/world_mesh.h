#pragma once
// All meshes of a scene as one, in world space: what `spinel bench` gives to structures that know triangles alone, so
// that all of them answer the same rays.

#include <vector>

#include "cli/bench/bench_structure.h"
#include "spinel/scene.h"

namespace spinel::cli {

struct WorldMesh {
    std::vector<vec3> positions;
    std::vector<uvec3> indices;  // of triangles with an area
    std::vector<kernels::Triangle> triangles;
    vec3 lower = vec3(kernels::INFINITE), upper = vec3(-kernels::INFINITE);
};

// No triangles if anything of the scene is no mesh: rays would see something else than the scene's do.
WorldMesh world_mesh(const Scene& scene);

// The wide hierarchy and its compact layout by each preset, one ray at a time, and by the default one eight together.
// The mesh must outlive what is returned.
std::vector<BenchStructure> wide_structures(const WorldMesh& mesh);

// Embree by its builds and modes; nothing where Spinel was built without it.
std::vector<BenchStructure> embree_structures(const WorldMesh& mesh);

}  // namespace spinel::cli
