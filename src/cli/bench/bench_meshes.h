#pragma once
// Every acceleration structure of meshes on the rays of one scene.

#include "cli/bench/bench_measure.h"
#include "cli/bench/bench_rays.h"

namespace spinel::cli {

struct MeshBench {
    std::vector<std::string> structures;  // names of rows; empty: all
    std::string triangle_test;            // empty: the scene's
    int repeats = 5;
    int heat_edge = 0;  // pixels of the heat maps; 0: none
};

struct HeatMap {
    std::string structure;
    int edge = 0;
    std::vector<std::uint32_t> counts;  // steps, boxes and tests of each pixel's ray, rows from above
};

// The scene whole, compiled anew for each structure; `rays` are those of the first. Rows of the subject "meshes".
Result<std::vector<HeatMap>> bench_meshes(const Scene& scene, const BenchRays& rays, const MeshBench& options,
                                          std::vector<BenchRow>& rows);

}  // namespace spinel::cli
