#pragma once
// `dvr` for eight rays at once over a DvrVolume: the kernel's composite (kernels/dvr.h), step for step, but for parts
// of the way on which none of the rays can see anything. Pictures differ by the 16 bits that samples are kept in.

#include <memory>

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

    // The first `count` rays; hits of rays that were not traced are not looked at.
    void render(const kernels::Ray* rays, const kernels::Hit* hits, kernels::Sampler* numbers, int count,
                kernels::PixelSample* samples) const;

  private:
    DvrPackets(const CompiledScene& scene, const kernels::DvrSettings& settings);

    struct Rays;
    struct Seen;
    void composite(const Rays& rays, Seen& seen) const;
    void step(const Rays& rays, Float8 t, const Vec8& middle, Float8 x0, Float8 x1, Int8 lanes, Seen& seen) const;
    // Mean of colour·σ and σ between two entries, as transfer_between() of the kernel.
    void mean_between(Float8 x0, Float8 x1, Float8 mean[4]) const;

    kernels::SceneView view_;
    kernels::DvrSettings settings_;
    bool surfaces_ = false;
    DvrVolume volume_;
    glm::mat3 world_to_grid_;
    std::vector<float> highlights_;  // specular · cosine^shininess by the cosine
};

}  // namespace spinel
