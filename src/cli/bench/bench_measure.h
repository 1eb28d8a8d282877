#pragma once
// Structures against one set of rays: how fast they are, what they count, and whether they see the same.

#include <functional>
#include <string>
#include <vector>

#include "cli/bench/bench_structure.h"

namespace spinel::cli {

// A row of the table, of `--json` and of the report.
struct BenchRow {
    std::string subject, structure, preset, rays;
    double build_ms = 0, build_ms_two_threads = 0, refit_ms = 0, sah_cost = 0;  // 0: unknown
    std::uint32_t depth = 0;
    double bytes = 0, mrays_per_s = 0;
    double nodes_per_ray = -1, boxes_per_ray = -1, tests_per_ray = -1;  // below 0: not counted
    double differing = -1;  // share of rays that see something else than the first structure does; below 0: it is that
};

// Processor time of the whole program so far.
double processor_seconds();

// The median of three builds of one thing, in milliseconds; `build` returns the processor seconds that count. Two
// before them, which pay for memory and threads that are kept, are left out.
double median_build_ms(const std::function<double()>& build);

class Measurement {
  public:
    // `first` says what there is to be seen.
    Measurement(std::string subject, std::string kind, const std::vector<kernels::Ray>& rays, bool any, int repeats,
                const BenchStructure& first);

    // Measures one structure; nothing where there are no rays.
    void add(const BenchStructure& structure, std::vector<BenchRow>& rows) const;

  private:
    std::string subject_, kind_;
    const std::vector<kernels::Ray>& rays_;
    bool any_;
    int repeats_;
    std::string first_;  // by name and preset
    bool exact_;
    std::vector<kernels::Hit> expected_;
};

}  // namespace spinel::cli
