#pragma once
// `single-scatter` by shortcuts (kernels/single_scatter.h takes every step). Of a medium with a grid that fills a box:
//   - parts of a ray whose majorant is nothing are leapt over;
//   - eight steps are looked at together;
//   - what a lamp's light passes through on its way to a place in the medium is computed once, on a lattice, and
//     interpolated: how deep, not how bright, so colours stay exact;
//   - behind what is opaque nothing is asked.
// Anything else goes the straight way.

#include <memory>

#include "kernels/path.h"
#include "scene/compiled_scene.h"

namespace spinel {

class MarchShortcuts {
  public:
    MarchShortcuts(const CompiledScene& scene, const kernels::MarchSettings& settings);
    ~MarchShortcuts();

    const kernels::MarchSettings& settings() const;
    kernels::PixelSample sample(const kernels::Ray& ray, const kernels::Inside& inside, kernels::Hit hit,
                                kernels::Sampler numbers) const;

  private:
    struct Data;
    std::unique_ptr<Data> data_;
};

}  // namespace spinel
