#pragma once
// Light of `dvr` at eight points at once, as dvr_lit() of the kernel has it: Blinn–Phong by the gradient, and the
// shadow of the volume.

#include <vector>

#include "devices/cpu/camera_lanes.h"
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
    // At t along the rays, which are given in world and in index space. Lanes that are not asked for are anything.
    Lit at(const DvrVolume& volume, const RayLanes& world, const RayLanes& index, Float8 t, Int8 lanes) const;

  private:
    Float8 light_way(const RayLanes& world, Float8 t) const;
    Float8 shadow(const DvrVolume& volume, const RayLanes& world, const RayLanes& index, Float8 t, Int8 lanes) const;

    kernels::DvrSettings settings_;
    glm::mat3 world_to_grid_;
    std::vector<float> highlights_;  // specular · cosine^shininess by the cosine
    std::vector<float> extinction_;  // by entry of the transfer function
};

}  // namespace spinel
