#include "geometry/volume/grid_builder.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/parallel.h"
#include "core/pool.h"
#include "kernels/grids.h"

namespace spinel {
namespace {

constexpr int MAJORANT_CELL = 4;  // samples; measured: finer costs steps, coarser costs null collisions
constexpr std::string_view WORDS = "words of voxels, volumes, textures and tables";
constexpr std::string_view NUMBERS = "numbers of volumes and environment";

std::uint32_t storage_of(GridPrecision precision) {
    switch (precision) {
        case GridPrecision::half: return kernels::GRID_HALF;
        case GridPrecision::bits16: return kernels::GRID_BITS16;
        case GridPrecision::bits8: return kernels::GRID_BITS8;
        case GridPrecision::full: break;
    }
    return kernels::GRID_FLOAT;
}

std::uint32_t channel_words(std::uint32_t storage) {
    const auto volume = std::uint32_t(GridSamples::brick_volume);
    if (storage == kernels::GRID_HALF) return volume / 2;
    if (storage == kernels::GRID_BITS16) return 2 + volume / 2;
    if (storage == kernels::GRID_BITS8) return 2 + volume / 4;
    return volume;
}

// One channel of one brick.
void write_brick(std::span<const float> samples, std::uint32_t storage, std::uint32_t* words) {
    if (storage == kernels::GRID_FLOAT) {
        for (std::size_t i = 0; i < samples.size(); ++i) words[i] = std::bit_cast<std::uint32_t>(samples[i]);
        return;
    }
    if (storage == kernels::GRID_HALF) {
        for (std::size_t i = 0; i < samples.size(); i += 2)
            words[i / 2] = glm::packHalf2x16({samples[i], samples[i + 1]});
        return;
    }
    const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
    const std::uint32_t bits = storage == kernels::GRID_BITS16 ? 16 : 8, in_word = 32 / bits;
    const double codes = double((1u << bits) - 1), step = (double(*high) - double(*low)) / codes;
    words[0] = std::bit_cast<std::uint32_t>(*low);
    words[1] = std::bit_cast<std::uint32_t>(float(step));
    std::fill(words + 2, words + 2 + samples.size() / in_word, 0u);
    if (!(float(step) > 0)) return;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double code = std::round((double(samples[i]) - double(*low)) / double(float(step)));
        words[2 + i / in_word] |= std::uint32_t(std::clamp(code, 0.0, codes)) << (bits * (i % in_word));
    }
}

}  // namespace

ValueBounds grid_bounds(const kernels::SceneView& view, const kernels::DensityGrid& grid, vec3 lower, vec3 upper) {
    // Samples that a look-up at p reads: that of its cell, or from floor(p − ½) on one, or two, in either direction.
    const int reach = grid.filter_kind == kernels::FILTER_NEAREST    ? 0
                      : grid.filter_kind == kernels::FILTER_TRICUBIC ? 2
                                                                     : 1;
    const vec3 shift = reach > 0 ? vec3(0.5f) : vec3(0);
    const ivec3 last = grid.size - 1;
    const ivec3 lo = glm::clamp(ivec3(glm::floor(lower - shift)) - std::max(reach - 1, 0), ivec3(0), last);
    const ivec3 hi = glm::clamp(ivec3(glm::ceil(upper - shift)) - 1 + reach, lo, last);
    ValueBounds bounds{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
    for (int z = lo.z; z <= hi.z; ++z)
        for (int y = lo.y; y <= hi.y; ++y)
            for (int x = lo.x; x <= hi.x; ++x) {
                const float value = kernels::grid_sample(view, grid, {x, y, z}, 0);
                bounds.least = std::min(bounds.least, value);
                bounds.most = std::max(bounds.most, value);
            }
    return bounds;
}

Result<kernels::DensityGrid> append_grid(const Grid& grid, std::vector<std::uint32_t>& words,
                                         std::vector<float>& floats) {
    const GridSamples& samples = *grid.samples;
    kernels::DensityGrid record = {};
    record.size = samples.size();
    record.brick_counts = samples.brick_counts();
    record.storage = storage_of(grid.precision);
    record.channel_words = channel_words(record.storage);
    record.filter_kind = grid.filter == Filter::nearest ? kernels::FILTER_NEAREST
                         : grid.filter == Filter::cubic ? kernels::FILTER_TRICUBIC
                                                        : kernels::FILTER_TRILINEAR;
    record.background = grid.background;
    if (record.storage == kernels::GRID_HALF && std::max(samples.maximum(), -samples.minimum()) > 65504.0f)
        return Error{"has values beyond the 65504 that a half can hold"};

    const auto channels = std::size_t(samples.channels());
    const std::size_t brick_words = record.channel_words * channels;
    const Result<std::uint32_t> bricks = pool_place(words.size(), brick_words * samples.stored_count(), WORDS);
    if (!bricks) return bricks.error();
    words.resize(words.size() + brick_words * samples.stored_count());
    parallel_for(samples.stored_count(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t c = 0; c < channels; ++c)
                write_brick(
                    samples.brick(std::uint32_t(i)).subspan(c * GridSamples::brick_volume, GridSamples::brick_volume),
                    record.storage, words.data() + *bricks + i * brick_words + c * record.channel_words);
    });
    const Result<std::uint32_t> table = pool_place(words.size(), samples.table().size(), WORDS);
    if (!table) return table.error();
    record.table_first = *table;
    words.reserve(words.size() + samples.table().size());
    for (const std::uint32_t number : samples.table())
        words.push_back(std::uint32_t(*bricks + std::size_t(number) * brick_words));

    record.majorant_cell = MAJORANT_CELL;
    const ivec3 m = record.majorant_size = (record.size + (MAJORANT_CELL - 1)) / MAJORANT_CELL;
    const std::size_t cells = std::size_t(m.x) * std::size_t(m.y) * std::size_t(m.z);
    const Result<std::uint32_t> bounds = pool_place(floats.size(), 2 * cells, NUMBERS);
    if (!bounds) return bounds.error();
    record.majorant_first = *bounds;
    record.minorant_first = std::uint32_t(*bounds + cells);
    floats.resize(floats.size() + 2 * cells);
    kernels::SceneView view = {};
    view.words.at = words.data();
    parallel_for(std::size_t(m.z), 1, [&](std::size_t begin, std::size_t end) {
        std::size_t cell = begin * std::size_t(m.x) * std::size_t(m.y);
        for (int k = int(begin); k < int(end); ++k)
            for (int j = 0; j < m.y; ++j)
                for (int i = 0; i < m.x; ++i, ++cell) {
                    const vec3 lower(ivec3(i, j, k) * MAJORANT_CELL);
                    const ValueBounds b = grid_bounds(view, record, lower, lower + float(MAJORANT_CELL));
                    floats[record.majorant_first + cell] = b.most;
                    floats[record.minorant_first + cell] = b.least;
                }
    });
    return record;
}

}  // namespace spinel
