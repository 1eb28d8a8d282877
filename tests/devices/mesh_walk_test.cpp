// The wide hierarchy and its walks against every triangle asked one by one.

#include "devices/cpu/mesh_walk.h"

#include <gtest/gtest.h>

#include <cstring>

#include "accel/wide_refit.h"
#include "core/parallel.h"
#include "devices/cpu/avx2.h"
#include "geometry/mesh/wide_mesh.h"
#include "geometry/test_scene.h"
#include "kernels/triangle.h"

namespace spinel::mesh_walk_test {
namespace {

using namespace test;
using kernels::NONE;
using kernels::Ray;
using kernels::Triangle;

using Triangles = std::vector<Triangle>;

struct Built {
    Triangles triangles;
    WideBvh tree, compact_tree;
    WideMesh mesh, compact;

    explicit Built(Triangles list, const WidePreset& preset = default_wide_preset())
        : triangles(std::move(list)),
          tree(build_wide_mesh(triangles, preset)),
          compact_tree(build_compact_mesh(triangles, preset)),
          mesh{tree.units.data(), vec3(1e30f), vec3(-1e30f)} {
        for (const Triangle& t : triangles)
            for (const vec3& p : {t.a, t.b, t.c}) {
                mesh.lower = glm::min(mesh.lower, p);
                mesh.upper = glm::max(mesh.upper, p);
            }
        compact = {compact_tree.units.data(), mesh.lower, mesh.upper};
    }
};

// The least t; of triangles met at the same t the first.
WideHit brute_force(const Triangles& triangles, const Ray& ray) {
    const kernels::TriangleRay sheared = kernels::triangle_ray(ray);
    kernels::TriangleHit best(ray.t_max, 0, 0);
    std::uint32_t nearest = NONE;
    for (std::uint32_t i = 0; i < triangles.size(); ++i)
        if (kernels::triangle_watertight(sheared, triangles[i], ray.t_min, best.t, best)) nearest = i;
    return {best.t, best.u, best.v, nearest};
}

// Where the compiler has no fused multiply-add, the kernel rounds products otherwise than AVX2 does.
#ifdef __FP_FAST_FMAF
constexpr bool same_rounding = true;
#else
constexpr bool same_rounding = false;
#endif

void expect_equal(const WideHit& a, const WideHit& b, const Ray& ray) {
    ASSERT_EQ(a.triangle, b.triangle) << describe(ray);
    ASSERT_EQ(a.t, b.t) << describe(ray);
    ASSERT_EQ(a.u, b.u) << describe(ray);
    ASSERT_EQ(a.v, b.v) << describe(ray);
}

// The walks of one layout.
struct Walks {
    WideHit (*closest)(const WideMesh&, const Ray&);
    bool (*any)(const WideMesh&, const Ray&);
    vec3 (*normal)(const WideHit&);
};
constexpr Walks wide_walks[] = {{wide_closest, wide_any, wide_normal},
                                {wide_closest_portable, wide_any_portable, wide_normal}};
constexpr Walks compact_walks[] = {{compact_closest, compact_any, compact_normal},
                                   {compact_closest_portable, compact_any_portable, compact_normal}};

// Calls visit(mesh, walks) for both layouts.
template <class Visit>
void each_walk(const Built& built, const Visit& visit) {
    for (const Walks& walks : wide_walks) visit(built.mesh, walks);
    for (const Walks& walks : compact_walks) visit(built.compact, walks);
}

// Returns how many rays hit.
int check(const Built& built, const std::vector<Ray>& rays) {
    int found = 0;
    for (const Ray& ray : rays) {
        const WideHit expected = brute_force(built.triangles, ray);
        const bool hit = expected.triangle != NONE;
        found += hit;
        expect_equal(compact_closest_portable(built.compact, ray), expected, ray);
        EXPECT_EQ(compact_any_portable(built.compact, ray), hit) << describe(ray);
        expect_equal(compact_closest(built.compact, ray), wide_closest(built.mesh, ray), ray);
        EXPECT_EQ(compact_any(built.compact, ray), wide_any(built.mesh, ray)) << describe(ray);
        expect_equal(wide_closest_portable(built.mesh, ray), expected, ray);
        EXPECT_EQ(wide_any_portable(built.mesh, ray), hit) << describe(ray);
        if (same_rounding) expect_equal(wide_closest(built.mesh, ray), expected, ray);
        const bool nearest = wide_closest(built.mesh, ray).triangle != NONE;
        EXPECT_EQ(wide_any(built.mesh, ray), nearest) << describe(ray);
        if (::testing::Test::HasFailure()) break;
    }
    return found;
}

Triangles soup(Random& random, int count, float size, vec3 offset = vec3(0)) {
    Triangles list;
    for (int i = 0; i < count; ++i) {
        const vec3 center = offset + random.in_cube(10);
        list.push_back({center + random.in_cube(size), center + random.in_cube(size), center + random.in_cube(size)});
    }
    return list;
}

std::vector<Ray> rays_towards(Random& random, const Triangles& triangles, int count, float reach) {
    std::vector<Ray> rays;
    for (int i = 0; i < count; ++i) {
        const Triangle& t = triangles[std::size_t(random.uniform(0, 0.999f) * float(triangles.size()))];
        // Points, edges and the inside of triangles, from near by, from far away, along the axes and askew.
        const float u = i % 3 == 0 ? 0.0f : random.uniform(0, 1), v = i % 5 == 0 ? 0.0f : random.uniform(0, 1 - u);
        const vec3 target = (1 - u - v) * t.a + u * t.b + v * t.c;
        const vec3 direction = random.awkward_direction();
        const float distance = reach * (i % 2 ? random.uniform(0.01f, 2) : 0.5f);
        rays.push_back(
            ray(target - distance * direction, direction, 0, i % 7 == 0 ? distance * 1.5f : kernels::INFINITE));
    }
    return rays;
}

// Squares of a floor at y = 0 in pairs of triangles, n × n, from −1 to 1.
Triangles floor_of(int n) {
    Triangles list;
    const auto at = [n](int i, int j) { return vec3(2 * float(i) / float(n) - 1, 0, 2 * float(j) / float(n) - 1); };
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            list.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            list.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return list;
}

// Long thin triangles through each other, aslant to all axes: what spatial splits are for.
Triangles blades(Random& random, int count) {
    Triangles list;
    for (int i = 0; i < count; ++i) {
        const vec3 a = random.in_cube(10), b = random.in_cube(10);
        list.push_back({a, b, a + random.in_cube(0.3f)});
    }
    return list;
}

Triangles triangles_of(const MeshGeometry& mesh) {
    Triangles list;
    for (const uvec3& t : mesh.triangles)
        list.push_back({mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]});
    return list;
}

TEST(MeshWalk, the_hit_of_every_preset_is_that_of_brute_force_to_the_last_bit) {
    for (const WidePreset& preset : wide_presets()) {
        Random random(11);
        for (const int count : {1, 2, 3, 4, 5, 9, 33, 700}) {
            const Built built(soup(random, count, 1.5f), preset);
            EXPECT_GT(check(built, rays_towards(random, built.triangles, 1500, 5)), 1000) << preset.name;
        }
        const Built thin(blades(random, 600), preset);
        EXPECT_GT(check(thin, rays_towards(random, thin.triangles, 3000, 8)), 2000) << preset.name;
    }
}

TEST(MeshWalk, triangles_met_at_the_same_t_are_told_by_the_lowest_index) {
    Random random(12);
    const Built plain(floor_of(16));
    Triangles doubled = floor_of(16);
    for (const Triangle& t : floor_of(8)) doubled.push_back(t);
    for (const Triangle& t : floor_of(16)) doubled.push_back(t);
    std::shuffle(doubled.begin(), doubled.end(), std::mt19937(1));
    const Built layers(doubled);
    std::vector<Ray> rays;
    for (int j = -8; j <= 8; ++j)
        for (int i = -8; i <= 8; ++i) {
            const vec3 corner(float(i) / 8, 0, float(j) / 8);
            rays.push_back(ray(corner + vec3(0, 2, 0), vec3(0, -1, 0)));
            rays.push_back(ray(corner + vec3(0.05f, -3, 0), vec3(0, 1, 0)));
            rays.push_back(ray(corner + vec3(1, 1, 0), vec3(-1, -1, 0)));
            rays.push_back(ray(corner + vec3(-2, 2, 2), vec3(1, -1, -1)));
        }
    EXPECT_GT(check(plain, rays), 900);
    EXPECT_GT(check(layers, rays), 900);
}

TEST(MeshWalk, adversarial_meshes_and_rays) {
    Random random(13);
    for (const vec3 offset : {vec3(0), vec3(1000, -2000, 500), vec3(1e6f, 0, -1e6f)})
        for (const float size : {1e-6f, 1e-2f, 30.0f}) {
            Triangles list = soup(random, 200, size, offset);
            for (int i = 0; i < 20; ++i) {
                const vec3 p = offset + random.in_cube(5), q = offset + random.in_cube(5);
                list.push_back({p, p, p});  // a point, a line, a sliver
                list.push_back({p, q, 0.5f * (p + q)});
                list.push_back({p, q, q + vec3(0, 1e-6f, 0)});
            }
            const Built built(list);
            check(built, rays_towards(random, built.triangles, 1500, std::max(size, 1.0f)));
        }
}

// The edge of a long triangle is rounded by its far end, the box of its neighbour is not: a ray near to the origin of
// such an edge is lost by walks that widen boxes by what t is only.
TEST(MeshWalk, long_triangles_that_share_an_edge_let_no_ray_through) {
    Random random(14);
    int found = 0, count = 0;
    for (int k = 0; k < 40; ++k) {
        const float x = random.uniform(0.2f, 0.9f), far = 1000 * random.uniform(0.5f, 2);
        const vec3 low(x, 0, -far), high(x, 0, far);
        const Built built(
            {{vec3(-far, 0, 0), low, high}, {vec3(far, 0, 0), high, low}, {low, low + vec3(0, 5, 0), vec3(9)}});
        std::vector<Ray> rays;
        for (int i = 0; i < 500; ++i) {
            const float height = std::exp(random.uniform(-9, 3));
            const vec3 direction(random.uniform(-0.3f, 0.3f), -random.uniform(0.001f, 0.2f), 1);
            const float t = height / -direction.y;
            rays.push_back(ray(vec3(x, height, 0) - vec3(direction.x, 0, direction.z) * t, direction));
        }
        found += check(built, rays);
        count += int(rays.size());
    }
    EXPECT_GT(found, count * 9 / 10);  // some begin beyond the ends
}

TEST(MeshWalk, the_interval_is_open) {
    const Built built(floor_of(4));
    for (const auto& [t_min, t_max, expected] : {std::tuple(0.0f, 3.0f, true), std::tuple(2.0f, 3.0f, false),
                                                 std::tuple(0.0f, 2.0f, false), std::tuple(-5.0f, 1.0f, false)}) {
        const Ray r = ray(vec3(0.1f, 2, 0.3f), vec3(0, -1, 0), t_min, t_max);
        each_walk(built, [&](const WideMesh& mesh, const Walks& walks) {
            EXPECT_EQ(walks.closest(mesh, r).triangle != NONE, expected);
            EXPECT_EQ(walks.any(mesh, r), expected);
        });
    }
}

TEST(MeshWalk, rays_that_are_no_numbers_hit_nothing) {
    Random random(15);
    const Built built(soup(random, 100, 3));
    const float nan = std::nanf("");
    for (const Ray& r : {ray(vec3(nan, 0, 0), vec3(0, 0, 1)), ray(vec3(0), vec3(0, nan, 1)), ray(vec3(0), vec3(0))}) {
        each_walk(built, [&](const WideMesh& mesh, const Walks& walks) {
            EXPECT_EQ(walks.closest(mesh, r).triangle, NONE);
            EXPECT_FALSE(walks.any(mesh, r));
        });
    }
}

// Rays from about one place towards about one place: the more `spread`, the less coherent.
std::vector<Ray> packet_towards(Random& random, const Triangles& triangles, float reach, float spread) {
    const Triangle& t = triangles[std::size_t(random.uniform(0, 0.999f) * float(triangles.size()))];
    const vec3 direction = random.awkward_direction(), origin = (t.a + t.b + t.c) / 3.0f - reach * direction;
    std::vector<Ray> rays;
    for (int i = 0; i < packet_size; ++i) {
        const vec3 target = origin + reach * direction + spread * random.in_cube(1);
        const vec3 from = i % 3 ? origin : origin + 0.1f * spread * random.in_cube(1);
        rays.push_back(ray(from, target - from, 0, i == 5 ? 1.02f : kernels::INFINITE));
    }
    return rays;
}

TEST(MeshWalk, eight_rays_together_find_what_each_finds_alone_to_the_last_bit) {
    Random random(19);
    const Built meshes[] = {Built(soup(random, 3, 1.5f)),    Built(soup(random, 700, 1.5f)),
                            Built(blades(random, 600)),      Built(floor_of(32)),
                            Built(soup(random, 3000, 0.1f)), Built(soup(random, 500, 30.0f, vec3(1e6f, 0, -1e6f)))};
    int found = 0;
    for (const Built& built : meshes)
        for (int i = 0; i < 3000; ++i) {
            const std::vector<Ray> rays = packet_towards(random, built.triangles, random.uniform(0.5f, 20),
                                                         i % 4 == 0 ? 0.0f : std::exp(random.uniform(-6, 2)));
            const unsigned lanes = i % 3 ? 0xffu : i < 1 ? 0u : unsigned(random.uniform(0, 255.99f));
            const WideHit untouched{-1, -2, -3, 77};
            WideHit hits[packet_size];
            std::fill_n(hits, packet_size, untouched);
            wide_closest8(built.mesh, rays.data(), lanes, hits);
            const unsigned any = wide_any8(built.mesh, rays.data(), lanes);
            for (int k = 0; k < packet_size; ++k) {
                const WideHit alone = lanes >> k & 1 ? wide_closest(built.mesh, rays[std::size_t(k)]) : untouched;
                expect_equal(hits[k], alone, rays[std::size_t(k)]);
                const bool hit = lanes >> k & 1 && alone.triangle != NONE;
                ASSERT_EQ(bool(any >> k & 1), hit) << describe(rays[std::size_t(k)]);
                found += hit;
            }
            if (HasFatalFailure()) return;
        }
    EXPECT_GT(found, 40000);
}

TEST(MeshWalk, a_hit_knows_its_triangle_by_heart) {
    Random random(20);
    const Built built(blades(random, 300));
    for (const Ray& r : rays_towards(random, built.triangles, 500, 8)) {
        each_walk(built, [&](const WideMesh& mesh, const Walks& walks) {
            const WideHit hit = walks.closest(mesh, r);
            ASSERT_EQ(hit.block == nullptr, hit.triangle == NONE);
            if (hit.triangle == NONE) return;
            const Triangle& t = built.triangles[hit.triangle];
            const vec3 expected = glm::cross(t.b - t.a, t.c - t.a);
            EXPECT_LT(glm::length(walks.normal(hit) - expected),
                      1e-6f * glm::length(t.b - t.a) * glm::length(t.c - t.a));
            EXPECT_EQ(walks.normal(hit), wide_normal(wide_closest(built.mesh, r)));
        });
    }
}

TEST(MeshWalk, a_refitted_tree_finds_what_brute_force_finds_where_triangles_are_now) {
    Random random(21);
    for (const WidePreset& preset : wide_presets())
        for (const int count : {1, 5, 700}) {
            Built built(blades(random, count), preset);
            for (Triangle& t : built.triangles)
                for (vec3* p : {&t.a, &t.b, &t.c}) *p = 1.7f * vec3(-p->z, p->y + std::sin(p->x), p->x) + vec3(3, 0, 0);
            refit_wide_bvh(built.tree.units, built.triangles);
            const Built moved(built.triangles, preset);
            built.mesh.lower = moved.mesh.lower;
            built.mesh.upper = moved.mesh.upper;
            built.compact = moved.compact;
            EXPECT_GT(check(built, rays_towards(random, built.triangles, 1000, 8)), 700) << preset.name;
        }
}

TEST(MeshWalk, one_ray_that_is_no_number_spoils_no_packet) {
    const Built built(floor_of(16));
    const float nan = std::nanf("");
    for (const Ray& odd : {ray(vec3(nan, 0, 0), vec3(0, 0, 1)), ray(vec3(0, 1, 0), vec3(0, nan, 1)),
                           ray(vec3(0, 1, 0), vec3(0)), ray(vec3(0.1f, 2, 0.1f), vec3(0, -1, 0), -3, 1)}) {
        std::vector<Ray> rays(packet_size, ray(vec3(0.1f, 2, 0.3f), vec3(0, -1, 0)));
        rays[3] = odd;
        WideHit hits[packet_size];
        wide_closest8(built.mesh, rays.data(), 0xff, hits);
        for (std::size_t i = 0; i < packet_size; ++i) {
            EXPECT_EQ(hits[i].triangle != NONE, i != 3);
            EXPECT_EQ(wide_any8(built.mesh, rays.data(), 0xff), 0xf7u);
        }
    }
}

TEST(MeshWalk, spatial_splits_name_triangles_twice_and_lower_the_cost) {
    Random random(16);
    Triangles list = soup(random, 3000, 0.1f);
    for (const Triangle& t : blades(random, 60)) list.push_back(t);
    const WideBvh whole = build_wide_mesh(list, wide_presets()[1]), split = build_wide_mesh(list, wide_presets()[2]);
    EXPECT_EQ(whole.statistics.triangle_count, list.size());
    EXPECT_GT(split.statistics.triangle_count, list.size() * 21 / 20);
    EXPECT_LE(split.statistics.triangle_count, list.size() * 13 / 10);
    EXPECT_LT(split.statistics.sah_cost, 0.9 * whole.statistics.sah_cost);
}

TEST(MeshWalk, the_tree_does_not_depend_on_the_number_of_threads) {
    Random random(17);
    const Triangles list = blades(random, 20000);
    for (const auto build : {build_wide_mesh, build_compact_mesh})
        for (const WidePreset& preset : wide_presets()) {
            WideBvh first;
            for (const int threads : {1, 2, 5}) {
                const ThreadLimit limit(threads);
                const WideBvh tree = build(list, preset);
                if (threads == 1) first = tree;
                ASSERT_EQ(tree.units.size(), first.units.size());
                EXPECT_EQ(std::memcmp(tree.units.data(), first.units.data(), tree.units.size() * sizeof(tree.units[0])),
                          0);
            }
        }
}

TEST(MeshWalk, the_compact_layout_takes_less_than_three_fifths_where_triangles_share_vertices) {
    const Built built(triangles_of(icosphere(5)));
    EXPECT_LT(built.compact_tree.units.size() * 5, built.tree.units.size() * 3);
    EXPECT_EQ(built.compact_tree.statistics.triangle_count, built.triangles.size());
    // Of those that share none, no more than gathered vertices take.
    Random random(22);
    const Built apart(soup(random, 5000, 1));
    EXPECT_LT(apart.compact_tree.units.size(), apart.tree.units.size());
}

// Rays from inside of a closed mesh, for each counted one alone and eight together: how many get out.
int leaks(const Built& built, vec3 inside, float radius, int count) {
    Random random(18);
    int escaped = 0;
    for (int i = 0; i < count; ++i) {
        const Ray r = ray(inside + random.in_cube(radius), random.awkward_direction());
        escaped += wide_closest(built.mesh, r).triangle == NONE;
        escaped += !wide_any(built.mesh, r);
        escaped += compact_closest(built.compact, r).triangle == NONE;
        escaped += !compact_any(built.compact, r);
        Ray rays[packet_size];
        for (Ray& neighbour : rays) neighbour = ray(r.origin, r.direction + random.in_cube(0.01f));
        WideHit hits[packet_size];
        wide_closest8(built.mesh, rays, 0xff, hits);
        for (const WideHit& hit : hits) escaped += hit.triangle == NONE;
        escaped += wide_any8(built.mesh, rays, 0xff) != 0xff;
    }
    return escaped;
}

TEST(MeshWalk, no_ray_leaves_a_closed_mesh) {
    const Built built(triangles_of(icosphere(5)));
    EXPECT_EQ(leaks(built, vec3(0), 0.5f, 50000), 0);
    EXPECT_EQ(leaks(built, vec3(0), 0.0f, 50000), 0);  // straight at vertices and edges
}

TEST(MeshWalkSlow, ten_million_rays_stay_inside_of_a_closed_mesh) {
    const Built built(triangles_of(icosphere(7)));
    // The corners of the cube that rays begin in are within the ball, too.
    EXPECT_EQ(leaks(built, vec3(0), 0.57f, 1000000), 0);
}

}  // namespace
}  // namespace spinel::mesh_walk_test
