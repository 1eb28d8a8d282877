#pragma once
// Look-ups in a volume: the kernel's bricks beside NanoVDB's trilinear sampler, on the same samples and places.

#include <string>
#include <vector>

#include "scene/compiled_scene.h"

namespace spinel::cli {

struct LookUpRow {
    std::string structure;  // "bricks", "nanovdb"
    std::string places;     // "random", or "coherent": along rays in steps of half a sample
    double mlookups_per_s = 0;
    double bytes = 0;            // of the samples and what finds them
    double bytes_per_voxel = 0;  // of those that differ from the background
    double difference = 0;       // greatest, of any look-up from NanoVDB's
};

// One thread; medians of interleaved runs, in processor time. `record` is the compiled grid of `grid`, of one channel.
// Look-ups are trilinear, whatever the record's filter.
std::vector<LookUpRow> measure_look_ups(const CompiledScene& scene, kernels::DensityGrid record, const Grid& grid,
                                        int repeats);

}  // namespace spinel::cli
