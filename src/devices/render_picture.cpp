#include <algorithm>

#include "core/parallel.h"
#include "devices/devices.h"
#include "render/render.h"
#include "scene/compiled_scene.h"

namespace spinel {

Result<Picture> render_picture(const Scene& scene, const PictureOptions& options,
                               const std::function<void(const RenderProgress&)>& report,
                               const std::atomic<bool>* stop) {
    const ThreadLimit limit(options.threads);
    const Result<CompiledScene> compiled =
        compile(scene, {.camera = options.camera, .size = options.size, .integrator = options.render.integrator});
    if (!compiled) return compiled.error();
    const Result<std::unique_ptr<Device>> device = make_device(options.device);
    if (!device) return device.error();
    const std::atomic<bool> never{false};
    const Result<RenderResult> result = render(**device, *compiled, options.render, stop ? *stop : never, report);
    if (!result) return result.error();
    const FilmBuffer& film = result->film;
    return Picture{
        .radiance = film.radiance(),
        .samples_per_pixel = double(film.sample_count()) / double(std::max<std::size_t>(film.pixels.size(), 1)),
        .relative_error = film.relative_error(),
        .seconds = result->seconds,
        .biased_paths = film.bound_reached + film.not_finite,
        .reason = result->reason};
}

}  // namespace spinel
