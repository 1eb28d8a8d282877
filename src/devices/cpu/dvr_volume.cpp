#include "devices/cpu/dvr_volume.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "kernels/density.h"
#include "kernels/transfer.h"

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace spinel {

namespace {

// The two samples at an index and the next one, the first in the lower half.
Int8 pairs_at(const std::uint16_t* samples, Int8 index) {
#ifdef __AVX2__
    return Int8(_mm256_i32gather_epi32(reinterpret_cast<const int*>(samples), __m256i(index), 2));
#else
    Int8 pairs;
    for (int i = 0; i < 8; ++i) pairs[i] = int(samples[index[i]] | std::uint32_t(samples[index[i] + 1]) << 16);
    return pairs;
#endif
}

Float8 lower(Int8 pairs) { return to_float(pairs & 0xffff); }
Float8 upper(Int8 pairs) { return to_float(Int8(Uint8(pairs) >> 16)); }
Float8 between(Int8 pairs, Float8 x) { return mix8(lower(pairs), upper(pairs), x); }

constexpr int far_away = 255;

// Of an iso-surface: differences of two neighbours on either side of it, in units of the 16 bits.
constexpr float flat = 8;                // rounding turns a normal by some 1 / 40 of a radian there
constexpr float cliff = 65536.0f / 16;   // a step to values of another kind, such as those that mean "no data"
constexpr std::uint64_t most_flat = 16;  // one in so many may be flat: surfaces have neighbours along them everywhere

// Which entries of the transfer function are visible at all: how many below each are.
std::vector<std::uint32_t> visible_before(const kernels::SceneView& view, const kernels::DvrSettings& s) {
    std::vector<std::uint32_t> count(s.table_size + 1, 0);
    for (kernels::uint i = 0; i < s.table_size; ++i)
        count[i + 1] = count[i] + (view.floats.at[s.table_first + 4 * i + 3] > 0);
    return count;
}

}  // namespace

DvrVolume::DvrVolume(const kernels::SceneView& view, const kernels::DvrSettings& settings) {
    measure(view, settings);
    if (coarse_) return;
    copy_samples(view, view.grids.at[view.media.at[settings.medium].grid]);
    bricks_ = (size_ + (brick - 1)) / brick;
    blocks_ = (size_ + (block - 1)) / block;
    // A step may go as far as this along an axis.
    const glm::mat3 rows = glm::transpose(glm::mat3(view.media.at[settings.medium].world_to_grid));
    const float along = std::max({glm::length(rows[0]), glm::length(rows[1]), glm::length(rows[2])}) * settings.step;
    const int reach = 1 + int(std::ceil(std::max(along, 1.0f)));
    if (settings.mode == kernels::DVR_COMPOSITE) {
        const std::vector<std::uint32_t> visible = visible_before(view, settings);
        kernels::uint first = 0;
        while (first < settings.table_size && visible[first + 1] == 0) ++first;
        first_visible_ = float(first) - 1;
        const float last = float(settings.table_size - 1);
        find_distances(reach, [&](int least, int most) {
            const float from = std::clamp(float(least) * to_place_ + place_zero_, 0.0f, last);
            const float to = std::clamp(float(most) * to_place_ + place_zero_, 0.0f, last);
            return visible[std::size_t(std::ceil(to)) + 1] > visible[std::size_t(std::floor(from))];
        });
    } else if (settings.mode == kernels::DVR_ISOSURFACE) {
        const float iso = value_of(settings.iso);
        // A unit of rounding to each side.
        find_distances(reach, [&](int least, int most) { return float(least - 1) < iso && float(most + 1) >= iso; });
    } else {
        brick_ranges_ = ranges_of(bricks_, brick, 1);
        block_ranges_ = ranges_of(blocks_, block, 1);
    }
}

void DvrVolume::measure(const kernels::SceneView& view, const kernels::DvrSettings& settings) {
    const kernels::DensityGrid& grid = view.grids.at[view.media.at[settings.medium].grid];
    size_ = grid.size;
    // Whole numbers of a small range, as scanners write them, are kept as they are.
    std::vector<vec2> ranges(std::size_t(size_.z), vec2(1e30f, -1e30f));
    std::vector<std::uint8_t> whole(std::size_t(size_.z), 1);
    parallel_for(std::size_t(size_.z), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t z = begin; z < end; ++z)
            for (int y = 0; y < size_.y; ++y)
                for (int x = 0; x < size_.x; ++x) {
                    const float v = kernels::grid_sample(view, grid, {x, y, int(z)}, 0);
                    ranges[z] = {std::min(ranges[z].x, v), std::max(ranges[z].y, v)};
                    if (v != std::floor(v)) whole[z] = 0;
                }
    });
    float low = 1e30f, high = -1e30f;
    for (const vec2& r : ranges) low = std::min(low, r.x), high = std::max(high, r.y);
    const bool integers =
        high - low <= 65535 && std::all_of(whole.begin(), whole.end(), [](std::uint8_t w) { return w != 0; });
    low_ = low;
    unit_ = integers || !(high > low) ? 1.0f : (high - low) / 65535;
    to_place_ = unit_ * settings.scale;
    place_zero_ = (low - settings.low) * settings.scale;
    coarse_ = !integers && (to_place_ > 0.25f ||
                            (settings.mode == kernels::DVR_ISOSURFACE && is_iso_coarse(view, grid, settings.iso)));
}

// Only the slopes at the surface tell: the range of all values says nothing where most of a volume is empty.
bool DvrVolume::is_iso_coarse(const kernels::SceneView& view, const kernels::DensityGrid& grid, float iso) const {
    struct Count {
        std::uint64_t flat = 0, all = 0;
    };
    std::vector<Count> counts(std::size_t(size_.z));
    parallel_for(std::size_t(size_.z), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t z = begin; z < end; ++z) {
            Count count;
            const auto look = [&](float v, ivec3 neighbour) {
                const float w = kernels::grid_sample(view, grid, glm::min(neighbour, size_ - 1), 0);
                if ((v >= iso) == (w >= iso)) return;
                const float difference = std::abs(v - w);
                count.flat += difference < flat * unit_;
                count.all += difference < cliff * unit_;
            };
            for (int y = 0; y < size_.y; ++y)
                for (int x = 0; x < size_.x; ++x) {
                    const ivec3 at(x, y, int(z));
                    const float v = kernels::grid_sample(view, grid, at, 0);
                    look(v, at + ivec3(1, 0, 0));
                    look(v, at + ivec3(0, 1, 0));
                    look(v, at + ivec3(0, 0, 1));
                }
            counts[z] = count;
        }
    });
    Count sum;
    for (const Count& count : counts) sum.flat += count.flat, sum.all += count.all;
    return sum.flat * most_flat > sum.all;
}

void DvrVolume::copy_samples(const kernels::SceneView& view, const kernels::DensityGrid& grid) {
    row_ = size_.x + 2 * margin;
    layer_ = row_ * (size_.y + 2 * margin);
    const int layers = size_.z + 2 * margin;
    samples_.resize(std::size_t(layer_) * std::size_t(layers) + 2);
    parallel_for(std::size_t(layers), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k)
            for (int j = 0; j < size_.y + 2 * margin; ++j)
                for (int i = 0; i < row_; ++i) {
                    const ivec3 at = glm::clamp(ivec3(i, j, int(k)) - margin, ivec3(0), size_ - 1);
                    samples_[std::size_t(i) + std::size_t(row_) * std::size_t(j) + std::size_t(layer_) * k] =
                        std::uint16_t(std::lround((kernels::grid_sample(view, grid, at, 0) - low_) / unit_));
                }
    });
}

std::vector<std::uint32_t> DvrVolume::ranges_of(ivec3 count, int edge, int reach) const {
    std::vector<std::uint32_t> ranges(std::size_t(count.x) * std::size_t(count.y) * std::size_t(count.z));
    parallel_for(std::size_t(count.z), 1, [&](std::size_t begin, std::size_t end) {
        for (int k = int(begin); k < int(end); ++k)
            for (int j = 0; j < count.y; ++j)
                for (int i = 0; i < count.x; ++i) {
                    const ivec3 lo = glm::max(ivec3(i, j, k) * edge - reach, ivec3(0));
                    const ivec3 hi = glm::min((ivec3(i, j, k) + 1) * edge + reach, size_);
                    std::uint16_t least = 65535, most = 0;
                    for (int z = lo.z; z < hi.z; ++z)
                        for (int y = lo.y; y < hi.y; ++y) {
                            const std::uint16_t* row = samples_.data() + margin +
                                                       std::size_t(row_) * std::size_t(y + margin) +
                                                       std::size_t(layer_) * std::size_t(z + margin);
                            for (int x = lo.x; x < hi.x; ++x) {
                                least = std::min(least, row[x]);
                                most = std::max(most, row[x]);
                            }
                        }
                    ranges[std::size_t(i) +
                           std::size_t(count.x) * (std::size_t(j) + std::size_t(count.y) * std::size_t(k))] =
                        least | std::uint32_t(most) << 16;
                }
    });
    return ranges;
}

// Bricks whose values do not matter are empty; the distance to others is that of a king's moves.
void DvrVolume::find_distances(int reach, const std::function<bool(int, int)>& matters) {
    const std::vector<std::uint32_t> ranges = ranges_of(bricks_, brick, reach);
    distances_.resize(ranges.size() + 3);  // gathers read four bytes
    for (std::size_t i = 0; i < ranges.size(); ++i)
        distances_[i] = matters(int(ranges[i] & 0xffff), int(ranges[i] >> 16)) ? 0 : far_away;
    // Along each axis in turn: the distance of a king's moves is the greatest of the three.
    const std::size_t strides[3] = {1, std::size_t(bricks_.x), std::size_t(bricks_.x) * std::size_t(bricks_.y)};
    std::vector<std::uint8_t> line;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3, count = bricks_[axis];
        line.resize(std::size_t(count));
        for (int a = 0; a < bricks_[u]; ++a)
            for (int b = 0; b < bricks_[v]; ++b) {
                std::uint8_t* at = distances_.data() + std::size_t(a) * strides[u] + std::size_t(b) * strides[v];
                for (int i = 0; i < count; ++i) {
                    int best = far_away;
                    // Nothing nearer lies beyond what is found already.
                    for (int d = 0; d < best && (i - d >= 0 || i + d < count); ++d) {
                        if (i - d >= 0) best = std::min(best, std::max(d, int(at[std::size_t(i - d) * strides[axis]])));
                        if (i + d < count)
                            best = std::min(best, std::max(d, int(at[std::size_t(i + d) * strides[axis]])));
                    }
                    line[std::size_t(i)] = std::uint8_t(best);
                }
                for (int i = 0; i < count; ++i) at[std::size_t(i) * strides[axis]] = line[std::size_t(i)];
            }
    }
}

DvrVolume::Cell DvrVolume::cell(const Vec8& p) const {
    const Float8 zero = splat(0.0f);
    // Sample i sits at i + ½.
    const Float8 x = minimum(maximum(p.x, zero), splat(float(size_.x))) + (float(margin) - 0.5f);
    const Float8 y = minimum(maximum(p.y, zero), splat(float(size_.y))) + (float(margin) - 0.5f);
    const Float8 z = minimum(maximum(p.z, zero), splat(float(size_.z))) + (float(margin) - 0.5f);
    const Int8 i = to_int(x), j = to_int(y), k = to_int(z);
    return {i + j * row_ + k * layer_, x - to_float(i), y - to_float(j), z - to_float(k)};
}

Float8 DvrVolume::value(const Vec8& p) const {
    const Cell c = cell(p);
    const std::uint16_t* s = samples_.data();
    const Float8 low = mix8(between(pairs_at(s, c.index), c.x), between(pairs_at(s, c.index + row_), c.x), c.y);
    const Float8 high =
        mix8(between(pairs_at(s, c.index + layer_), c.x), between(pairs_at(s, c.index + layer_ + row_), c.x), c.y);
    return mix8(low, high, c.z);
}

Vec8 DvrVolume::gradient(const Vec8& p) const {
    const Cell c = cell(p);
    const std::uint16_t* s = samples_.data();
    // Rows of four samples along x through the cell's four edges: value in the middle and slope.
    const auto value_and_slope = [&](int offset, Float8& slope) {
        const Int8 left = pairs_at(s, c.index + (offset - 1)), right = pairs_at(s, c.index + (offset + 1));
        const Float8 v0 = upper(left), v1 = lower(right);
        slope = mix8(v1 - lower(left), upper(right) - v0, c.x);
        return mix8(v0, v1, c.x);
    };
    Float8 s00, s10, s01, s11;
    const Float8 v00 = value_and_slope(0, s00), v10 = value_and_slope(row_, s10);
    const Float8 v01 = value_and_slope(layer_, s01), v11 = value_and_slope(layer_ + row_, s11);
    const auto value = [&](int offset) { return between(pairs_at(s, c.index + offset), c.x); };
    const Float8 below0 = value(-row_), above0 = value(2 * row_);
    const Float8 below1 = value(layer_ - row_), above1 = value(layer_ + 2 * row_);
    const Float8 before0 = value(-layer_), before1 = value(-layer_ + row_);
    const Float8 behind0 = value(2 * layer_), behind1 = value(2 * layer_ + row_);
    return {mix8(mix8(s00, s10, c.y), mix8(s01, s11, c.y), c.z),
            mix8(mix8(v10 - below0, above0 - v00, c.y), mix8(v11 - below1, above1 - v01, c.y), c.z),
            mix8(mix8(v01 - before0, v11 - before1, c.y), mix8(behind0 - v00, behind1 - v10, c.y), c.z)};
}

Int8 DvrVolume::index_of(ivec3 count, int edge, const Vec8& p) {
    const Float8 zero = splat(0.0f);
    const float scale = 1.0f / float(edge);
    const Int8 i = minimum(to_int(maximum(p.x, zero) * scale), splat(count.x - 1));
    const Int8 j = minimum(to_int(maximum(p.y, zero) * scale), splat(count.y - 1));
    const Int8 k = minimum(to_int(maximum(p.z, zero) * scale), splat(count.z - 1));
    return i + count.x * (j + count.y * k);
}

Int8 DvrVolume::distance(const Vec8& p) const { return gather(distances_.data(), index_of(bricks_, brick, p)); }

DvrVolume::Range DvrVolume::range(const std::vector<std::uint32_t>& ranges, ivec3 count, int edge,
                                  const Vec8& p) const {
    const Int8 both = Int8(gather(ranges.data(), index_of(count, edge, p)));
    return {lower(both), upper(both)};
}

}  // namespace spinel
