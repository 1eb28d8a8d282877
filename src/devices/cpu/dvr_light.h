#pragma once
// Light of `dvr` at eight points at once, as dvr_lit() of the kernel has it: Blinn–Phong by the gradient, and the
// shadow of the volume.

#include <vector>

#include "devices/cpu/dvr_volume.h"

namespace spinel {

class DvrLights {
  public:
    DvrLights(const kernels::SceneView& view, const kernels::DvrSettings& settings);

    struct Lit {
        Float8 factor;     // of the colour
        Float8 highlight;  // added to it
        Vec8 normal;       // towards smaller values, world space; not unit where nothing slopes
    };
    // p and `along` in index space, `direction` in world space; both of the rays. Lanes that are not asked for are
    // anything.
    Lit at(const DvrVolume& volume, const Vec8& p, const Vec8& direction, const Vec8& along, Int8 lanes) const;

  private:
    Float8 shadow(const DvrVolume& volume, const Vec8& p, const Vec8& along, Int8 lanes) const;

    kernels::DvrSettings settings_;
    glm::mat3 world_to_grid_;
    std::vector<float> highlights_;  // specular · cosine^shininess by the cosine
    std::vector<float> extinction_;  // by entry of the transfer function
};

}  // namespace spinel
