#pragma once
// What `spinel bench` writes: a table, JSON, and a page with charts and heat maps.

#include <string>
#include <vector>

#include "cli/bench/bench_meshes.h"
#include "cli/bench/volume_bench.h"

namespace spinel::cli {

// One mesh, thinned out or cut finer, of so many triangles: how cost grows.
struct ScalingRow {
    std::string structure;
    std::size_t triangles = 0;
    double build_ms = 0, build_ms_two_threads = 0, mrays_per_s = 0, nodes_per_ray = 0, tests_per_ray = 0;
};

struct BenchReport {
    std::string input;
    int repeats = 0;
    std::size_t triangles = 0;  // of all meshes, each once
    std::vector<BenchRow> rows;
    std::vector<HeatMap> maps;
    std::vector<ScalingRow> scaling;
    std::vector<LookUpRow> look_ups;  // in the scene's first volume
};

std::string table_text(const BenchReport& report);
std::string rows_json(const BenchReport& report);

// One file that needs nothing else.
Result<void> write_html(const BenchReport& report, const std::string& file);

}  // namespace spinel::cli
