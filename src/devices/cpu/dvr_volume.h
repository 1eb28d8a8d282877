#pragma once
// A volume as `dvr` walks it on the CPU: samples in 16 bits with a margin, so that eight look-ups are four gathers and
// no index needs a bound; and for each brick of 4³ how far away anything is that matters, or what values it holds.

#include <cstdint>
#include <functional>
#include <vector>

#include "devices/cpu/noise_lanes.h"
#include "kernels/path_settings.h"
#include "scene/compiled_scene.h"

namespace spinel {

class DvrVolume {
  public:
    static constexpr int margin = 2;  // samples around the volume, as those at its faces
    static constexpr int brick = 4;
    static constexpr int block = 16;  // of bricks, edges of a voxel

    DvrVolume(const kernels::SceneView& view, const kernels::DvrSettings& settings);

    ivec3 size() const { return size_; }

    // Whether 16 bits do not tell apart what is shown, since the volume's values reach far beyond it: a unit is more
    // than a quarter of an entry of the transfer function, or an iso-surface lies on slopes of few units. Then the rest
    // is not made, and nothing else may be asked.
    bool is_coarse() const { return coarse_; }

    // In units of the 16 bits, at eight points of index space, which are first moved into the volume.
    Float8 value(const Vec8& p) const;
    // Its gradient by central differences of a sample to each side, index space.
    Vec8 gradient(const Vec8& p) const;

    // Entry of the transfer function for such a value.
    Float8 place(Float8 value) const { return value * to_place_ + place_zero_; }
    // Data units in those of the 16 bits.
    float value_of(float data) const { return (data - low_) / unit_; }

    // Composites and iso-surfaces: bricks from the one at a point to the nearest in which something may be seen; 0: in
    // that one. What lies within a step of a brick counts as in it.
    Int8 distance(const Vec8& p) const;
    // Composites: below this entry nothing is visible.
    float first_visible() const { return first_visible_; }

    // Projections: bounds of what look-ups in a brick or a block of 4³ bricks give.
    struct Range {
        Float8 least, most;
    };
    Range brick_range(const Vec8& p) const { return range(brick_ranges_, bricks_, brick, p); }
    Range block_range(const Vec8& p) const { return range(block_ranges_, blocks_, block, p); }

  private:
    struct Cell {
        Int8 index;
        Float8 x, y, z;  // place within it
    };
    Cell cell(const Vec8& p) const;
    Range range(const std::vector<std::uint32_t>& ranges, ivec3 count, int edge, const Vec8& p) const;
    static Int8 index_of(ivec3 count, int edge, const Vec8& p);

    // Chooses the units.
    void measure(const kernels::SceneView& view, const kernels::DvrSettings& settings);
    bool is_iso_coarse(const kernels::SceneView& view, const kernels::DensityGrid& grid, float iso) const;
    void copy_samples(const kernels::SceneView& view, const kernels::DensityGrid& grid);
    // For each brick of some edge, least and greatest of its samples and of `reach` more to all sides: in the lower and
    // the upper half.
    std::vector<std::uint32_t> ranges_of(ivec3 count, int edge, int reach) const;
    void find_distances(int reach, const std::function<bool(int, int)>& matters);

    ivec3 size_ = {0, 0, 0};
    int row_ = 0, layer_ = 0;
    std::vector<std::uint16_t> samples_;
    bool coarse_ = false;
    float low_ = 0, unit_ = 1;             // data = low + unit · value
    float to_place_ = 1, place_zero_ = 0;  // entry = value · to_place_ + place_zero_
    ivec3 bricks_ = {0, 0, 0}, blocks_ = {0, 0, 0};
    std::vector<std::uint8_t> distances_;
    std::vector<std::uint32_t> brick_ranges_, block_ranges_;
    float first_visible_ = 0;
};

}  // namespace spinel
