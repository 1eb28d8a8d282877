#include "accel/split_planes.h"

namespace spinel::split {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr int spatial_bins = 16;

// Of each bin along each axis, what lies in it.
using BinBounds = std::array<std::array<SignedBounds, 3>, max_bins>;
struct alignas(16) BinCounts : std::array<std::array<std::int32_t, 4>, max_bins> {};

void clear(BinBounds& bounds, int bins) {
    for (int i = 0; i < bins; ++i) bounds[std::size_t(i)].fill(SignedBounds());
}
void clear(BinCounts& counts, int bins) {
    for (int i = 0; i < bins; ++i) counts[std::size_t(i)].fill(0);
}

Float4 half_areas(const std::array<SignedBounds, 3>& b) { return spinel::half_areas(b[0], b[1], b[2], b[2]); }

// Of the planes between bins, the one with the least expected cost, along all axes at once; `begins` counts primitives
// by the bin that they begin in, from which they go left, and `ends` by the one that they end in.
Plane least_cost(const Record& record, const SplitBvhOptions& options, int bins, const BinBounds& bounds,
                 const BinCounts& begins, const BinCounts& ends) {
    const int block_bits = std::countr_zero(options.block);
    const auto blocks = [&](const std::array<std::int32_t, 4>& counts) {
        alignas(16) std::array<float, 4> out;
        for (std::size_t a = 0; a < 4; ++a) out[a] = float((counts[a] + std::int32_t(options.block) - 1) >> block_bits);
        return Float4::load(out.data());
    };
    const auto add = [](std::array<std::int32_t, 4>& sum, const std::array<std::int32_t, 4>& counts) {
        for (std::size_t a = 0; a < 4; ++a) sum[a] += counts[a];
    };
    std::array<Float4, max_bins> right_cost;
    std::array<SignedBounds, 3> side;
    std::array<std::int32_t, 4> count{};
    for (auto i = std::size_t(bins - 1); i > 0; --i) {
        for (std::size_t axis = 0; axis < 3; ++axis) side[axis].extend(bounds[i][axis]);
        add(count, ends[i]);
        right_cost[i] = half_areas(side) * blocks(count);
    }
    side.fill(SignedBounds());
    count.fill(0);
    Float4 least(infinity), at(0.0f);
    for (std::size_t i = 1; i < std::size_t(bins); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) side[axis].extend(bounds[i - 1][axis]);
        add(count, begins[i - 1]);
        const Float4 cost = half_areas(side) * blocks(count) + right_cost[i];
        at = where_less(cost, least, Float4(float(i)), at);  // NaN, of an empty side, never wins
        least = where_less(cost, least, cost, least);
    }
    Plane best;
    const auto costs = lanes_of(least), places = lanes_of(at);
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (costs[axis] < best.cost) {
            best.axis = int(axis);
            best.bin = int(places[axis]);
            best.cost = costs[axis];
        }
    if (best.axis < 0) return best;
    const float area = half_area(record.bounds);
    best.cost = options.traversal_cost + best.cost * (area > 0 ? 1.0f / area : 0.0f);
    for (int i = 0; i < bins; ++i)
        (i < best.bin ? best.left : best.right).extend(bounds[std::size_t(i)][std::size_t(best.axis)]);
    return best;
}

}  // namespace

Plane best_object_plane(const Record& record, const SplitBvhOptions& options) {
    const Binning binning = center_binning(record, options);
    BinBounds bounds;
    BinCounts counts;
    clear(bounds, binning.count);
    clear(counts, binning.count);
    for (const Reference& reference : record.references) {
        const SignedBounds b = reference.bounds();
        alignas(16) int at[4];
        store_truncated(binning.place(b.center().negated_lower()), at);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto bin = std::size_t(at[axis]);
            bounds[bin][axis].extend(b);
            ++counts[bin][axis];
        }
    }
    return least_cost(record, options, binning.count, bounds, counts, counts);
}

float spatial_position(const Record& record, int axis, int bin) {
    const float lower = lower_of(record.bounds)[axis], upper = upper_of(record.bounds)[axis];
    return lower + (upper - lower) * (float(bin) / float(spatial_bins));
}

Plane best_spatial_plane(const Record& record, const SplitBvhOptions& options, const ClipPrimitive& clip) {
    const Binning binning(record.bounds, spatial_bins);
    BinBounds bounds;
    BinCounts begins, ends;
    clear(bounds, spatial_bins);
    clear(begins, spatial_bins);
    clear(ends, spatial_bins);
    std::array<std::array<float, spatial_bins>, 3> planes;
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < spatial_bins; ++i)
            planes[std::size_t(axis)][std::size_t(i)] = spatial_position(record, axis, i);
    for (const Reference& reference : record.references) {
        alignas(16) int first[4], last[4];
        const SignedBounds whole = reference.bounds();
        store_truncated(binning.place(whole.negated_lower()), first);
        store_truncated(binning.place(Float4(0.0f) - whole.upper()), last);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto begin = std::size_t(first[axis]), end = std::size_t(last[axis]);
            ++begins[begin][axis];
            ++ends[end][axis];
            if (begin == end) {
                bounds[begin][axis].extend(whole);
                continue;
            }
            Box rest = {lower_of(whole), upper_of(whole)};
            for (std::size_t i = begin; i < end; ++i) {
                Box below, above;
                clip(reference.primitive(), rest, int(axis), planes[axis][i + 1], below, above);
                if (holds_something(below)) bounds[i][axis].extend(signed_bounds(below));
                rest = above;
            }
            if (holds_something(rest)) bounds[end][axis].extend(signed_bounds(rest));
        }
    }
    Plane best = least_cost(record, options, spatial_bins, bounds, begins, ends);
    best.spatial = true;
    return best;
}

}  // namespace spinel::split
