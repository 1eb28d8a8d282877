#pragma once
// Samples of a volume, in the data's own units, as bricks of 8³: those that hold one value throughout share one brick
// among equals, so that empty space and solid insides take no room. Immutable and shared.
//
// Sample (i,j,k) sits at (i+½, j+½, k+½) of index space. Bricks at the far faces reach beyond the size and repeat the
// last sample there.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/result.h"
#include "kernels/portable.h"

namespace spinel {

using glm::ivec3;

class GridSamples {
  public:
    static constexpr int brick_edge = 8;
    static constexpr std::size_t brick_volume = 512;

    ivec3 size() const { return size_; }
    int channels() const { return channels_; }  // 1, or 3 of colours and vectors
    ivec3 brick_counts() const { return (size_ + (brick_edge - 1)) / brick_edge; }
    // Bricks that are stored: those of more than one value, and one for each value of the others.
    std::size_t stored_count() const { return samples_.size() / (brick_volume * std::size_t(channels_)); }
    // For each brick of the box, x fastest, the number of the stored one.
    const std::vector<std::uint32_t>& table() const { return table_; }
    // Of a stored brick: 512 samples, x fastest, of each channel in turn.
    std::span<const float> brick(std::uint32_t number) const {
        const std::size_t volume = brick_volume * std::size_t(channels_);
        return {samples_.data() + number * volume, volume};
    }
    float minimum() const { return minimum_; }  // of all samples and channels
    float maximum() const { return maximum_; }

    // Of a sample inside of the box.
    float at(ivec3 sample, int channel = 0) const;

    // All samples of a channel, x fastest, then y, then z.
    std::vector<float> dense(int channel = 0) const;

  private:
    friend class GridSamplesBuilder;
    ivec3 size_ = {0, 0, 0};
    int channels_ = 1;
    std::vector<std::uint32_t> table_;
    std::vector<float> samples_;
    float minimum_ = 0;
    float maximum_ = 0;
};

using GridPointer = std::shared_ptr<const GridSamples>;

// Fills a brick, whose first sample is `lower`: sample (i,j,k) of channel c belongs into [i + 8·(j + 8·k) + 512·c].
// What lies beyond the size need not be filled. Called from several threads at once. Returns 0; or, where the brick and
// maybe others behind it along x are of one value in each channel, and that stands in the first sample, how many they
// are.
using BrickFiller = std::function<int(ivec3 lower, std::span<float> samples)>;

// An error says what is wrong with the samples: "has a size of zero", "has a sample that is not finite", …
Result<GridPointer> build_grid(ivec3 size, int channels, const BrickFiller& fill);

// Of samples x fastest, then y, then z; those of several channels interleaved.
Result<GridPointer> build_grid(ivec3 size, std::span<const float> values, int channels = 1);

}  // namespace spinel
