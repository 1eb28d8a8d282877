#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "core/parallel.h"
#include "spinel/grid.h"

namespace spinel {
namespace {

constexpr int EDGE = GridSamples::brick_edge;
constexpr std::size_t VOLUME = GridSamples::brick_volume;
constexpr std::size_t MAX_BRICKS = std::size_t(1) << 26;
constexpr int MAX_EDGE = 1 << 20;

// Where sample (x,y,z) of a channel stands in a brick.
std::size_t in_brick(ivec3 i, int channel = 0) {
    const int place = i.x + EDGE * (i.y + EDGE * (i.z + EDGE * channel));
    return std::size_t(place);
}

// The samples beyond the size repeat the last one inside, so that they neither widen the range of a brick nor make it
// differ from its like.
void repeat_last(ivec3 inside, std::span<float> samples) {
    if (inside == ivec3(EDGE)) return;
    for (int z = 0; z < EDGE; ++z)
        for (int y = 0; y < EDGE; ++y)
            for (int x = 0; x < EDGE; ++x) {
                const ivec3 i(x, y, z);
                samples[in_brick(i)] = samples[in_brick(glm::min(i, inside - 1))];
            }
}

bool is_uniform(std::span<const float> samples) {
    return std::all_of(samples.begin(), samples.end(), [&](float v) { return v == samples[0]; });
}

}  // namespace

class GridSamplesBuilder {
  public:
    GridSamplesBuilder(ivec3 size, int channels) {
        grid_->size_ = size;
        grid_->channels_ = channels;
    }

    Result<GridPointer> build(const BrickFiller& fill) {
        const ivec3 size = grid_->size_;
        if (size.x < 1 || size.y < 1 || size.z < 1) return Error{"has a size of zero"};
        if (size.x > MAX_EDGE || size.y > MAX_EDGE || size.z > MAX_EDGE)
            return Error{"has an edge of more than the " + std::to_string(MAX_EDGE) + " samples allowed"};
        const ivec3 counts = grid_->brick_counts();
        const std::size_t layer = std::size_t(counts.x) * std::size_t(counts.y);
        if (layer > MAX_BRICKS || layer * std::size_t(counts.z) > MAX_BRICKS)
            return Error{"fills a box of more than the " + std::to_string(MAX_BRICKS) + " bricks of 8³ allowed"};
        grid_->table_.resize(layer * std::size_t(counts.z));
        std::vector<Slab> slabs(std::size_t(counts.z));
        parallel_for(slabs.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t z = begin; z < end; ++z) fill_slab(int(z), fill, slabs[z]);
        });
        return gather(slabs, layer);
    }

  private:
    static constexpr std::uint32_t UNIFORM = 0x80000000u;
    // What one layer of bricks stores for itself: in the table stand numbers within it, or of its uniform values.
    struct Slab {
        std::vector<float> samples;
        std::vector<std::vector<float>> uniform;  // the channels' values
        float minimum = std::numeric_limits<float>::max();
        float maximum = std::numeric_limits<float>::lowest();
        bool finite = true;

        std::uint32_t number_of(const std::vector<float>& values) {
            const auto known = std::find(uniform.begin(), uniform.end(), values);
            const auto number = std::uint32_t(known - uniform.begin());
            if (known == uniform.end()) uniform.push_back(values);
            return UNIFORM | number;
        }
        std::uint32_t store(const std::vector<float>& brick) {
            const auto number = std::uint32_t(samples.size() / brick.size());
            samples.insert(samples.end(), brick.begin(), brick.end());
            return number;
        }
    };

    void fill_slab(int z, const BrickFiller& fill, Slab& slab) {
        const ivec3 counts = grid_->brick_counts();
        const auto channels = std::size_t(grid_->channels_);
        std::vector<float> brick(VOLUME * channels), values(channels);
        for (int y = 0; y < counts.y; ++y) {
            std::uint32_t* const row =
                &grid_->table_[std::size_t(counts.x) * (std::size_t(y) + std::size_t(counts.y) * std::size_t(z))];
            for (int x = 0; x < counts.x;) {
                const ivec3 lower = EDGE * ivec3(x, y, z);
                const int alike = std::min(fill(lower, brick), counts.x - x);
                bool uniform = true;
                for (std::size_t c = 0; c < channels; ++c) {
                    const auto channel = std::span(brick).subspan(c * VOLUME, alike > 0 ? 1 : VOLUME);
                    if (alike == 0) repeat_last(glm::min(grid_->size_ - lower, ivec3(EDGE)), channel);
                    for (float& v : channel) {
                        slab.finite = slab.finite && std::isfinite(v);
                        v += 0.0f;  // −0 is 0
                        slab.minimum = std::min(slab.minimum, v);
                        slab.maximum = std::max(slab.maximum, v);
                    }
                    uniform = uniform && is_uniform(channel);
                    values[c] = channel[0];
                }
                const std::uint32_t entry = uniform ? slab.number_of(values) : slab.store(brick);
                std::fill_n(row + x, std::max(alike, 1), entry);
                x += std::max(alike, 1);
            }
        }
    }

    Result<GridPointer> gather(std::vector<Slab>& slabs, std::size_t layer) {
        const std::size_t volume = VOLUME * std::size_t(grid_->channels_);
        std::map<std::vector<float>, std::uint32_t> known;
        std::size_t total = 0;
        for (const Slab& slab : slabs) total += slab.samples.size();
        grid_->samples_.reserve(total);
        grid_->minimum_ = std::numeric_limits<float>::max();
        grid_->maximum_ = std::numeric_limits<float>::lowest();
        for (std::size_t z = 0; z < slabs.size(); ++z) {
            Slab& slab = slabs[z];
            if (!slab.finite) return Error{"has a sample that is not finite"};
            grid_->minimum_ = std::min(grid_->minimum_, slab.minimum);
            grid_->maximum_ = std::max(grid_->maximum_, slab.maximum);
            const auto first = std::uint32_t(grid_->samples_.size() / volume);
            grid_->samples_.insert(grid_->samples_.end(), slab.samples.begin(), slab.samples.end());
            slab.samples = {};
            std::vector<std::uint32_t> numbers;  // of the slab's uniform bricks
            for (const std::vector<float>& values : slab.uniform) {
                const auto [at, fresh] = known.try_emplace(values, std::uint32_t(grid_->samples_.size() / volume));
                if (fresh)
                    for (const float v : values) grid_->samples_.insert(grid_->samples_.end(), VOLUME, v);
                numbers.push_back(at->second);
            }
            for (std::size_t i = z * layer; i < (z + 1) * layer; ++i) {
                std::uint32_t& entry = grid_->table_[i];
                entry = entry & UNIFORM ? numbers[entry & ~UNIFORM] : first + entry;
            }
        }
        return GridPointer(std::move(grid_));
    }

    std::shared_ptr<GridSamples> grid_ = std::make_shared<GridSamples>();
};

float GridSamples::at(ivec3 sample, int channel) const {
    const ivec3 counts = brick_counts(), b = sample / brick_edge, i = sample % brick_edge;
    const std::uint32_t number =
        table_[std::size_t(b.x) +
               std::size_t(counts.x) * (std::size_t(b.y) + std::size_t(counts.y) * std::size_t(b.z))];
    return brick(number)[in_brick(i, channel)];
}

std::vector<float> GridSamples::dense(int channel) const {
    std::vector<float> values(std::size_t(size_.x) * std::size_t(size_.y) * std::size_t(size_.z));
    std::size_t at_value = 0;
    for (int z = 0; z < size_.z; ++z)
        for (int y = 0; y < size_.y; ++y)
            for (int x = 0; x < size_.x; ++x) values[at_value++] = at({x, y, z}, channel);
    return values;
}

Result<GridPointer> build_grid(ivec3 size, int channels, const BrickFiller& fill) {
    return GridSamplesBuilder(size, channels).build(fill);
}

Result<GridPointer> build_grid(ivec3 size, std::span<const float> values, int channels) {
    const std::size_t count = std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z) * std::size_t(channels);
    if (size.x > 0 && size.y > 0 && size.z > 0 && values.size() != count)
        return Error{"has " + std::to_string(values.size()) + " values; its size needs " + std::to_string(count)};
    return build_grid(size, channels, [&](ivec3 lower, std::span<float> samples) {
        const ivec3 inside = glm::min(size - lower, ivec3(EDGE));
        for (int z = 0; z < inside.z; ++z)
            for (int y = 0; y < inside.y; ++y) {
                const std::size_t row =
                    std::size_t(lower.x) +
                    std::size_t(size.x) * (std::size_t(lower.y + y) + std::size_t(size.y) * std::size_t(lower.z + z));
                for (int x = 0; x < inside.x; ++x)
                    for (int c = 0; c < channels; ++c)
                        samples[in_brick({x, y, z}, c)] =
                            values[(row + std::size_t(x)) * std::size_t(channels) + std::size_t(c)];
            }
        return 0;
    });
}

}  // namespace spinel
