#include "accel/morton_grains.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "accel/signed_bounds.h"
#include "core/huge_pages.h"
#include "core/parallel.h"

namespace spinel {
namespace {

// Places along the curve: 12 bits for each axis above the index of the box, so that one number is sorted.
constexpr int axis_bits = 12, code_bits = 3 * axis_bits, index_bits = 64 - code_bits;
static_assert(std::uint64_t(1) << index_bits >= kernels::BVH_MAX_PRIMITIVES);
constexpr std::uint64_t index_mask = (std::uint64_t(1) << index_bits) - 1;

constexpr std::size_t chunk = 1 << 16;            // keys that are counted and moved together
constexpr std::size_t parallel_threshold = 8192;  // keys below which a range is not worth a task

// In the compilers' own vector types.
using Ints = std::int32_t __attribute__((vector_size(16)));
using Codes = std::uint64_t __attribute__((vector_size(32)));

// The bits of three numbers, up to 12 each, in turns.
std::uint64_t interleaved(const Ints& numbers) {
    Codes v = __builtin_convertvector(numbers, Codes);
    v = (v | v << 16) & 0xff0000ffu;
    v = (v | v << 8) & 0xf00f00f00fu;
    v = (v | v << 4) & 0xc30c30c30c3u;
    v = ((v | v << 2) & 0x249249249249u) << Codes{0, 1, 2, 0};
    return v[0] | v[1] | v[2];
}

// What maps a centre to its place along the curve through a box.
class Curve {
  public:
    explicit Curve(SignedBounds range) : offset_(0.0f), scale_(0.0f) {
        alignas(16) float scale[4] = {}, offset[4] = {};
        const auto extent = lanes_of(extent_of(range)), from = lanes_of(range.negated_lower());
        for (std::size_t a = 0; a < 3; ++a) {
            const float s = 0.9999f * float(1 << axis_bits) / extent[a];  // a hair less, so that the last is within
            if (!(std::isfinite(s) && s > 0)) continue;                   // the extent is 0, next to 0, or infinite
            scale[a] = s;
            offset[a] = from[a];
        }
        scale_ = Float4::load(scale);
        offset_ = Float4::load(offset);
    }
    std::uint64_t place(SignedBounds center) const {
        alignas(16) int at[4];
        store_truncated((offset_ - center.negated_lower()) * scale_, at);
        Ints places;
        std::memcpy(&places, at, sizeof places);
        return interleaved(places > 0 ? places : Ints{});
    }

  private:
    Float4 offset_, scale_;
};

// Least significant digits first, twelve bits at a time; chunks are moved side by side, each to places of its own.
void sort_keys(HugeVector<std::uint64_t>& keys) {
    constexpr int digit_bits = 12;
    static_assert(code_bits % digit_bits == 0);
    constexpr std::size_t digits = std::size_t(1) << digit_bits;
    const std::size_t chunks = (keys.size() + chunk - 1) / chunk;
    HugeVector<std::uint64_t> moved(keys.size());
    std::vector<std::array<std::uint32_t, digits>> counts(chunks);
    const auto in_chunks = [&](const auto& body) {
        parallel_for(chunks, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c)
                body(counts[c], c * chunk, std::min((c + 1) * chunk, keys.size()));
        });
    };
    for (int shift = index_bits; shift < 64; shift += digit_bits) {
        const auto digit = [shift](std::uint64_t key) { return (key >> shift) & (digits - 1); };
        in_chunks([&](auto& count, std::size_t begin, std::size_t end) {
            // Neighbours are often alike, and an addition waits for the one before to the same number.
            std::array<std::uint32_t, digits> other{};
            count.fill(0);
            std::size_t i = begin;
            for (; i + 2 <= end; i += 2) {
                ++count[digit(keys[i])];
                ++other[digit(keys[i + 1])];
            }
            if (i < end) ++count[digit(keys[i])];
            for (std::size_t d = 0; d < digits; ++d) count[d] += other[d];
        });
        std::uint32_t sum = 0;
        for (std::size_t d = 0; d < digits; ++d)
            for (auto& count : counts) {
                const std::uint32_t here = count[d];
                count[d] = sum;
                sum += here;
            }
        in_chunks([&](auto& next, std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) moved[next[digit(keys[i])]++] = keys[i];
        });
        keys.swap(moved);
    }
}

// Of the boxes that are finite and ordered, sorted.
template <class Primitives>
HugeVector<std::uint64_t> sorted_keys(const Primitives& boxes) {
    const std::size_t chunks = (boxes.size() + chunk - 1) / chunk;
    struct Part {
        SignedBounds centers;
        std::size_t usable = 0;
    };
    std::vector<Part> parts(chunks);
    const auto in_chunks = [&](const auto& body) {
        parallel_for(chunks, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c)
                body(parts[c], c * chunk, std::min((c + 1) * chunk, boxes.size()));
        });
    };
    in_chunks([&](Part& part, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const SignedBounds box = signed_bounds(boxes[i]);
            if (!is_usable(box)) continue;
            part.centers.extend(box.center());
            ++part.usable;
        }
    });
    SignedBounds centers;
    std::size_t count = 0;
    for (Part& part : parts) {
        centers.extend(part.centers);
        const std::size_t first = count;
        count += part.usable;
        part.usable = first;
    }
    HugeVector<std::uint64_t> keys(count);
    const Curve curve(centers);
    const auto key_of = [&](const SignedBounds& box, std::size_t i) {
        return curve.place(box.center()) << index_bits | i;
    };
    in_chunks([&](Part& part, std::size_t begin, std::size_t end) {
        if (count == boxes.size()) {  // there is nothing to ask
            for (std::size_t i = begin; i < end; ++i) keys[i] = key_of(signed_bounds(boxes[i]), i);
            return;
        }
        for (std::size_t i = begin; i < end; ++i) {
            const SignedBounds box = signed_bounds(boxes[i]);
            if (is_usable(box)) keys[part.usable++] = key_of(box, i);
        }
    });
    sort_keys(keys);
    return keys;
}

std::uint64_t code_of(std::uint64_t key) { return key >> index_bits; }

// Cuts ranges where the bits of their codes say until few are left.
template <class Primitives>
class Cutter {
  public:
    Cutter(const Primitives& boxes, HugeVector<std::uint64_t>& keys, std::uint32_t most)
        : boxes_(boxes), keys_(keys), most_(most) {}

    // Adds the grains of a range in order. A range of equal codes, a small thing in a large scene, is sorted along a
    // curve of its own, `zooms` times at most.
    void cut(std::size_t begin, std::size_t end, int zooms, std::vector<MortonGrain>& grains) {
        const std::size_t count = end - begin;
        if (count <= most_) {
            grains.push_back({std::uint32_t(begin), std::uint32_t(end)});
            return;
        }
        std::size_t middle = begin + count / 2;  // where nothing tells them apart
        if (code_of(keys_[begin]) == code_of(keys_[end - 1]) && zooms > 0) {
            --zooms;
            zoom(begin, end);
        }
        const std::uint64_t first = code_of(keys_[begin]), last = code_of(keys_[end - 1]);
        if (first != last) { middle = first_with(index_bits + std::bit_width(first ^ last) - 1, begin, end); }
        if (count < parallel_threshold) {
            cut(begin, middle, zooms, grains);
            cut(middle, end, zooms, grains);
            return;
        }
        std::vector<MortonGrain> right;
        parallel_for(2, 1, [&](std::size_t from, std::size_t to) {
            if (from == 0) cut(begin, middle, zooms, grains);
            if (to == 2) cut(middle, end, zooms, right);
        });
        grains.insert(grains.end(), right.begin(), right.end());
    }

  private:
    // The first of the keys in a range that has a bit set, as it is in the last. Without branches, of which every other
    // would be guessed wrongly.
    std::size_t first_with(int bit, std::size_t begin, std::size_t end) const {
        std::size_t at = begin, count = end - begin;
        while (count > 1) {
            const std::size_t half = count / 2;
            at += half * (~keys_[at + half - 1] >> bit & 1);
            count -= half;
        }
        return at;
    }

    void zoom(std::size_t begin, std::size_t end) {
        const auto run = std::span(keys_).subspan(begin, end - begin);
        const auto center = [&](std::uint64_t key) { return signed_bounds(boxes_[key & index_mask]).center(); };
        SignedBounds centers;
        for (const std::uint64_t key : run) centers.extend(center(key));
        const Curve curve(centers);
        for (std::uint64_t& key : run) key = curve.place(center(key)) << index_bits | (key & index_mask);
        std::sort(run.begin(), run.end());
    }

    const Primitives& boxes_;
    HugeVector<std::uint64_t>& keys_;
    std::uint32_t most_;
};

template <class Primitives>
MortonGrains grains_of(const Primitives& boxes, std::uint32_t most) {
    assert(most >= 1 && boxes.size() <= kernels::BVH_MAX_PRIMITIVES);
    HugeVector<std::uint64_t> keys = sorted_keys(boxes);
    MortonGrains out;
    if (keys.empty()) return out;
    Cutter(boxes, keys, most).cut(0, keys.size(), 16, out.grains);
    out.order.resize(keys.size());
    parallel_for(keys.size(), chunk, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) out.order[i] = std::uint32_t(keys[i] & index_mask);
    });
    return out;
}

}  // namespace

MortonGrains morton_grains(std::span<const Box> boxes, std::uint32_t most) { return grains_of(boxes, most); }
MortonGrains morton_grains(std::span<const kernels::Triangle> triangles, std::uint32_t most) {
    return grains_of(triangles, most);
}

}  // namespace spinel
