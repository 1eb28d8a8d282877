// Paths per second from end to end, on one thread and on all: the Cornell box (surfaces, a caustic), a cloud (null
// collisions, multiple scattering) and the demo (everything). Compile time of the scene is not in it. Repeat with
// --benchmark_repetitions=5 and read the medians.

#include <benchmark/benchmark.h>

#include <string>

#include "core/parallel.h"
#include "devices/devices.h"
#include "render/render.h"
#include "scene/compiled_scene.h"
#include "spinel/formats.h"

namespace spinel {
namespace {

void paths(benchmark::State& state, const std::string& file) {
    const ThreadLimit limit(int(state.range(0)));
    const Result<Scene> scene = load_scene(SPINEL_SOURCE_DIR "/" + file);
    if (!scene) return state.SkipWithError(scene.error().message.c_str());
    const Result<CompiledScene> compiled = compile(*scene, {.camera = {}, .size = {256, 144}});
    if (!compiled) return state.SkipWithError(compiled.error().message.c_str());
    const auto device = make_device("cpu");
    if (!device) return state.SkipWithError(device.error().message.c_str());
    const std::atomic<bool> stop{false};
    std::uint64_t samples = 0;
    double noise = 0;
    for (auto _ : state) {
        const Result<RenderResult> result = render(**device, *compiled, {.spp = 16}, stop);
        if (!result) return state.SkipWithError(result.error().message.c_str());
        samples += result->film.sample_count();
        noise = result->film.relative_error();
    }
    state.counters["paths/s"] = benchmark::Counter(double(samples), benchmark::Counter::kIsRate);
    state.counters["noise"] = noise;
}

void threads(benchmark::internal::Benchmark* b) {
    b->Arg(1)->Arg(0)->ArgName("threads")->UseRealTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(paths, cornell, "bench/scenes/cornell.json")->Apply(threads);
BENCHMARK_CAPTURE(paths, cloud, "examples/cloud.json")->Apply(threads);
BENCHMARK_CAPTURE(paths, demo, "examples/demo.json")->Apply(threads);

}  // namespace
}  // namespace spinel
