#pragma once
// Transfer functions of `dvr`: presets and colour maps by name, and the table that kernels read (kernels/transfer.h).

#include <vector>

#include "spinel/dvr.h"

namespace spinel {

// Points in the data's own units, at least two, their values rising. `lower` and `upper` bound what the data holds,
// but for a few stray values: they are the window of what is told over the window where `options` gives none.
std::vector<TransferPoint> transfer_points(const DvrOptions& options, float lower, float upper);

struct TransferTable {
    float low = 0;              // value of entry 0
    float scale = 1;            // entries a unit
    std::vector<float> values;  // size entries of four, then as many of their integrals
};
inline constexpr int transfer_size = 1024;

// Extinction is of a layer `layer` world units thick, of which the points tell the opacity.
TransferTable transfer_table(const std::vector<TransferPoint>& points, float layer, float opacity);

}  // namespace spinel
