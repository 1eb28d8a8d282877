#pragma once
// What build_split_bvh() chooses between: planes that part the references to primitives below a node, and what they
// are expected to cost.

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <span>

#include "accel/signed_bounds.h"
#include "accel/split_bvh.h"

namespace spinel::split {

constexpr int max_bins = 32;

// A primitive, or a part of one: its bounds, and its index where they leave a lane idle.
class alignas(32) Reference {
  public:
    Reference() = default;
    Reference(SignedBounds bounds, std::uint32_t primitive) {
        bounds.store(lanes_.data());
        lanes_[3] = lanes_[7] = std::bit_cast<float>(primitive | tag);
    }
    SignedBounds bounds() const { return SignedBounds::load(lanes_.data()); }
    std::uint32_t primitive() const { return std::bit_cast<std::uint32_t>(lanes_[3]) & ~tag; }
    // Twice the centre along an axis; may be beyond what floats hold.
    float center2(int axis) const { return lanes_[std::size_t(axis) + 4] - lanes_[std::size_t(axis)]; }
    float lower(int axis) const { return -lanes_[std::size_t(axis)]; }
    float upper(int axis) const { return lanes_[std::size_t(axis) + 4]; }

  private:
    // Makes a float of usual size of any index, as processors take long over the tiniest.
    static constexpr std::uint32_t tag = 0x30000000;
    static_assert(kernels::BVH_MAX_PRIMITIVES <= tag && (tag & (kernels::BVH_MAX_PRIMITIVES - 1)) == 0);

    std::array<float, 8> lanes_;
};

// References of a subtree with their bounds.
struct Record {
    SignedBounds bounds;
    SignedBounds centers;
    std::span<Reference> references;
    std::size_t growth = 0;  // how many more references the subtree may come to
    int depth = 0;

    void extend(const Reference& reference) {
        bounds.extend(reference.bounds());
        centers.extend(reference.bounds().center());
    }
};

// What maps positions to bins, 0 … count − 1, the same way whenever asked.
struct Binning {
    int count;
    Float4 offset, scale;  // scale 0: positions do not spread along that axis

    Binning(SignedBounds range, int bins) : count(bins), offset(range.negated_lower()), scale(0.0f) {
        // A hair less than `bins`, so that the last position is in the last bin.
        const Float4 zero(0.0f), s = Float4(0.9999f * float(bins)) / extent_of(range);
        scale = where_less(s, Float4(std::numeric_limits<float>::infinity()), where_less(zero, s, s, zero), zero);
        // Also where the extent is infinite; then nothing may be subtracted either.
        offset = where_less(zero, scale, offset, zero);
    }
    // In bins, of the negated position.
    Float4 place(Float4 negated) const { return (offset - negated) * scale; }
};

struct Plane {
    int axis = -1;  // none
    int bin = 0;    // bins below go left
    float cost = std::numeric_limits<float>::infinity();
    bool spatial = false;
    SignedBounds left = {}, right = {};  // of the children
};

// How the references of a node are put in bins by their centres.
inline Binning center_binning(const Record& record, const SplitBvhOptions& options) {
    const std::size_t bins = std::min(std::size_t(options.bin_count), 4 + record.references.size() / 16);
    return {record.centers, int(bins)};
}
// References whose centres lie in bins below go left as they are.
Plane best_object_plane(const Record& record, const SplitBvhOptions& options);

// Where a spatial plane before a bin lies.
float spatial_position(const Record& record, int axis, int bin);
// References on both sides are clipped.
Plane best_spatial_plane(const Record& record, const SplitBvhOptions& options, const ClipPrimitive& clip);

inline bool holds_something(const Box& b) {
    return b.lower.x <= b.upper.x && b.lower.y <= b.upper.y && b.lower.z <= b.upper.z;
}

}  // namespace spinel::split
