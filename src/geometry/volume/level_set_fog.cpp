#include "geometry/volume/level_set_fog.h"

#include <algorithm>
#include <cmath>

namespace spinel {

Grid fog_of_level_set(const Grid& level_set) {
    const GridSamples& distances = *level_set.samples;
    const float band = level_set.background != 0 ? std::abs(level_set.background) : -distances.minimum();
    const ivec3 counts = distances.brick_counts();
    const auto samples = build_grid(distances.size(), 1, [&](ivec3 lower, std::span<float> fog) {
        const ivec3 b = lower / GridSamples::brick_edge;
        const std::size_t entry =
            std::size_t(b.x) + std::size_t(counts.x) * (std::size_t(b.y) + std::size_t(counts.y) * std::size_t(b.z));
        const std::span<const float> from = distances.brick(distances.table()[entry]);
        for (std::size_t i = 0; i < from.size(); ++i)
            fog[i] = band > 0 ? std::clamp(-from[i] / band, 0.0f, 1.0f) : 0.0f;
        return 0;
    });
    Grid fog = level_set;
    fog.samples = *samples;  // of the same size as those it is made of, and finite
    fog.filter = Filter::linear;
    fog.background = 0;
    fog.level_set = false;
    return fog;
}

}  // namespace spinel
