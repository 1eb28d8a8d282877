#include "kernels/voxels.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <tuple>
#include <vector>

#include "devices/cpu/voxel_walk.h"
#include "geometry/test_scene.h"
#include "geometry/voxels/dense_walk.h"
#include "kernels/traverse.h"
#include "render/reference.h"

namespace spinel::voxels_test {
namespace {

using namespace test;
using kernels::Hit;

constexpr std::uint32_t GLASS = 0, WATER = 1;
// Palette 1: stone, 2 and 3: glass of two materials and one interior, 4: water, 5: fog without a material, 6:
// nothing at all.
const std::vector<kernels::Slot> SLOTS = {{0, NO}, {1, GLASS}, {2, GLASS}, {3, WATER}, {NO, 2}, {NO, NO}};

struct Grid3 {
    explicit Grid3(ivec3 s) : size(s), cells(std::size_t(s.x) * std::size_t(s.y) * std::size_t(s.z), 0) {}
    std::uint16_t& at(int x, int y, int z) { return cells[std::size_t(x + size.x * (y + size.y * z))]; }
    operator VoxelGeometry() const { return voxels_of(size, cells); }

    ivec3 size;
    std::vector<std::uint16_t> cells;
};

Hit closest(const kernels::SceneView& scene, const kernels::Ray& r) {
    Hit hit = kernels::no_hit(r.t_max);
    kernels::voxels_closest(scene, 0, scene.instances.at[0].slot_first, r, hit);
    if (hit.t < r.t_max) hit.instance = 0;
    return hit;
}

// All interfaces along a ray, each found from just behind the one before.
std::vector<Hit> all_hits(const kernels::SceneView& scene, kernels::Ray r) {
    std::vector<Hit> hits;
    for (int i = 0; i < 1000; ++i) {
        const Hit hit = closest(scene, r);
        if (!kernels::is_hit(hit)) break;
        hits.push_back(hit);
        r.t_min = hit.t;
    }
    return hits;
}

TEST(VoxelWalk, a_block_of_glass_of_several_palette_entries_has_no_inner_faces) {
    Grid3 grid({6, 6, 6});
    Random random(1);
    for (std::uint16_t& cell : grid.cells) cell = std::uint16_t(2 + random.below(2));
    TestScene parts;
    parts.add(grid);
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
    const kernels::SceneView& scene = parts.view();
    for (int i = 0; i < 20000; ++i) {
        const vec3 target = vec3(3) + random.in_cube(2.9f);
        const vec3 direction = glm::normalize(random.awkward_direction());
        const std::vector<Hit> hits = all_hits(scene, ray(target - 20.0f * direction, direction));
        ASSERT_EQ(hits.size(), 2u);
        ASSERT_LT(glm::dot(hits[0].normal, direction), 0);  // in …
        ASSERT_GT(glm::dot(hits[1].normal, direction), 0);  // … and out
        // From inside there is the exit alone.
        ASSERT_EQ(all_hits(scene, ray(target, direction)).size(), 1u);
    }
}

TEST(VoxelWalk, glass_in_water_has_one_interface) {
    Grid3 grid({5, 1, 1});
    grid.at(0, 0, 0) = grid.at(1, 0, 0) = grid.at(4, 0, 0) = 4;
    grid.at(2, 0, 0) = 2;
    grid.at(3, 0, 0) = 3;
    TestScene parts;
    parts.add(grid);
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
    const std::vector<Hit> hits = all_hits(parts.view(), ray(vec3(-1, 0.25f, 0.5f), vec3(1, 0, -0.0f)));
    ASSERT_EQ(hits.size(), 4u);
    const int cells[] = {0, 2, 4, 4};  // the owner is what is entered; into air, what is left
    const std::uint32_t palettes[] = {4, 2, 4, 4};
    const float ts[] = {1, 3, 5, 6};
    const float normals[] = {-1, -1, -1, 1};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(hits[i].cell, ivec3(cells[i], 0, 0));
        EXPECT_EQ(hits[i].primitive, palettes[i]);
        EXPECT_EQ(hits[i].t, ts[i]);
        EXPECT_EQ(hits[i].normal, vec3(normals[i], 0, 0));
        EXPECT_EQ(hits[i].face, normals[i] > 0 ? 1u : 0u);
        EXPECT_EQ(hits[i].uv, vec2(0.25f, 0.5f));
    }
}

TEST(VoxelWalk, stone_in_glass_stops_the_ray_and_a_slot_without_anything_is_air) {
    Grid3 grid({4, 1, 1});
    grid.at(0, 0, 0) = 6;
    grid.at(1, 0, 0) = 2;
    grid.at(2, 0, 0) = grid.at(3, 0, 0) = 1;
    TestScene parts;
    parts.add(grid);
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
    const kernels::SceneView& scene = parts.view();
    const kernels::Ray r = ray(vec3(-1, 0.5f, 0.5f), vec3(1, 0, 0));
    EXPECT_EQ(closest(scene, r).cell, ivec3(1, 0, 0));
    kernels::Ray behind = r;
    behind.t_min = 2.5f;
    EXPECT_EQ(closest(scene, behind).cell, ivec3(2, 0, 0));
    EXPECT_EQ(closest(scene, behind).t, 3.0f);
}

TEST(VoxelWalk, a_ray_that_starts_inside_stone_sees_it_at_once) {
    Grid3 grid({3, 3, 3});
    grid.at(1, 1, 1) = 1;
    TestScene parts;
    parts.add(grid);
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
    const kernels::SceneView& scene = parts.view();
    for (const float t_min : {0.0f, 0.25f}) {
        const Hit hit = closest(scene, ray(vec3(1.25f, 1.5f, 1.5f), vec3(1, 0.1f, 0), t_min));
        EXPECT_GT(hit.t, t_min);
        EXPECT_NEAR(hit.t, t_min, 1e-6);
        EXPECT_EQ(hit.cell, ivec3(1));
        EXPECT_EQ(hit.normal, vec3(-1, 0, 0));
    }
    // On a face the direction decides: inwards it is in the stone, outwards it is in the air.
    EXPECT_NEAR(closest(scene, ray(vec3(1, 1.5f, 1.5f), vec3(1, 0, 0))).t, 0, 1e-6);
    EXPECT_EQ(closest(scene, ray(vec3(1, 1.5f, 1.5f), vec3(1, 0, 0))).cell, ivec3(1));
    EXPECT_FALSE(kernels::is_hit(closest(scene, ray(vec3(1, 1.5f, 1.5f), vec3(-1, 0, 0)))));
    EXPECT_FALSE(kernels::is_hit(closest(scene, ray(vec3(2, 1.5f, 1.5f), vec3(1, 0, 0)))));
    EXPECT_EQ(closest(scene, ray(vec3(2, 1.5f, 1.5f), vec3(-1, 0, 0))).cell, ivec3(1));
    // Along a face, floor() decides: the plane y = 1 belongs to cell 1, y = 2 to cell 2.
    EXPECT_EQ(closest(scene, ray(vec3(-1, 1, 1.5f), vec3(1, 0, 0))).t, 2.0f);
    EXPECT_FALSE(kernels::is_hit(closest(scene, ray(vec3(-1, 2, 1.5f), vec3(1, -0.0f, 0)))));
}

// Random grids against all planes sorted, classes looked up at midpoints.
TEST(VoxelWalk, equals_the_naive_twin) {
    Random random(2);
    int hits = 0, ambiguous = 0, rays = 0;
    for (int round = 0; round < 40; ++round) {
        Grid3 grid(ivec3(1 + random.below(12), 1 + random.below(12), 1 + random.below(12)));
        const std::uint32_t density = 1 + random.below(10);
        for (std::uint16_t& cell : grid.cells) cell = random.below(10) < density ? std::uint16_t(random.below(7)) : 0;
        TestScene parts;
        parts.add(grid);
        parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
        const kernels::SceneView& scene = parts.view();
        for (int i = 0; i < 3000; ++i) {
            const vec3 size(grid.size);
            vec3 origin = 0.5f * size + random.in_cube() * size * (i % 2 ? 0.5f : 1.5f);
            // Aimed at corners and edges of cells, from points on the lattice: planes meet at the same t.
            if (i % 5 == 0) origin = glm::round(origin);
            vec3 direction = random.awkward_direction() * std::exp(random.uniform(-5, 5));
            if (i % 7 == 0) direction = glm::round(origin + random.in_cube(5)) - origin;
            if (kernels::is_black(direction)) continue;
            const kernels::Ray r = ray(origin, direction, i % 3 ? 0.0f : random.uniform(0, 1) / glm::length(direction));
            const Hit hit = closest(scene, r);
            const ReferenceHit expected = reference_hit(scene, r, kernels::TRACE_ALL);
            ++rays;
            const double tolerance =
                3e-6 * (glm::length(origin) + 12) / glm::length(direction) + 1e-5 * std::abs(expected.t);
            const bool found = kernels::is_hit(hit), wanted = expected.hit.instance == 0;
            if (found && wanted && std::abs(hit.t - expected.t) <= tolerance) {
                ++hits;
                if (hit.cell != expected.hit.cell || hit.face != expected.hit.face) ++ambiguous;  // edges, corners
                continue;
            }
            if (!found && !wanted) continue;
            // A ray through an edge or a corner, as exactly as floats can tell, may see either side of it:
            // then some ray beside it must.
            bool explained = false;
            for (int j = 0; j < 64 && !explained; ++j) {
                kernels::Ray beside = r;
                beside.origin += 4e-6f * (glm::abs(origin) + 1.0f) * random.in_cube();
                beside.direction += 1e-6f * glm::length(direction) * random.in_cube();
                const ReferenceHit other = reference_hit(scene, beside, kernels::TRACE_ALL);
                explained =
                    (other.hit.instance == 0) == found && (!found || std::abs(hit.t - other.t) <= 4 * tolerance);
            }
            ASSERT_TRUE(explained) << describe(r) << " round " << round << " hit " << hit.t << " expected "
                                   << expected.t;
            ++ambiguous;
        }
    }
    EXPECT_GT(hits, rays / 4);
    EXPECT_LT(ambiguous, rays / 8);
}

// However a ray crosses a closed shell of stone, it does not get through.
TEST(VoxelWalk, no_ray_leaves_a_closed_room) {
    Grid3 grid({16, 16, 16});
    for (int z = 0; z < 16; ++z) {
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) {
                const bool wall = std::min({x, y, z}) == 0 || std::max({x, y, z}) == 15;
                grid.at(x, y, z) = wall ? 1 : 0;
            }
        }
    }
    TestScene parts;
    parts.add(grid);
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
    const kernels::SceneView& scene = parts.view();
    Random random(3);
    for (int i = 0; i < 300000; ++i) {
        vec3 origin = vec3(8) + random.in_cube(6.9f);
        if (i % 3 == 0) origin = glm::round(origin);
        vec3 direction = random.awkward_direction();
        if (i % 2 == 0) direction = glm::round(vec3(8) + random.in_cube(8)) - origin;
        if (kernels::is_black(direction)) continue;
        const kernels::Ray r = ray(origin, direction);
        const Hit hit = closest(scene, r);
        ASSERT_TRUE(kernels::is_hit(hit)) << describe(r);
        const vec3 p = kernels::ray_at(r, hit.t);
        ASSERT_NEAR(kernels::max_component(glm::abs(p - vec3(8))), 7, 1e-4) << describe(r);
    }
}

// ------------------------------------------------------------------------------------------- the tree and plain walks
// Sets of several levels: blocks of one palette index, single cells, and much that is empty.
VoxelGeometry random_set(Random& random, int largest_edge, bool share) {
    const auto below = [&] { return int(1 + random.below(std::uint32_t(largest_edge))); };
    const ivec3 size(below(), below(), below());
    const int block = 1 << random.below(6);
    const std::uint32_t density = 1 + random.below(8), seed = random.below(1u << 30), noise = random.below(100);
    std::vector<std::uint16_t> cells;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const std::uint32_t h = (std::uint32_t(x / block) * 73856093u ^ std::uint32_t(y / block) * 19349663u ^
                                         std::uint32_t(z / block) * 83492791u ^ seed) *
                                        2654435761u;
                std::uint32_t palette = (h >> 8) % 24 < density ? 1 + (h >> 16) % 6 : 0;
                if (noise < 50 && random.below(300) == 0) palette = random.below(7);
                cells.push_back(std::uint16_t(palette));
            }
    Result<VoxelTreePointer> tree = build_voxel_tree(size, cells, {.share = share});
    return {*tree};
}

// Random and adversarial: from inside and outside, parallel to axes and planes, along edges, through corners.
kernels::Ray awkward_ray(Random& random, ivec3 set_size, int kind) {
    const vec3 size(set_size);
    for (;;) {
        vec3 origin = 0.5f * size + random.in_cube() * size * (kind % 2 ? 0.5f : 1.5f);
        if (kind % 5 == 0) origin = glm::round(origin);
        vec3 direction = random.awkward_direction() * std::exp(random.uniform(-5, 5));
        if (kind % 7 == 0) direction = glm::round(0.5f * size + random.in_cube() * size) - origin;
        if (kind % 13 == 0) direction = glm::round(random.in_cube(3));
        if (kernels::is_black(direction)) continue;
        return ray(origin, direction, kind % 3 ? 0.0f : random.uniform(0, 1) / glm::length(direction));
    }
}

void expect_equals_the_plain_walk(int ray_count, std::uint32_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    int hits = 0, rays = 0;
    for (int round = 0; rays < ray_count; ++round) {
        const VoxelGeometry set = random_set(random, 90, round % 2);
        const DenseVoxels dense = dense_voxels(*set.tree);
        TestScene parts;
        parts.add(set);
        parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
        const kernels::SceneView& scene = parts.view();
        for (int i = 0; i < 10000; ++i, ++rays) {
            kernels::Ray r = awkward_ray(random, set.tree->size(), i);
            if (i % 4 == 0) r.t_max = random.uniform(0, 100) / glm::length(r.direction);
            if (i % 17 == 0) r.origin *= std::exp(random.uniform(0, 8));
            const Hit hit = closest(scene, r);
            Hit expected = kernels::no_hit(r.t_max);
            dense_closest(scene, dense, 0, r, expected);
            hits += kernels::is_hit(hit);
            ASSERT_EQ(hit.t, expected.t) << describe(r);
            ASSERT_EQ(hit.cell, expected.cell) << describe(r);
            ASSERT_EQ(hit.face, expected.face) << describe(r);
            ASSERT_EQ(hit.primitive, expected.primitive) << describe(r);
            ASSERT_EQ(hit.uv, expected.uv) << describe(r);
            Hit fast = kernels::no_hit(r.t_max);
            cpu_voxels_closest(scene, 0, 0, r, fast);
            ASSERT_EQ(fast.t, hit.t) << describe(r);
            ASSERT_EQ(fast.cell, hit.cell) << describe(r);
            ASSERT_EQ(fast.face, hit.face) << describe(r);
            ASSERT_EQ(fast.primitive, hit.primitive) << describe(r);
        }
    }
    EXPECT_GT(hits, ray_count / 10);
}

// Eight rays of a beam, or of no relation at all: what each finds alone, each finds in company.
void expect_packets_equal_single_rays(int ray_count, std::uint32_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    int hits = 0, rays = 0;
    for (int round = 0; rays < ray_count; ++round) {
        const VoxelGeometry set = random_set(random, 90, round % 2);
        TestScene parts;
        parts.add(set);
        parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
        const kernels::SceneView& scene = parts.view();
        for (int i = 0; i < 1250; ++i, rays += packet_size) {
            const kernels::Ray beam = awkward_ray(random, set.tree->size(), i);
            const float spread = std::exp(random.uniform(-8, 1)) * glm::length(beam.direction);
            kernels::Ray packet[packet_size];
            Hit together[packet_size];
            for (int k = 0; k < packet_size; ++k) {
                kernels::Ray& r = packet[k] = i % 3 ? beam : awkward_ray(random, set.tree->size(), i);
                for (int axis = 0; axis < 3 && i % 3 && k; ++axis) {
                    // What is exactly zero stays so in some rays.
                    if (r.direction[axis] != 0 || k % 2) r.direction[axis] += spread * random.uniform(-1, 1);
                    if (i % 2) r.origin[axis] += random.uniform(-3, 3);
                    if (i % 4 == 1) r.origin[axis] = std::round(r.origin[axis]);
                }
                if (i % 7 == 0) r.t_max = random.uniform(0, 100) / glm::length(r.direction);
                together[k] = kernels::no_hit(r.t_max);
            }
            const unsigned lanes = i % 5 ? 0xffu : unsigned(random.below(256));
            const unsigned found = cpu_voxels_closest8(scene, 0, 0, 0, packet, lanes, together);
            for (int k = 0; k < packet_size; ++k) {
                const kernels::Ray& r = packet[k];
                Hit alone = kernels::no_hit(r.t_max);
                if (lanes >> k & 1) kernels::voxels_closest(scene, 0, 0, r, alone);
                ASSERT_EQ(found >> k & 1, unsigned(alone.t < r.t_max)) << describe(r);
                hits += int(found >> k & 1);
                ASSERT_EQ(together[k].t, alone.t) << describe(r);
                ASSERT_EQ(together[k].cell, alone.cell) << describe(r);
                ASSERT_EQ(together[k].face, alone.face) << describe(r);
                ASSERT_EQ(together[k].primitive, alone.primitive) << describe(r);
                ASSERT_EQ(together[k].uv, alone.uv) << describe(r);
            }
        }
    }
    EXPECT_GT(hits, ray_count / 10);
}

// Rays of no relation, in batches of any size, with beams of neighbours between them: of eight, or of 64 as wide as a
// part of a cell or as several of them.
void expect_batches_equal_single_rays(int ray_count, std::uint32_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    int hits = 0, rays = 0;
    for (int round = 0; rays < ray_count; ++round) {
        const VoxelGeometry set = random_set(random, 90, round % 2);
        TestScene parts;
        parts.add(set);
        parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), SLOTS);
        const kernels::SceneView& scene = parts.view();
        for (int i = 0; i < 100; ++i) {
            // Hits of large batches are written in another way.
            std::vector<kernels::Ray> batch(i == 99 ? 20000 : random.below(300));
            std::vector<Hit> expected(batch.size());
            const float spread = std::exp(random.uniform(-8, -2)), moved = i % 8 < 4 ? 0 : random.uniform(0, 2);
            for (std::size_t k = 0; k < batch.size(); ++k) {
                kernels::Ray& r = batch[k] = awkward_ray(random, set.tree->size(), int(k + std::size_t(i)));
                if (i % 4 == 1 && k % 64 >= 8 && k % 8) {
                    r = batch[k / 8 * 8];
                    r.direction *= random.uniform(0.95f, 1.05f);
                    r.origin.x += random.uniform(-3, 3);
                }
                if (i % 4 == 3 && k % 64) {
                    r = batch[k / 64 * 64];
                    r.direction += spread * glm::length(r.direction) * random.in_cube();
                    r.origin += moved * random.in_cube();
                    if (i % 3 == 0) r.origin = glm::round(r.origin);
                }
                if (k % 4 == 0) r.t_max = random.uniform(0, 100) / glm::length(r.direction);
                if (k % 17 == 0 && i % 4 != 3) r.origin *= std::exp(random.uniform(0, 8));
                expected[k] = kernels::no_hit(r.t_max);
                kernels::voxels_closest(scene, 0, 0, r, expected[k]);
                if (expected[k].t < r.t_max) expected[k].instance = 7;
            }
            for (const auto walk : {cpu_voxels_closest_stream, cpu_voxels_closest_batch}) {
                std::vector<Hit> found(batch.size());
                walk(scene, 0, 0, 7, batch, found.data());
                for (std::size_t k = 0; k < batch.size(); ++k) {
                    ASSERT_EQ(found[k].instance, expected[k].instance) << describe(batch[k]);
                    ASSERT_EQ(found[k].t, expected[k].t) << describe(batch[k]);
                    ASSERT_EQ(found[k].cell, expected[k].cell) << describe(batch[k]);
                    ASSERT_EQ(found[k].face, expected[k].face) << describe(batch[k]);
                    ASSERT_EQ(found[k].primitive, expected[k].primitive) << describe(batch[k]);
                    ASSERT_EQ(found[k].uv, expected[k].uv) << describe(batch[k]);
                    ASSERT_EQ(found[k].normal, expected[k].normal) << describe(batch[k]);
                    hits += found[k].instance == 7;
                }
            }
            rays += int(batch.size());
        }
    }
    EXPECT_GT(hits, ray_count / 10);
}

// The same walk in double precision, cell by cell.
struct ExactHit {
    double t;  // infinity: none
    ivec3 cell = {0, 0, 0};
    std::uint32_t face = 0;
};
ExactHit exact_hit(const kernels::SceneView& scene, const DenseVoxels& grid, glm::dvec3 o, glm::dvec3 d, double t_min) {
    constexpr double never = std::numeric_limits<double>::infinity();
    const auto palette_at = [&](ivec3 c) -> std::uint32_t {
        for (int axis = 0; axis < 3; ++axis)
            if (c[axis] < 0 || c[axis] >= grid.size[axis]) return 0;
        return grid.cells[std::size_t(c.x) +
                          std::size_t(grid.size.x) * (std::size_t(c.y) + std::size_t(grid.size.y) * std::size_t(c.z))];
    };
    double enter = t_min, leave = never;
    for (int axis = 0; axis < 3; ++axis) {
        if (d[axis] == 0) {
            if (o[axis] < 0 || o[axis] >= grid.size[axis]) return {never};
            continue;
        }
        const double t0 = -o[axis] / d[axis], t1 = (grid.size[axis] - o[axis]) / d[axis];
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1));
    }
    if (!(enter < leave)) return {never};
    ivec3 cell(0);
    int last_axis = -1;
    for (int axis = 0; axis < 3; ++axis) {
        if (enter > t_min && d[axis] != 0 && (d[axis] > 0 ? -o[axis] : grid.size[axis] - o[axis]) / d[axis] == enter)
            last_axis = axis;
        const double p = o[axis] + enter * d[axis];
        cell[axis] = d[axis] < 0 && p == std::floor(p) ? int(p) - 1 : int(std::floor(p));
        cell[axis] = std::clamp(cell[axis], 0, grid.size[axis] - 1);
    }
    std::uint32_t palette = palette_at(cell), medium = kernels::voxel_class(scene, 0, palette);
    if (last_axis >= 0 && medium != kernels::VOXEL_AIR)
        return {enter, cell, std::uint32_t(2 * last_axis + (d[last_axis] < 0))};
    if (last_axis < 0 && medium == kernels::VOXEL_OPAQUE) {
        const glm::dvec3 m = glm::abs(d);
        const int axis = m.x >= m.y && m.x >= m.z ? 0 : m.y >= m.z ? 1 : 2;
        return {t_min, cell, std::uint32_t(2 * axis + (d[axis] < 0))};
    }
    for (;;) {
        int axis = -1;
        double t = never;
        for (int a = 0; a < 3; ++a) {
            if (d[a] == 0) continue;
            const double plane = (cell[a] + (d[a] > 0 ? 1 : 0) - o[a]) / d[a];
            if (plane < t) t = plane, axis = a;
        }
        const ivec3 left = cell;
        cell[axis] += d[axis] > 0 ? 1 : -1;
        palette = palette_at(cell);
        const std::uint32_t entered = kernels::voxel_class(scene, 0, palette);
        if (entered != medium) {
            const bool out = entered == kernels::VOXEL_AIR;
            return {t, out ? left : cell, std::uint32_t(2 * axis + (out == (d[axis] > 0)))};
        }
        if (cell[axis] < 0 || cell[axis] >= grid.size[axis]) return {never};
    }
}

// Whether a walk that starts in `start` may see this hit (or, without one, none) if planes that are met within 0.002
// voxels of each other are passed in any order. A ray along a lattice meets many such edges and may choose at each
// anew.
bool is_reachable(const kernels::SceneView& scene, const DenseVoxels& grid, glm::dvec3 o, glm::dvec3 d, ivec3 start,
                  const Hit& hit) {
    const auto is_outside = [&](ivec3 c) {
        return glm::any(glm::lessThan(c, ivec3(0))) || glm::any(glm::greaterThanEqual(c, grid.size));
    };
    const auto class_at = [&](ivec3 c) {
        return is_outside(c) ? kernels::VOXEL_AIR
                             : kernels::voxel_class(
                                   scene, 0, grid.cells[kernels::uint(c.x + grid.size.x * (c.y + grid.size.y * c.z))]);
    };
    const kernels::uint medium = class_at(start);
    const auto order = [](ivec3 a, ivec3 b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); };
    std::set<ivec3, decltype(order)> seen(order);
    std::vector<ivec3> open = {start};
    while (!open.empty()) {
        const ivec3 cell = open.back();
        open.pop_back();
        if (!seen.insert(cell).second) continue;
        double t[3], nearest = std::numeric_limits<double>::infinity();
        for (int a = 0; a < 3; ++a) {
            t[a] = d[a] == 0 ? std::numeric_limits<double>::infinity() : (cell[a] + (d[a] > 0 ? 1 : 0) - o[a]) / d[a];
            nearest = std::min(nearest, t[a]);
        }
        for (int a = 0; a < 3; ++a) {
            if (d[a] == 0 || (t[a] - nearest) * std::abs(d[a]) > 0.002) continue;
            ivec3 next = cell;
            next[a] += d[a] > 0 ? 1 : -1;
            const kernels::uint entered = class_at(next);
            if (entered != medium) {
                const bool out = entered == kernels::VOXEL_AIR;
                if (kernels::is_hit(hit) && hit.cell == (out ? cell : next) &&
                    hit.face == std::uint32_t(2 * a + (out == (d[a] > 0))))
                    return true;
            } else if (is_outside(next)) {
                if (!kernels::is_hit(hit)) return true;
            } else {
                open.push_back(next);
            }
        }
    }
    return false;
}

// The same for all cells in which the walk may begin.
bool may_see(const kernels::SceneView& scene, const DenseVoxels& grid, glm::dvec3 o, glm::dvec3 d, double t_min,
             const Hit& hit) {
    double enter = t_min;
    for (int a = 0; a < 3; ++a)
        if (d[a] != 0) enter = std::max(enter, (d[a] > 0 ? -o[a] : grid.size[a] - o[a]) / d[a]);
    const glm::dvec3 p = o + enter * d;
    for (int corner = 0; corner < 8; ++corner) {
        ivec3 start;
        for (int a = 0; a < 3; ++a) {
            start[a] = int(std::floor(p[a] + (corner >> a & 1 ? 0.002 : -0.002)));
            start[a] = std::clamp(start[a], 0, grid.size[a] - 1);
        }
        // On the face that it comes in by.
        const int axis = int(hit.face >> 1), plane = hit.cell[axis] + int(hit.face & 1);
        if (kernels::is_hit(hit) && hit.cell == start && std::abs(plane - p[axis]) < 0.002) return true;
        if (is_reachable(scene, grid, o, d, start, hit)) return true;
    }
    return false;
}

void expect_equals_the_exact_walk(int ray_count, std::uint32_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    int hits = 0, ties = 0, rays = 0;
    for (int round = 0; rays < ray_count; ++round) {
        const VoxelGeometry set = random_set(random, 120, round % 2);
        const DenseVoxels dense = dense_voxels(*set.tree);
        TestScene parts;
        parts.add(set);
        // Far from the world's origin; the ray is carried into local space once, for both.
        parts.place(kernels::GEOMETRY_VOXELS, 0, affine(glm::mat3(1), vec3(1e6f, -1e6f, 2e6f)), SLOTS);
        const kernels::SceneView& scene = parts.view();
        for (int i = 0; i < 10000; ++i, ++rays) {
            kernels::Ray r = awkward_ray(random, set.tree->size(), i);
            if (i % 4 == 0) {
                r.origin += vec3(1e6f, -1e6f, 2e6f);
                r = kernels::ray_to_local(scene.instances.at[0], r);
            }
            const Hit hit = closest(scene, r);
            const glm::dvec3 o(r.origin), d(r.direction);
            const auto agrees = [&](const ExactHit& e) {
                if (!kernels::is_hit(hit)) return std::isinf(e.t);
                return hit.cell == e.cell && hit.face == e.face &&
                       std::abs(double(hit.t) - e.t) * std::abs(d[int(e.face >> 1)]) < 0.005;  // along the face's axis
            };
            const ExactHit expected = exact_hit(scene, dense, o, d, double(r.t_min));
            hits += kernels::is_hit(hit);
            if (agrees(expected)) {
                if (!kernels::is_hit(hit)) continue;
                // Three roundings; where a ray starts in stone, the next number above t_min.
                ASSERT_NEAR(double(hit.t), expected.t, 3e-7 * expected.t + 1e-29) << describe(r);
                continue;
            }
            // Within 0.002 voxels of an edge or a corner either side may be seen.
            bool tie = false;
            for (int j = 0; j < 200 && !tie; ++j) {
                const glm::dvec3 beside = o + 0.002 * glm::dvec3(random.in_cube());
                tie = agrees(exact_hit(scene, dense, beside, d, double(r.t_min)));
            }
            tie = tie || may_see(scene, dense, o, d, double(r.t_min), hit);
            ASSERT_TRUE(tie) << describe(r) << " round " << round << " hit " << hit.t << " expected " << expected.t;
            ++ties;
        }
    }
    EXPECT_GT(hits, ray_count / 10);
    EXPECT_LT(ties, ray_count / 10);
}

TEST(VoxelWalk, equals_the_plain_walk_bit_for_bit) { expect_equals_the_plain_walk(100000, 4); }
TEST(VoxelWalk, packets_equal_single_rays_bit_for_bit) { expect_packets_equal_single_rays(200000, 5); }
TEST(VoxelWalk, batches_equal_single_rays_bit_for_bit) { expect_batches_equal_single_rays(200000, 8); }
TEST(VoxelWalk, equals_the_walk_in_double_precision) { expect_equals_the_exact_walk(100000, 5); }
TEST(VoxelWalkSlow, equals_the_plain_walk_bit_for_bit) { expect_equals_the_plain_walk(10000000, 6); }
TEST(VoxelWalkSlow, packets_equal_single_rays_bit_for_bit) { expect_packets_equal_single_rays(10000000, 7); }
TEST(VoxelWalkSlow, batches_equal_single_rays_bit_for_bit) { expect_batches_equal_single_rays(10000000, 9); }
TEST(VoxelWalkSlow, equals_the_walk_in_double_precision) { expect_equals_the_exact_walk(10000000, 7); }

TEST(VoxelWalk, a_cell_is_found_as_on_the_host) {
    Random random(8);
    for (const bool share : {false, true}) {
        const VoxelGeometry set = random_set(random, 100, share);
        TestScene parts;
        parts.add(set);
        const kernels::SceneView& scene = parts.view();
        for (int i = 0; i < 20000; ++i) {
            const ivec3 cell = ivec3(random.in_cube(0.6f) * vec3(set.tree->size()) + 0.5f * vec3(set.tree->size()));
            ASSERT_EQ(kernels::voxel_at(scene, scene.voxel_grids.at[0], cell), set.tree->at(cell));
        }
    }
}

TEST(VoxelWalk, palette_indices_above_255_are_told) {
    std::vector<std::uint16_t> cells(64, 300);
    cells[63] = 65535;
    TestScene parts;
    parts.add(voxels_of({4, 4, 4}, cells));
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), std::vector<kernels::Slot>(65535, OPAQUE_SLOT));
    const kernels::SceneView& scene = parts.view();
    EXPECT_EQ(closest(scene, ray({5, 3.5f, 3.5f}, {-1, 0, 0})).primitive, 65535u);
    EXPECT_EQ(closest(scene, ray({5, 2.5f, 3.5f}, {-1, 0, 0})).primitive, 300u);
}

// One voxel at each end of the largest set: a few steps lead from one to the other.
TEST(VoxelWalk, a_million_empty_cells_are_crossed_at_once) {
    const int n = VoxelTree::max_edge;
    const auto tree = build_voxel_tree({n, n, n}, {{{0, 7, 9}, 1}, {{n - 1, 7, 9}, 2}});
    TestScene parts;
    parts.add(VoxelGeometry{*tree});
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), {OPAQUE_SLOT, OPAQUE_SLOT});
    const kernels::SceneView& scene = parts.view();
    const Hit right = closest(scene, ray({1.5f, 7.5f, 9.5f}, {1, 0, 0}));
    EXPECT_EQ(right.cell, ivec3(n - 1, 7, 9));
    EXPECT_EQ(right.t, float(n) - 2.5f);
    EXPECT_EQ(closest(scene, ray({1.5f, 7.5f, 9.5f}, {-1, 0, 0})).cell, ivec3(0, 7, 9));
    EXPECT_FALSE(kernels::is_hit(closest(scene, ray({1.5f, 8.5f, 9.5f}, {1, 0, 0}))));
}

#ifdef __SSE4_1__
// By hand: cubes of 32, 16, 8, 4, 2 and 1 empty cells, then the voxel; a node of each level.
TEST(VoxelWalk, what_a_ray_costs_is_counted) {
    const auto tree = build_voxel_tree({64, 64, 64}, {{{63, 1, 1}, 1}});
    TestScene parts;
    parts.add(VoxelGeometry{*tree});
    parts.place(kernels::GEOMETRY_VOXELS, 0, mat4x3(1), {OPAQUE_SLOT});
    const VoxelWalkCount count = cpu_voxels_count(parts.view(), 0, 0, ray({-1, 1.5f, 1.5f}, {1, 0, 0}));
    EXPECT_EQ(count.nodes, 3u);
    EXPECT_EQ(count.cubes, 7u);
}
#endif

}  // namespace
}  // namespace spinel::voxels_test
