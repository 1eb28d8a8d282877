#pragma once
// A volume as `dvr` walks it on the CPU: samples in 16 bits with a margin, so that eight look-ups are four gathers and
// no index needs a bound; and for each brick of 4³ how far away anything visible is.

#include <cstdint>
#include <vector>

#include "devices/cpu/noise_lanes.h"
#include "kernels/path_settings.h"
#include "scene/compiled_scene.h"

namespace spinel {

class DvrVolume {
  public:
    static constexpr int margin = 2;  // samples around the volume, as those at its faces
    static constexpr int brick = 4;

    DvrVolume(const kernels::SceneView& view, const kernels::DvrSettings& settings);

    ivec3 size() const { return size_; }

    // Whether a unit of the 16 bits is more than a quarter of an entry of the transfer function, since the volume's
    // values reach far beyond those that are shown.
    bool is_coarse() const { return to_place_ > 0.25f && !integers_; }

    // Entry of the transfer function at eight points of index space, which are first moved into the volume.
    Float8 place(Vec8 p) const;
    // Its gradient by central differences of a sample to each side, index space.
    Vec8 gradient(Vec8 p) const;

    // Bricks from the one at a point to the nearest that may be visible; 0: that one may.
    Int8 distance(const Vec8& p) const;

    // Below this entry nothing is visible.
    float first_visible() const { return first_visible_; }

  private:
    struct Cell {
        Int8 index;
        Float8 x, y, z;  // place within it
    };
    Cell cell(Vec8 p) const;
    void find_distances(const kernels::SceneView& view, const kernels::DvrSettings& settings, int reach);

    ivec3 size_ = {0, 0, 0};
    int row_ = 0, layer_ = 0;
    std::vector<std::uint16_t> samples_;
    bool integers_ = false;                // 16 bits hold the values exactly
    float to_place_ = 1, place_zero_ = 0;  // entry = samples · to_place_ + place_zero_
    ivec3 bricks_ = {0, 0, 0};
    std::vector<std::uint8_t> distances_;
    float first_visible_ = 0;
};

}  // namespace spinel
