#include "cli/bench/volume_bench.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <random>
#include <type_traits>
using std::is_floating_point;  // SampleFromVoxels.h of NanoVDB 10.0 forgets to say whose
#include <nanovdb/util/SampleFromVoxels.h>

#include "cli/bench/nanovdb_grids.h"
#include "kernels/grids.h"

namespace spinel::cli {
namespace {

constexpr std::size_t PLACES = std::size_t(1) << 20;

double cpu_seconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

// Inside of the samples' middles: at the faces bricks are clamped, NanoVDB falls to the background.
std::vector<vec3> random_places(vec3 size) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<vec3> places(PLACES);
    for (vec3& p : places)
        for (int a = 0; a < 3; ++a) p[a] = 0.5f + unit(random) * (size[a] - 1);
    return places;
}

std::vector<vec3> coherent_places(vec3 size) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<vec3> places;
    while (places.size() < PLACES) {
        vec3 p, step;
        for (int a = 0; a < 3; ++a) {
            p[a] = 0.5f + unit(random) * (size[a] - 1);
            step[a] = unit(random) - 0.5f;
        }
        if (!(glm::length(step) > 0.01f)) continue;
        step *= 0.5f / glm::length(step);
        for (int i = 0; i < 256 && places.size() < PLACES; ++i, p += step) {
            if (glm::any(glm::lessThan(p, vec3(0.5f))) || glm::any(glm::greaterThan(p, size - 0.5f))) break;
            places.push_back(p);
        }
    }
    return places;
}

}  // namespace

std::vector<LookUpRow> measure_look_ups(const CompiledScene& scene, kernels::DensityGrid record, const Grid& grid,
                                        int repeats) {
    record.filter_kind = kernels::FILTER_TRILINEAR;
    const kernels::SceneView view = scene.view();
    const GridSamples& samples = *grid.samples;
    std::size_t voxels = 0;
    const nanovdb::GridHandle<> handle = nanovdb_floats(samples, grid.background, voxels);
    const auto* nano = handle.grid<float>();
    if (!nano || voxels == 0) return {};
    const double brick_bytes =
        4.0 * double(record.channel_words) * double(samples.stored_count()) + 4.0 * double(samples.table().size());
    std::vector<LookUpRow> rows;
    for (const bool coherent : {false, true}) {
        const vec3 size(samples.size());
        const std::vector<vec3> places = coherent ? coherent_places(size) : random_places(size);
        std::vector<float> ours(places.size()), theirs(places.size());
        std::vector<double> our_seconds, their_seconds;
        for (int i = 0; i < repeats; ++i) {
            const double start = cpu_seconds();
            for (std::size_t k = 0; k < places.size(); ++k) ours[k] = kernels::grid_density(view, record, places[k]);
            const double between = cpu_seconds();
            const auto accessor = nano->getAccessor();
            const auto sampler = nanovdb::createSampler<1>(accessor);
            for (std::size_t k = 0; k < places.size(); ++k) {
                const vec3 p = places[k] - 0.5f;
                theirs[k] = sampler(nanovdb::Vec3f(p.x, p.y, p.z));
            }
            their_seconds.push_back(cpu_seconds() - between);
            our_seconds.push_back(between - start);
        }
        double difference = 0;
        for (std::size_t k = 0; k < places.size(); ++k)
            difference = std::max(difference, double(std::abs(ours[k] - theirs[k])));
        const char* kind = coherent ? "coherent" : "random";
        const auto add = [&](const char* name, double seconds, double bytes, double differs) {
            rows.push_back(
                {name, kind, 1e-6 * double(places.size()) / seconds, bytes, bytes / double(voxels), differs});
        };
        add("bricks", median(our_seconds), brick_bytes, difference);
        add("nanovdb", median(their_seconds), double(handle.size()), 0);
    }
    return rows;
}

}  // namespace spinel::cli
