#pragma once
// The render loop: passes over the film until samples, time or noise say enough.

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "render/device.h"

namespace spinel {

struct RenderOptions {
    int spp = 0;                  // samples per pixel; 0: the scene's, unless time or noise is given, then no limit
    double time_limit = 0;        // seconds; 0: none
    double noise = 0;             // stop at this relative standard error (of each tile); 0: never
    double clamp = -1;            // of indirect light; −1: the scene's; 0: none
    int max_bounces = -2;         // −2: the scene's; −1: no limit
    std::string integrator = {};  // empty: the scene's
    std::uint32_t seed = 0;       // same seed, same bits, on any number of threads
    Crop crop = {};               // empty: the whole film
};

struct RenderProgress {
    double fraction = 0;        // 0 … 1 of the work, as far as it can be known
    double seconds = 0;         // so far
    double remaining = -1;      // seconds still to go; −1: unknown
    std::uint32_t samples = 0;  // per pixel, so far
    double relative_error = 0;
};

enum class StopReason { samples, time, noise, interrupted };

struct RenderResult {
    FilmBuffer film;
    double seconds = 0;
    StopReason reason = StopReason::samples;
};

// Renders on the device. `stop` may be set from a signal handler or another thread: what there is then is returned.
// `report` is called between passes.
Result<RenderResult> render(Device& device, const CompiledScene& scene, const RenderOptions& options,
                            const std::atomic<bool>& stop,
                            const std::function<void(const RenderProgress&)>& report = {});

struct IntegratorInfo {
    const char* name;
    const char* doc;
    std::uint32_t number;
};
const std::vector<IntegratorInfo>& integrator_infos();

// By name, or an error that lists what there is.
Result<const IntegratorInfo*> find_integrator(const std::string& name);

}  // namespace spinel
