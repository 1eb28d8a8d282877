#include "cli/bench/bench_measure.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace spinel::cli {

double processor_seconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

namespace {

// The upper one of two.
double median(std::vector<double> values) {
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

double median_build_ms(const std::function<double()>& build) {
    for (int i = 0; i < 2; ++i) build();
    std::vector<double> seconds;
    for (int i = 0; i < 3; ++i) seconds.push_back(build());
    return 1e3 * median(seconds);
}

namespace {

using kernels::Hit;
using kernels::Ray;

using Trace = std::function<void(std::span<const Ray>, Hit*)>;

// The median of several runs, one thread. Hits are written over those of the batch before, as a renderer does: what is
// measured is the walk, not the memory.
double rays_per_second(const Trace& trace, std::span<const Ray> rays, int repeats) {
    constexpr std::size_t batch = 1024;
    std::vector<Hit> hits(batch);
    std::vector<double> seconds;
    for (int i = 0; i < repeats; ++i) {
        const double start = processor_seconds();
        for (std::size_t k = 0; k < rays.size(); k += batch)
            trace(rays.subspan(k, std::min(batch, rays.size() - k)), hits.data());
        seconds.push_back(processor_seconds() - start);
    }
    return double(rays.size()) / median(seconds);
}

std::vector<Ray> every(std::size_t stride, const std::vector<Ray>& rays) {
    std::vector<Ray> some;
    for (std::size_t i = 0; i + 8 <= rays.size(); i += 8 * stride)
        some.insert(some.end(), rays.begin() + std::ptrdiff_t(i), rays.begin() + std::ptrdiff_t(i) + 8);
    return some;
}

const Trace& trace_of(const BenchStructure& s, bool any) { return any && s.any ? s.any : s.closest; }

bool same(const Hit& a, const Hit& b, bool any, bool exact) {
    if (kernels::is_hit(a) != kernels::is_hit(b)) return false;
    if (any || !kernels::is_hit(a)) return true;
    if (exact) return a.t == b.t && a.instance == b.instance && a.primitive == b.primitive;
    return a.cell == b.cell && std::abs(a.t - b.t) <= 1e-4f * std::abs(a.t);
}

// Hits as they are compared: triangles by their numbers in the mesh, where the structure tells them.
std::vector<Hit> seen_by(const BenchStructure& s, std::span<const Ray> rays, bool any) {
    std::vector<Hit> hits(rays.size());
    if (rays.empty()) return hits;
    trace_of(s, any)(rays, hits.data());
    if (s.triangle && !any)
        for (Hit& hit : hits)
            if (kernels::is_hit(hit)) hit.primitive = s.triangle(hit);
    return hits;
}

std::string identity(const BenchStructure& s) { return s.name + ' ' + s.preset; }

}  // namespace

Measurement::Measurement(std::string subject, std::string kind, const std::vector<Ray>& rays, bool any, int repeats,
                         const BenchStructure& first)
    : subject_(std::move(subject)),
      kind_(std::move(kind)),
      rays_(rays),
      any_(any),
      repeats_(repeats),
      first_(identity(first)),
      exact_(bool(first.triangle)),
      expected_(seen_by(first, rays, any)) {}

void Measurement::add(const BenchStructure& s, std::vector<BenchRow>& rows) const {
    if (rays_.size() < 8) return;
    const std::vector<Ray> some = every(s.stride, rays_);
    BenchRow row;
    row.subject = subject_;
    row.structure = s.name;
    row.preset = s.preset;
    row.rays = kind_;
    row.build_ms = s.build_ms;
    row.build_ms_two_threads = s.build_ms_two_threads;
    row.refit_ms = s.refit_ms;
    row.sah_cost = s.sah_cost;
    row.depth = s.depth;
    row.bytes = s.bytes;
    row.mrays_per_s = 1e-6 * rays_per_second(trace_of(s, any_), some, repeats_);
    if (identity(s) != first_) {
        const std::vector<Hit> found = seen_by(s, some, any_);
        std::size_t differing = 0;
        for (std::size_t i = 0; i < found.size(); ++i)
            differing += !same(expected_[i / 8 * 8 * s.stride + i % 8], found[i], any_, exact_ && s.triangle);
        row.differing = double(differing) / double(found.size());
    }
    if (s.count) {
        double nodes = 0, boxes = 0, tests = 0;
        for (const Ray& ray : some) {
            const kernels::WalkCount count = s.count(ray, any_);
            nodes += count.steps;
            boxes += count.boxes;
            tests += count.tests;
        }
        const double n = double(some.size());
        row.nodes_per_ray = nodes / n;
        row.boxes_per_ray = boxes / n;
        row.tests_per_ray = tests / n;
    }
    rows.push_back(row);
}

}  // namespace spinel::cli
