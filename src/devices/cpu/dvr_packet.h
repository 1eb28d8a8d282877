#pragma once
// `dvr` for eight rays at once over a DvrVolume: what the kernel does (kernels/dvr.h), step for step, but for parts of
// the way on which none of the rays can see anything. Pictures differ by the 16 bits that samples are kept in.

#include <memory>

#include "devices/cpu/camera_lanes.h"
#include "devices/cpu/dvr_light.h"
#include "devices/cpu/dvr_volume.h"
#include "kernels/pixel_sample.h"
#include "kernels/random.h"
#include "kernels/ray.h"

namespace spinel {

class DvrPackets {
  public:
    static constexpr int width = 8;

    // Null where the kernel alone can show what was asked for.
    static std::unique_ptr<DvrPackets> make(const CompiledScene& scene, const kernels::DvrSettings& settings);

    const kernels::DvrSettings& settings() const { return settings_; }

    // Whether rays have to be traced: the scene has more than volumes.
    bool wants_hits() const { return surfaces_; }

    // The first `count` rays, each of which begins `start` of a step on; hits of rays that were not traced are not
    // looked at.
    void render(const RayLanes& rays, Float8 start, const kernels::Hit* hits, int count,
                kernels::PixelSample* samples) const;

  private:
    DvrPackets(const CompiledScene& scene, const kernels::DvrSettings& settings);

    struct Rays;
    struct Seen;
    Rays begin(const RayLanes& rays, Float8 start, Float8 ends) const;
    void composite(const Rays& rays, Seen& seen) const;
    void step(const Rays& rays, Float8 t, const Float8 mean[4], Int8 lanes, Seen& seen) const;
    void isosurface(const Rays& rays, Seen& seen) const;
    void projection(const Rays& rays, Seen& seen) const;

    kernels::SceneView view_;
    kernels::DvrSettings settings_;
    bool surfaces_ = false;
    DvrVolume volume_;
    DvrLights lights_;
};

}  // namespace spinel
