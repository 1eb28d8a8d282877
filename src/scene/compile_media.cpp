#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "core/parallel.h"
#include "geometry/volume/black_body.h"
#include "geometry/volume/grid_builder.h"
#include "geometry/volume/noise_bounds.h"
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

mat4x3 world_to_index(const Compilation& c, int grid, const mat4x3& object_to_world) {
    return affine_inverse(affine_product(object_to_world, c.scene.grids[std::size_t(grid)].index_to_local));
}

// The bunny's two have offsets of their own: max(0, ½ + ½·strength·N) and max(0, 5·strength·(½ + ½·F) − 2).
void set_noise(const Erosion& erosion, kernels::Medium& record) {
    record.noise_frequency = erosion.frequency;
    record.noise_octaves = uint(erosion.octaves);
    record.noise_drift = erosion.drift + erosion.time * erosion.velocity;
    record.noise_gain = erosion.gain;
    record.noise_lacunarity = erosion.lacunarity;
    record.noise_offset = erosion.offset;
    record.noise_scale = erosion.strength;
    record.noise = kernels::NOISE_VALUE;
    switch (erosion.kind) {
        case Erosion::Kind::none: record.noise = kernels::NOISE_NONE; break;
        case Erosion::Kind::value_noise: break;
        case Erosion::Kind::perlin: record.noise = kernels::NOISE_PERLIN; break;
        case Erosion::Kind::simplex: record.noise = kernels::NOISE_SIMPLEX; break;
        case Erosion::Kind::value:
            record.noise_octaves = 1;
            record.noise_offset = 0.5f;
            record.noise_scale = 0.5f * erosion.strength;
            break;
        case Erosion::Kind::fbm:
            record.noise_gain = 0.5f;
            record.noise_lacunarity = 2;
            record.noise_offset = 2.5f * erosion.strength - 2;
            record.noise_scale = 2.5f * erosion.strength;
            break;
    }
}

// Cells no greater than a cell of the noise's lattice know something of it; most_cells bounds their number.
float noise_cell(const kernels::DensityGrid& grid, float frequency) {
    constexpr float most_cells = 1 << 21;
    float edge = float(grid.majorant_cell);
    const vec3 size(grid.size);
    const float lattice = std::min({size.x, size.y, size.z}) / frequency;
    const auto count = [&](float e) {
        const vec3 cells = glm::ceil(size / e);
        return cells.x * cells.y * cells.z;
    };
    while (edge > lattice && count(0.5f * edge) <= most_cells) edge *= 0.5f;
    return edge;
}

// Bounds of the density, cell by cell: of the grid's value where there is no noise, else times the factor's, found by
// intervals.
Result<void> add_majorants(Compilation& c, kernels::Medium& record) {
    const kernels::DensityGrid grid = c.out.grids[record.grid];
    const bool noise = record.noise != kernels::NOISE_NONE;
    record.majorant_cell = noise ? noise_cell(grid, record.noise_frequency) : float(grid.majorant_cell);
    const ivec3 m = record.majorant_size = ivec3(glm::ceil(vec3(grid.size) / record.majorant_cell));
    const std::size_t layer = std::size_t(m.x) * std::size_t(m.y), cells = layer * std::size_t(m.z);
    const Result<uint> first = pool_place(c.out.floats.size(), 2 * cells, NUMBERS);
    if (!first) return first.error();
    record.majorant_first = *first;
    record.minorant_first = uint(*first + cells);
    c.out.floats.resize(c.out.floats.size() + 2 * cells);
    std::vector<float>& floats = c.out.floats;
    kernels::SceneView view = {};
    view.words.at = c.out.words.data();
    parallel_for(std::size_t(m.z), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t cell = begin * layer; cell < end * layer; ++cell) {
            ValueBounds b;
            vec3 lower(0);
            if (noise) {
                const ivec3 at(int(cell % std::size_t(m.x)), int(cell / std::size_t(m.x) % std::size_t(m.y)),
                               int(cell / layer));
                lower = vec3(at) * record.majorant_cell;
                b = grid_bounds(view, grid, lower, lower + record.majorant_cell);
            } else {
                b = {floats[grid.minorant_first + cell], floats[grid.majorant_first + cell]};
            }
            b = {kernels::scaled_density(record, b.least), kernels::scaled_density(record, b.most)};
            if (noise && b.most > 0) {
                const vec3 scale = record.noise_frequency / vec3(grid.size);
                const Interval n = noise_bounds(record.noise, lower * scale + record.noise_drift,
                                                (lower + record.majorant_cell) * scale + record.noise_drift,
                                                record.noise_octaves, record.noise_gain, record.noise_lacunarity);
                const float at_low = record.noise_offset + record.noise_scale * n.low;
                const float at_high = record.noise_offset + record.noise_scale * n.high;
                b.least *= std::max(0.0f, std::min(at_low, at_high));
                b.most *= std::max(0.0f, std::max(at_low, at_high));
            }
            floats[record.majorant_first + cell] = b.most;
            floats[record.minorant_first + cell] = b.least;
        }
    });
    return {};
}

// Linear colour of a black body by its temperature, relative to the luminance it has at the reference: what its medium
// glows. Entries rise evenly up to the greatest temperature that the grid has.
Result<void> add_temperature(Compilation& c, const Medium& medium, const mat4x3& object_to_world,
                             kernels::Medium& record) {
    const Result<uint> grid = add_grid(c, medium.temperature);
    if (!grid) return grid.error();
    record.temperature_grid = *grid;
    record.world_to_temperature = world_to_index(c, medium.temperature, object_to_world);
    const GridSamples& samples = *c.scene.grids[std::size_t(medium.temperature)].samples;
    const auto kelvin = [&](float value) { return medium.temperature_scale * value + medium.temperature_offset; };
    const float hottest = std::max({kelvin(samples.minimum()), kelvin(samples.maximum()), 1.0f});
    const float entries_per_kelvin = float(kernels::TEMPERATURE_ENTRIES - 1) / hottest;
    record.temperature_scale = medium.temperature_scale * entries_per_kelvin;
    record.temperature_offset = medium.temperature_offset * entries_per_kelvin;
    std::vector<float> table;
    for (uint i = 0; i < kernels::TEMPERATURE_ENTRIES; ++i) {
        const vec3 color = black_body(float(i) / entries_per_kelvin, medium.temperature_reference);
        table.insert(table.end(), {color.x, color.y, color.z});
    }
    const Result<uint> first = append_pool(c.out.floats, table, NUMBERS);
    if (!first) return first.error();
    record.temperature_first = *first;
    return {};
}

}  // namespace

Result<uint> add_grid(Compilation& c, int index) {
    if (index < 0) return NONE;
    uint& known = c.grid_of[std::size_t(index)];
    if (known != NONE) return known;
    const Grid& grid = c.scene.grids[std::size_t(index)];
    const Result<kernels::DensityGrid> record = append_grid(grid, c.out.words, c.out.floats);
    if (!record) return Error{fmt::format("volume '{}' {}", grid.name, record.error().message)};
    c.out.grids.push_back(*record);
    return known = uint(c.out.grids.size() - 1);
}

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
    record.density_scale = 1;
    record.albedo_grid = NONE;
    record.temperature_grid = NONE;
    record.world_to_albedo = mat4x3(1);
    record.world_to_temperature = mat4x3(1);
    record.emission_rate = kernels::is_black(medium.emission) ? 0.0f : c.emission_rate;
    if (medium.grid >= 0) {
        const Result<uint> grid = add_grid(c, medium.grid);
        if (!grid) return grid.error();
        record.grid = *grid;
        record.world_to_grid = world_to_index(c, medium.grid, object_to_world);
        const vec2 range = medium.density_range;
        record.density_scale = 1.0f / (range.y - range.x);
        record.density_offset = -range.x * record.density_scale;
        set_noise(medium.erosion, record);
        // Wherever the medium is placed, its bounds are the same.
        auto [known, fresh] = c.majorants.try_emplace(index, record);
        if (fresh)
            if (Result<void> added = add_majorants(c, known->second); !added) return added.error();
        record.majorant_size = known->second.majorant_size;
        record.majorant_first = known->second.majorant_first;
        record.minorant_first = known->second.minorant_first;
        record.majorant_cell = known->second.majorant_cell;
    }
    if (medium.albedo >= 0) {
        const Result<uint> grid = add_grid(c, medium.albedo);
        if (!grid) return grid.error();
        record.albedo_grid = *grid;
        record.world_to_albedo = world_to_index(c, medium.albedo, object_to_world);
    }
    if (medium.temperature >= 0)
        if (Result<void> added = add_temperature(c, medium, object_to_world, record); !added) return added.error();
    const bool scatters = glm::any(glm::greaterThan(medium.scattering, vec3(0)));
    const bool emits = glm::any(glm::greaterThan(medium.emission, vec3(0)));
    if (!scatters && !emits && medium.grid < 0) record.flags |= kernels::MEDIUM_ABSORBS_ONLY;
    return add_medium(c, record);
}

}  // namespace spinel
