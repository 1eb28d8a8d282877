// The tests of rays against triangles, side by side: nanoseconds each, and how right they are on thin triangles.
//
//   speed     one ray after the other against a run of triangles, as leaves are tested; the second argument is how many
//             triangles there are: 1024 stay in the cache, a million do not. `indexed` reads vertices that were
//             shuffled, as those of files are at worst, and `indexed_in_order` such as stand in the order of the
//             triangles.
//   accuracy  slivers 1 long and 10⁻⁵ wide, and rays at points of them as doubles tell: per million rays, those that
//   miss
//             what they are aimed at (`missed`), that hit what they pass (`beside`), and that pass between two slivers
//             through the edge which these share (`gaps`); and the error of t, relative, at the 99th percentile.
//
//   spinel_bench --benchmark_filter=Triangle --benchmark_repetitions=5 --benchmark_report_aggregates_only

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "geometry/mesh/mesh_builder.h"
#include "kernels/triangle_plane.h"
#include "kernels/triangle_unit.h"

namespace spinel {
namespace {

using glm::vec3;
using kernels::Ray;
using kernels::Triangle;
using kernels::TriangleHit;

struct Random {
    std::mt19937 engine{1};
    float uniform(float a, float b) { return std::uniform_real_distribution<float>(a, b)(engine); }
    vec3 in_cube(float half) {
        const float x = uniform(-half, half), y = uniform(-half, half), z = uniform(-half, half);
        return {x, y, z};
    }
};

// What a test reads, in its own layout, and the test of triangle i.
struct Watertight {
    static constexpr double bytes = sizeof(Triangle);
    std::vector<Triangle> triangles;
    explicit Watertight(const std::vector<Triangle>& t) : triangles(t) {}
    struct Prepared {
        Ray ray;
        kernels::TriangleRay sheared;
    };
    static Prepared prepare(const Ray& ray) { return {ray, kernels::triangle_ray(ray)}; }
    bool test(const Prepared& p, std::size_t i, float t_max, TriangleHit& hit) const {
        return kernels::triangle_watertight(p.sheared, triangles[i], p.ray.t_min, t_max, hit);
    }
};

struct MollerTrumbore {
    static constexpr double bytes = sizeof(Triangle);
    std::vector<Triangle> triangles;
    explicit MollerTrumbore(const std::vector<Triangle>& t) : triangles(t) {}
    using Prepared = Ray;
    static Ray prepare(const Ray& ray) { return ray; }
    bool test(const Ray& ray, std::size_t i, float t_max, TriangleHit& hit) const {
        return kernels::triangle_moller_trumbore(ray, triangles[i], ray.t_min, t_max, hit);
    }
};

struct Plane {
    static constexpr double bytes = sizeof(Triangle);
    std::vector<Triangle> triangles;
    explicit Plane(const std::vector<Triangle>& t) : triangles(t) {}
    using Prepared = Ray;
    static Ray prepare(const Ray& ray) { return ray; }
    bool test(const Ray& ray, std::size_t i, float t_max, TriangleHit& hit) const {
        return kernels::triangle_plane(ray, triangles[i], ray.t_min, t_max, hit);
    }
};

struct Unit {
    static constexpr double bytes = sizeof(kernels::UnitTriangle);
    std::vector<kernels::UnitTriangle> maps;
    explicit Unit(const std::vector<Triangle>& list) {
        for (const Triangle& t : list) maps.push_back(unit_triangle(t));
    }
    using Prepared = Ray;
    static Ray prepare(const Ray& ray) { return ray; }
    bool test(const Ray& ray, std::size_t i, float t_max, TriangleHit& hit) const {
        return kernels::triangle_unit(ray, maps[i], ray.t_min, t_max, hit);
    }
};

// Three indices each, and vertices that in a closed mesh serve six triangles; here each its own three, so that the
// bytes read are the most that they can be.
template <bool shuffled>
struct Indexed {
    static constexpr double bytes =
        sizeof(glm::uvec3) + 0.5 * sizeof(vec3);  // half a vertex a triangle in a closed mesh
    std::vector<vec3> positions;
    std::vector<glm::uvec3> indices;
    explicit Indexed(const std::vector<Triangle>& list) : positions(3 * list.size()), indices(list.size()) {
        std::vector<std::uint32_t> place(positions.size());
        std::iota(place.begin(), place.end(), 0u);
        if (shuffled) std::shuffle(place.begin(), place.end(), std::mt19937(2));
        for (std::size_t i = 0; i < list.size(); ++i) {
            indices[i] = {place[3 * i], place[3 * i + 1], place[3 * i + 2]};
            positions[indices[i].x] = list[i].a;
            positions[indices[i].y] = list[i].b;
            positions[indices[i].z] = list[i].c;
        }
    }
    using Prepared = Watertight::Prepared;
    static Prepared prepare(const Ray& ray) { return Watertight::prepare(ray); }
    bool test(const Prepared& p, std::size_t i, float t_max, TriangleHit& hit) const {
        const Triangle t{positions[indices[i].x], positions[indices[i].y], positions[indices[i].z]};
        return kernels::triangle_watertight(p.sheared, t, p.ray.t_min, t_max, hit);
    }
};

// A fifth of the tests hit, about as in the leaves of a good hierarchy.
template <class Test>
void speed(benchmark::State& state) {
    Random random;
    const std::size_t count = std::size_t(state.range(0));
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i < count; ++i) {
        const vec3 at = random.in_cube(0.5f);
        triangles.push_back({at + random.in_cube(1), at + random.in_cube(1), at + random.in_cube(1)});
    }
    const Test test(triangles);
    std::vector<Ray> rays;
    for (int i = 0; i < 64; ++i) {
        const vec3 from = 5.0f * glm::normalize(random.in_cube(1));
        rays.push_back({from, 0, random.in_cube(1) - from, kernels::INFINITE});
    }
    std::size_t hits = 0, tests = 0, turn = 0;
    for (auto _ : state) {
        const auto prepared = Test::prepare(rays[turn++ % rays.size()]);
        TriangleHit hit{};
        for (std::size_t i = 0; i < count; ++i) hits += test.test(prepared, i, kernels::INFINITE, hit);
        benchmark::DoNotOptimize(hit);
        tests += count;
    }
    state.counters["ns/test"] =
        benchmark::Counter(double(tests) * 1e-9, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["hits"] = double(hits) / double(tests);
    state.counters["bytes"] = Test::bytes;
}

template <class Test>
void accuracy(benchmark::State& state) {
    constexpr int slivers = 20000, rays_each = 50;
    std::size_t aimed = 0, missed = 0, passing = 0, beside = 0, edges = 0, gaps = 0;
    std::vector<double> errors;
    for (auto _ : state) {
        Random random;
        for (int s = 0; s < slivers; ++s) {
            // Two that share the long edge ab.
            const vec3 a = random.in_cube(1), b = a + glm::normalize(random.in_cube(1));
            const vec3 across = 1e-5f * glm::normalize(glm::cross(b - a, random.in_cube(1)));
            const vec3 c = glm::mix(a, b, random.uniform(0.2f, 0.8f)) + across;
            const vec3 d = glm::mix(a, b, random.uniform(0.2f, 0.8f)) - across;
            const std::vector<Triangle> pair{{a, b, c}, {b, a, d}};
            const Test test(pair);
            const glm::dvec3 da(a), e1 = glm::dvec3(b) - da, e2 = glm::dvec3(c) - da;
            for (int i = 0; i < rays_each; ++i) {
                const vec3 from = 4.0f * glm::normalize(random.in_cube(1));
                double u = random.uniform(-0.5f, 1.5f), v = random.uniform(0, 1);
                const bool at_edge = i % 2;
                if (at_edge) u = random.uniform(0.1f, 0.9f), v = 0;
                const vec3 target(da + u * e1 + v * e2);
                const Ray ray{from, 0, target - from, kernels::INFINITE};
                const auto prepared = Test::prepare(ray);
                TriangleHit hit{};
                const bool found = test.test(prepared, 0, kernels::INFINITE, hit);
                const glm::dvec3 direction(ray.direction), p = glm::cross(direction, e2),
                                                           to = glm::dvec3(ray.origin) - da, q = glm::cross(to, e1);
                const double determinant = glm::dot(e1, p);
                const double tu = glm::dot(to, p) / determinant, tv = glm::dot(direction, q) / determinant;
                if (at_edge) {
                    // Not so aslant that rounding folds the pair, and the edge is a silhouette.
                    const glm::dvec3 n = glm::cross(e1, e2);
                    if (std::abs(glm::dot(n, direction)) < 0.5 * glm::length(n) * glm::length(direction)) continue;
                    ++edges;
                    TriangleHit other{};
                    gaps += !found && !test.test(prepared, 1, kernels::INFINITE, other);
                    continue;
                }
                const bool within = tu >= 0 && tv >= 0 && tu + tv <= 1;
                ++(within ? aimed : passing);
                missed += within && !found;
                beside += !within && found;
                if (within && found) {
                    const double t = glm::dot(e2, q) / determinant;
                    errors.push_back(std::abs(double(hit.t) - t) / t);
                }
            }
        }
    }
    std::sort(errors.begin(), errors.end());
    const auto per_million = [](std::size_t n, std::size_t of) {
        return 1e6 * double(n) / double(std::max(of, std::size_t(1)));
    };
    state.counters["missed"] = per_million(missed, aimed);
    state.counters["beside"] = per_million(beside, passing);
    state.counters["gaps"] = per_million(gaps, edges);
    state.counters["t_error"] = errors.empty() ? 0 : errors[errors.size() * 99 / 100];
}

void sizes(benchmark::internal::Benchmark* b) { b->Arg(1024)->Arg(1 << 20); }
void once(benchmark::internal::Benchmark* b) { b->Iterations(1)->Unit(benchmark::kMillisecond); }

#define SPINEL_TRIANGLE_BENCH(Test, name)                                       \
    BENCHMARK_TEMPLATE(speed, Test)->Name("TriangleSpeed/" name)->Apply(sizes); \
    BENCHMARK_TEMPLATE(accuracy, Test)->Name("TriangleAccuracy/" name)->Apply(once)

SPINEL_TRIANGLE_BENCH(Watertight, "watertight");
SPINEL_TRIANGLE_BENCH(MollerTrumbore, "moller-trumbore");
SPINEL_TRIANGLE_BENCH(Plane, "plane");
SPINEL_TRIANGLE_BENCH(Unit, "unit-triangle");
SPINEL_TRIANGLE_BENCH(Indexed<true>, "watertight-indexed");
SPINEL_TRIANGLE_BENCH(Indexed<false>, "watertight-indexed-in-order");
#undef SPINEL_TRIANGLE_BENCH

}  // namespace
}  // namespace spinel
