#pragma once
// How structures of meshes grow with the number of triangles.

#include "cli/bench/bench_report.h"

namespace spinel::cli {

// The scene's largest mesh, as its first object that shows it stands, and coarser versions of about a quarter of the
// triangles each, as long as it can be made coarser; empty where there is no mesh.
Result<std::vector<ScalingRow>> bench_scaling(const Scene& scene, const MeshBench& options, int edge);

}  // namespace spinel::cli
