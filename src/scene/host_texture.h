#pragma once
// Texture look-ups on the host, over an area: for colours that are baked into something coarser than texels.

#include <vector>

#include "spinel/scene.h"

namespace spinel {

// Linear RGBA of a texture, box-filtered to halves of halves (Williams, "Pyramidal Parametrics", 1983).
class HostTexture {
  public:
    explicit HostTexture(const Texture& texture);

    // `footprint`: the edge, in uv, of the square that is averaged over; the nearest texel of the level that fits.
    vec4 at(vec2 uv, float footprint) const;

    int uv_set() const;  // that `uv` belongs to

  private:
    struct Level {
        int width, height;
        std::vector<vec4> texels;
    };
    vec4 texel(int level, int x, int y) const;

    const Texture& texture_;
    std::vector<Level> levels_;  // from half the picture's size on
};

}  // namespace spinel
