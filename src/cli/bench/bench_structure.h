#pragma once
// What `spinel bench` puts side by side: structures that answer the same rays.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "geometry/voxels/dense_walk.h"
#include "kernels/mesh_triangles.h"
#include "scene/compiled_scene.h"
#include "spinel/voxels.h"

namespace spinel::cli {

struct BenchStructure {
    std::string name;
    double build_ms = 0;
    double bytes = 0;  // of the structure alone: topology, not what the hits look like
    // Answers rays, a multiple of eight: t, within 1e-4 of it, and of voxels the cell, are compared; `instance` is NONE
    // for a miss.
    std::function<void(std::span<const kernels::Ray>, kernels::Hit*)> closest;
    std::function<void(std::span<const kernels::Ray>, kernels::Hit*)> any = {};  // missing: closest will do
    std::size_t stride = 1;                                                      // slow ones take every so many groups
    // Of structures of meshes:
    double build_ms_two_threads = 0;  // 0: not measured
    double refit_ms = 0;              // of the structure alone, one thread; 0: it has to be built anew
    double sah_cost = 0;  // what a ray that meets the bounds is expected to cost, in triangle tests; 0: unknown
    std::uint32_t depth = 0;
    std::string preset = {};                                                      // of the builder, if it has several
    std::function<kernels::WalkCount(const kernels::Ray&, bool any)> count = {};  // what a ray costs
    // The triangle of a hit, by its number in the mesh. Two structures that tell it are compared by it, and by t's
    // bits.
    std::function<kernels::uint(const kernels::Hit&)> triangle = {};
};

// Of the whole scene, in the order of the table; the first is what the others are compared with.
std::vector<BenchStructure> scene_structures(const CompiledScene& scene, const std::string& scene_structure,
                                             double build_ms);

// Of one set of voxels, in its own space. `tree` is the set that instance `instance` shows.
std::vector<BenchStructure> voxel_structures(const CompiledScene& scene, kernels::uint instance, const VoxelTree& tree);

// NanoVDB's hierarchical DDA, in leaves from voxel to voxel by their masks.
std::vector<BenchStructure> nanovdb_structures(const VoxelTree& tree);

}  // namespace spinel::cli
