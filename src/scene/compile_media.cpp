#include <algorithm>
#include <cstring>
#include <string>

#include "core/parallel.h"
#include "kernels/density.h"
#include "scene/compilation.h"

namespace spinel {
namespace {

using kernels::NONE;
using kernels::uint;

// Records are plain bytes, filled from zero, so equal records have equal bytes.
template <class T>
uint add_shared(std::vector<T>& records, std::map<std::string, uint>& known, const T& record) {
    const auto [at, fresh] =
        known.try_emplace(std::string(reinterpret_cast<const char*>(&record), sizeof record), uint(records.size()));
    if (fresh) records.push_back(record);
    return at->second;
}

constexpr int majorant_cell = 4;  // samples; measured: finer costs steps, coarser costs null collisions

// Copies a grid's values and builds its majorants: the maximum over all samples that a look-up in the cell can touch.
Result<uint> add_grid(Compilation& c, int index) {
    uint& known = c.grid_of[std::size_t(index)];
    if (known != NONE) return known;
    const Grid& grid = c.scene.grids[std::size_t(index)];
    kernels::DensityGrid record = {};
    record.size = grid.size;
    record.filter_kind = grid.filter == Filter::nearest ? kernels::FILTER_NEAREST : kernels::FILTER_TRILINEAR;
    record.majorant_cell = majorant_cell;
    record.majorant_size = (grid.size + ivec3(majorant_cell - 1)) / majorant_cell;
    const Result<uint> values = append_pool(c.out.floats, grid.values, NUMBERS);
    if (!values) return values.error();
    record.value_first = *values;
    const ivec3 m = record.majorant_size;
    std::vector<float> majorants(std::size_t(m.x) * std::size_t(m.y) * std::size_t(m.z)), minorants(majorants.size());
    const auto value = [&](int x, int y, int z) {
        return grid.values[std::size_t(x) +
                           std::size_t(grid.size.x) * (std::size_t(y) + std::size_t(grid.size.y) * std::size_t(z))];
    };
    // Linear interpolation at index-space p reads samples floor(p − ½) and the next: one sample beyond the cell each
    // way.
    const int reach = grid.filter == Filter::nearest ? 0 : 1;
    parallel_for(std::size_t(m.z), 1, [&](std::size_t begin, std::size_t end) {
        for (int k = int(begin); k < int(end); ++k)
            for (int j = 0; j < m.y; ++j)
                for (int i = 0; i < m.x; ++i) {
                    const ivec3 lo = glm::max(ivec3(i, j, k) * majorant_cell - reach, ivec3(0));
                    const ivec3 hi = glm::min((ivec3(i, j, k) + 1) * majorant_cell + reach, grid.size);
                    float bound = 0, least = kernels::INFINITE;
                    for (int z = lo.z; z < hi.z; ++z)
                        for (int y = lo.y; y < hi.y; ++y)
                            for (int x = lo.x; x < hi.x; ++x) {
                                bound = std::max(bound, value(x, y, z));
                                least = std::min(least, value(x, y, z));
                            }
                    const std::size_t cell =
                        std::size_t(i) + std::size_t(m.x) * (std::size_t(j) + std::size_t(m.y) * std::size_t(k));
                    majorants[cell] = bound;
                    minorants[cell] = least;
                }
    });
    majorants.insert(majorants.end(), minorants.begin(), minorants.end());  // minorant_first() of kernels/density.h
    const Result<uint> first = append_pool(c.out.floats, majorants, NUMBERS);
    if (!first) return first.error();
    record.majorant_first = *first;
    c.out.grids.push_back(record);
    return known = uint(c.out.grids.size() - 1);
}

uint kernel_erosion(Erosion::Kind kind) {
    switch (kind) {
        case Erosion::Kind::value: return kernels::EROSION_VALUE;
        case Erosion::Kind::fbm: return kernels::EROSION_FBM;
        case Erosion::Kind::none: break;
    }
    return kernels::EROSION_NONE;
}

}  // namespace

uint add_medium(Compilation& c, const kernels::Medium& medium) { return add_shared(c.out.media, c.media, medium); }

uint add_interior(Compilation& c, const kernels::Interior& interior) {
    return add_shared(c.out.interiors, c.interiors, interior);
}

Result<uint> add_scene_medium(Compilation& c, int index, const mat4x3& object_to_world) {
    if (index < 0) return NONE;
    const Medium& medium = c.scene.media[std::size_t(index)];
    kernels::Medium record;
    std::memset(&record, 0, sizeof record);
    record.scattering = medium.scattering;
    record.absorption = medium.absorption;
    record.emission = medium.emission;
    record.g = medium.g;
    record.grid = NONE;
    record.world_to_grid = mat4x3(1);
    record.density_bound = 1;
    record.emission_rate = kernels::is_black(medium.emission) ? 0.0f : c.emission_rate;
    if (medium.grid >= 0) {
        const Result<uint> grid = add_grid(c, medium.grid);
        if (!grid) return grid.error();
        record.grid = *grid;
        record.world_to_grid =
            affine_inverse(affine_product(object_to_world, c.scene.grids[std::size_t(medium.grid)].index_to_local));
        record.erosion = kernel_erosion(medium.erosion.kind);
        record.erosion_strength = medium.erosion.strength;
        record.erosion_frequency = medium.erosion.frequency;
        record.erosion_octaves = uint(medium.erosion.octaves);
        record.erosion_drift = medium.erosion.drift;
        record.density_bound = kernels::erosion_bound(record.erosion, record.erosion_strength);
    }
    const bool scatters = glm::any(glm::greaterThan(medium.scattering, vec3(0)));
    const bool emits = glm::any(glm::greaterThan(medium.emission, vec3(0)));
    if (!scatters && !emits && medium.grid < 0) record.flags |= kernels::MEDIUM_ABSORBS_ONLY;
    return add_medium(c, record);
}

}  // namespace spinel
