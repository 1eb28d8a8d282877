#include "devices/cpu/cpu_device.h"

#include "core/parallel.h"
#include "kernels/integrators.h"
#include "kernels/traverse.h"

namespace spinel {
namespace {

class CpuDevice : public Device {
  public:
    Result<void> load(const CompiledScene& scene) override {
        view_ = scene.view();
        return {};
    }

    Result<void> render(const RenderPass& pass, FilmBuffer& film, const std::atomic<bool>& stop) override {
        const ivec2 tiles = tile_count(film);
        std::atomic<std::uint64_t> bound_reached{0}, not_finite{0};
        parallel_for(std::size_t(tiles.x) * std::size_t(tiles.y), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t tile = begin; tile < end; ++tile) {
                if (pass.finished_tiles && (*pass.finished_tiles)[tile]) continue;
                const Crop crop = tile_crop(film, int(tile));
                for (int y = crop.lower.y; y < crop.upper.y; ++y)
                    for (int x = crop.lower.x; x < crop.upper.x; ++x) {
                        if (stop.load(std::memory_order_relaxed)) return;
                        render_pixel(pass, {x, y}, film.at(x, y), bound_reached, not_finite);
                    }
            }
        });
        film.bound_reached += bound_reached;
        film.not_finite += not_finite;
        return {};
    }

  private:
    void render_pixel(const RenderPass& pass, glm::uvec2 pixel, FilmPixel& to,
                      std::atomic<std::uint64_t>& bound_reached, std::atomic<std::uint64_t>& not_finite) const {
        for (std::uint32_t i = 0; i < pass.sample_count; ++i) {
            const kernels::PixelSample sample =
                kernels::integrate(view_, pass.settings, pass.integrator, pixel, pass.first_sample + i);
            if (sample.bound_reached) ++bound_reached;
            if (!to.add(sample)) ++not_finite;
        }
    }

    kernels::SceneView view_ = {};
};

}  // namespace

std::unique_ptr<Device> make_cpu_device() { return std::make_unique<CpuDevice>(); }

}  // namespace spinel
