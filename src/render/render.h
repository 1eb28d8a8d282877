#pragma once
// The render loop: passes over the film until samples, time or noise say enough.

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "render/device.h"
#include "spinel/render.h"

namespace spinel {

struct RenderResult {
    FilmBuffer film;
    double seconds = 0;      // without loading the scene into the device
    double cpu_seconds = 0;  // of the whole process meanwhile
    StopReason reason = StopReason::samples;
};

// Renders on the device. `stop` may be set from a signal handler or another thread: what there is then is returned.
// `report` is called between passes.
Result<RenderResult> render(Device& device, const CompiledScene& scene, const RenderOptions& options,
                            const std::atomic<bool>& stop,
                            const std::function<void(const RenderProgress&)>& report = {});

// What the scene asks of `single-scatter`, its defaults worked out.
kernels::MarchSettings march_settings(const CompiledScene& scene);

struct IntegratorInfo {
    const char* name;
    const char* doc;
    std::uint32_t number;
    int needs;  // SPINEL_NEEDS_… of kernels/integrator_table.h
};
const std::vector<IntegratorInfo>& integrator_infos();

// By name, or an error that lists what there is.
Result<const IntegratorInfo*> find_integrator(const std::string& name);

}  // namespace spinel
