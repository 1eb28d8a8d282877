#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geometry/sphere_mesh.h"
#include "geometry/test_scene.h"
#include "geometry/voxels/triangle_cells.h"
#include "geometry/voxels/voxelise.h"

namespace spinel::mesh_voxels_test {
namespace {

using namespace test;
using glm::dvec3;

constexpr double pi = 3.14159265358979;

std::vector<dvec3> placed(const MeshGeometry& mesh, double scale, dvec3 offset) {
    std::vector<dvec3> positions;
    for (const vec3& p : mesh.positions) positions.push_back(scale * dvec3(p) + offset);
    return positions;
}

std::uint64_t count_inside(const MeshInside& inside, ivec3 size) {
    std::uint64_t count = 0;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) count += inside.at({x, y, z});
    return count;
}

TEST(MeshInside, counts_the_volume_of_a_sphere) {
    const MeshGeometry mesh = sphere_mesh(40);
    const double radius = 45.3;
    const ivec3 size(96, 97, 98);
    const MeshInside inside(size, placed(mesh, radius, {48.2, 48.7, 48.9}), mesh.triangles);
    EXPECT_TRUE(inside.closed());
    const double volume = 4.0 / 3.0 * pi * radius * radius * radius;
    EXPECT_NEAR(double(count_inside(inside, size)), volume, 0.002 * volume);
}

// Edges and vertices exactly on the lines: cells of a box whose faces pass through centres count once or not at all.
TEST(MeshInside, does_not_leak_where_lines_meet_edges_and_vertices) {
    const MeshGeometry mesh = sphere_mesh(2);  // a cube pulled out, with vertices on the axes
    for (const double scale : {10.0, 10.5, 11.0}) {
        const MeshInside inside(ivec3(32), placed(mesh, scale, dvec3(16.5)), mesh.triangles);
        EXPECT_TRUE(inside.closed());
        for (int i = 0; i < 32; ++i) {
            EXPECT_EQ(inside.at({i, 16, 16}),
                      inside.at({16, i, 16}) || inside.at({16, 16, i}) || inside.at({i, 16, 16}));
            EXPECT_FALSE(inside.at({i, 0, 0}));
            EXPECT_FALSE(inside.at({i, 31, 16}));
        }
        EXPECT_TRUE(inside.at({16, 16, 16}));
    }
}

TEST(MeshInside, is_the_same_for_a_cell_and_for_a_box_of_cells) {
    const MeshGeometry mesh = sphere_mesh(9);
    MeshGeometry open = mesh;
    open.triangles.resize(open.triangles.size() - 40);
    Random random(3);
    for (const MeshGeometry& m : {mesh, open}) {
        const MeshInside inside(ivec3(40), placed(m, 18.7, dvec3(20.1)), m.triangles);
        for (int i = 0; i < 3000; ++i) {
            const ivec3 lower(random.below(36), random.below(36), random.below(36));
            const ivec3 upper = lower + ivec3(1 + random.below(4), 1 + random.below(4), 1 + random.below(4));
            const std::optional<bool> all = inside.box(lower, upper);
            if (!all) continue;
            for (int z = lower.z; z < upper.z; ++z)
                for (int y = lower.y; y < upper.y; ++y)
                    for (int x = lower.x; x < upper.x; ++x) ASSERT_EQ(inside.at({x, y, z}), *all);
        }
    }
}

TEST(MeshInside, a_hole_or_turned_triangles_cost_little) {
    const double volume = 4.0 / 3.0 * pi * 18.7 * 18.7 * 18.7;
    MeshGeometry mesh = sphere_mesh(12);
    mesh.triangles.resize(mesh.triangles.size() - 30);  // of 1728
    const MeshInside holed(ivec3(40), placed(mesh, 18.7, dvec3(20.1)), mesh.triangles);
    EXPECT_FALSE(holed.closed());
    EXPECT_NEAR(double(count_inside(holed, ivec3(40))), volume, 0.02 * volume);
    mesh = sphere_mesh(12);
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) std::swap(mesh.triangles[i].y, mesh.triangles[i].z);
    const MeshInside turned(ivec3(40), placed(mesh, 18.7, dvec3(20.1)), mesh.triangles);
    EXPECT_NEAR(double(count_inside(turned, ivec3(40))), volume, 0.01 * volume);
}

// Separating axes as Akenine-Möller lists them, all thirteen, one by one, in the box's own place.
bool overlaps(const dvec3 (&v)[3], ivec3 cell) {
    dvec3 p[3];
    for (int i = 0; i < 3; ++i) p[i] = v[i] - dvec3(cell) - 0.5;
    const auto separates = [&](dvec3 axis) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const dvec3& q : p) {
            low = std::min(low, glm::dot(axis, q));
            high = std::max(high, glm::dot(axis, q));
        }
        const double reach = 0.5 * (std::abs(axis.x) + std::abs(axis.y) + std::abs(axis.z));
        return low > reach || high < -reach;
    };
    const dvec3 edges[3] = {p[1] - p[0], p[2] - p[1], p[0] - p[2]};
    if (separates(glm::cross(edges[0], edges[1]))) return false;
    for (int a = 0; a < 3; ++a) {
        dvec3 unit(0);
        unit[a] = 1;
        if (separates(unit)) return false;
        for (const dvec3& edge : edges)
            if (separates(glm::cross(unit, edge))) return false;
    }
    return true;
}

TEST(TriangleCells, are_those_that_no_axis_separates_from_the_triangle) {
    Random random(7);
    for (int round = 0; round < 3000; ++round) {
        dvec3 v[3];
        const float extent = round % 3 == 0 ? 12.0f : round % 3 == 1 ? 2.0f : 0.2f;
        const dvec3 middle(random.uniform(0, 12), random.uniform(0, 12), random.uniform(0, 12));
        for (dvec3& p : v) {
            p = middle;
            for (int a = 0; a < 3; ++a) p[a] += random.uniform(-extent, extent);
            if (round % 7 == 0) p = glm::round(p * 2.0) / 2.0;  // along edges and through corners
        }
        if (round % 11 == 0) v[2] = v[1];  // no area: a segment
        std::vector<int> found(12 * 12 * 12, 0);
        TriangleCells(v[0], v[1], v[2]).for_each(ivec3(0), ivec3(12), [&](ivec3 c) {
            ++found[std::size_t(c.x + 12 * (c.y + 12 * c.z))];
        });
        for (int z = 0; z < 12; ++z)
            for (int y = 0; y < 12; ++y)
                for (int x = 0; x < 12; ++x) {
                    const int times = found[std::size_t(x + 12 * (y + 12 * z))];
                    ASSERT_LE(times, 1);
                    if (overlaps(v, {x, y, z})) {
                        ASSERT_EQ(times, 1) << round << ": " << x << ' ' << y << ' ' << z;
                    } else if (times) {  // no more than rounding's worth
                        dvec3 near[3];
                        bool close = false;
                        for (int i = 0; i < 8 && !close; ++i) {
                            const dvec3 shift = 1e-6 * dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
                            for (int k = 0; k < 3; ++k) near[k] = v[k] + shift;
                            close = overlaps(near, {x, y, z});
                        }
                        ASSERT_TRUE(close) << round << ": " << x << ' ' << y << ' ' << z;
                    }
                }
    }
}

// A surface of area A and normal n cuts A·(|nx| + |ny| + |nz|) cells of a lattice on average; over a sphere that is
// 3/2·4πr² to the first order.
TEST(Voxelise, a_sphere_s_shell_has_as_many_voxels_as_integral_geometry_says) {
    const MeshGeometry mesh = sphere_mesh(60);
    const auto shell = voxelise_surface(mesh, 200);
    ASSERT_TRUE(shell);
    EXPECT_NEAR(double((*shell).tree->voxel_count()), 6 * pi * 100 * 100, 0.02 * 6 * pi * 100 * 100);
}

TEST(Voxelise, no_ray_passes_the_shell_of_a_closed_mesh) {
    const MeshGeometry mesh = sphere_mesh(7);
    const auto shell = voxelise_surface(mesh, 64);
    ASSERT_TRUE(shell);
    const VoxelTree& tree = *shell->tree;
    // What is reached from the middle through faces, edges and corners of empty cells must stay inside.
    std::vector<char> seen(64 * 64 * 64, 0);
    const auto at = [&](ivec3 c) -> char& { return seen[std::size_t(c.x + 64 * (c.y + 64 * c.z))]; };
    std::vector<ivec3> open = {ivec3(32)};
    at(ivec3(32)) = 1;
    while (!open.empty()) {
        const ivec3 c = open.back();
        open.pop_back();
        ASSERT_TRUE(glm::all(glm::greaterThan(c, ivec3(0))) && glm::all(glm::lessThan(c, ivec3(63))));
        for (int i = 0; i < 27; ++i) {
            const ivec3 next = c + ivec3(i % 3, i / 3 % 3, i / 9) - 1;
            if (tree.at(next) != 0 || at(next)) continue;
            at(next) = 1;
            open.push_back(next);
        }
    }
}

TEST(VoxelTree, a_cube_tells_what_all_of_its_cells_hold) {
    const ivec3 size(70, 33, 64);
    Random random(5);
    const auto tree =
        build_voxel_tree(size, {[&](ivec3 c) {
                                    const ivec3 b = c / 16;
                                    return std::uint16_t((b.x + b.y + b.z) % 3 == 2 ? c.x % 5 == 0 : (b.x + b.z) % 2);
                                },
                                {}});
    ASSERT_TRUE(tree);
    for (int i = 0; i < 5000; ++i) {
        const int edge = 1 << (2 * random.below(4));
        const ivec3 lower = ivec3(random.below(70), random.below(33), random.below(64)) / edge * edge;
        const auto all = (*tree)->cube(lower, edge);
        const std::uint16_t first = (*tree)->at(lower);
        bool uniform = true;
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y)
                for (int x = 0; x < edge; ++x) uniform = uniform && (*tree)->at(lower + ivec3(x, y, z)) == first;
        ASSERT_EQ(all.has_value(), uniform) << lower.x << ' ' << lower.y << ' ' << lower.z << " edge " << edge;
        if (all) { EXPECT_EQ(*all, first); }
    }
}

}  // namespace
}  // namespace spinel::mesh_voxels_test
