#pragma once
// What renders: a device takes a compiled scene and adds samples to a film. All devices run the same kernels.

#include <atomic>
#include <memory>

#include "core/result.h"
#include "kernels/path_settings.h"
#include "render/film.h"
#include "scene/compiled_scene.h"

namespace spinel {

struct RenderPass {
    kernels::PathSettings settings;
    std::uint32_t integrator = 0;                               // row of kernels/integrators.h
    std::uint32_t first_sample = 0;                             // of every pixel …
    std::uint32_t sample_count = 1;                             // … and how many to add
    const std::vector<std::uint8_t>* finished_tiles = nullptr;  // tiles to leave alone, see tile_count(); null: none
};

class Device {
  public:
    virtual ~Device() = default;
    // The scene must outlive the device's use of it.
    virtual Result<void> load(const CompiledScene& scene) = 0;
    // Adds the pass's samples to the film; returns early, with some pixels behind others, once `stop` is set.
    virtual Result<void> render(const RenderPass& pass, FilmBuffer& film, const std::atomic<bool>& stop) = 0;
};

// Films are worked on, and stop adapting, in square tiles.
inline constexpr int tile_size = 16;
ivec2 tile_count(const FilmBuffer& film);
Crop tile_crop(const FilmBuffer& film, int tile);

}  // namespace spinel
