#include "kernels/sdf_voxels.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "geometry/test_scene.h"
#include "geometry/voxels/dense_walk.h"
#include "kernels/surface.h"
#include "kernels/traverse.h"
#include "render/pictures.h"

namespace spinel::sdf_voxels_test {
namespace {

using namespace test;
using kernels::Hit;

std::string scene_text(const std::string& expression, const std::string& more = "") {
    return R"({"version": 1, "camera": {}, "materials": {"a": {"type": "diffuse"}, "b": {"type": "diffuse"}, "g": {"type": "dielectric"}},
               "objects": [{"geometry": {"type": "sdf_voxels", "expression": ")" +
           expression + "\"" + more + R"(}, "material": ["a", "b", "g"]}]})";
}

// The same cells, sampled once and stored.
DenseVoxels sampled(const kernels::SceneView& scene) {
    const kernels::VoxelGrid& grid = scene.voxel_grids.at[0];
    DenseVoxels dense{grid.size, {}};
    for (int z = 0; z < grid.size.z; ++z)
        for (int y = 0; y < grid.size.y; ++y)
            for (int x = 0; x < grid.size.x; ++x)
                dense.cells.push_back(std::uint8_t(kernels::voxel_at(scene, grid, {x, y, z})));
    return dense;
}

void expect_the_walk_over_every_cell(const std::string& expression, const std::string& more) {
    const auto compiled = compile_text(scene_text(expression, more));
    ASSERT_TRUE(compiled) << compiled.error().message;
    const kernels::SceneView scene = compiled->view();
    const DenseVoxels dense = sampled(scene);
    const vec3 size(dense.size);
    Random random(17);
    int found = 0;
    for (int i = 0; i < 20000; ++i) {
        const bool awkward = i % 2;
        vec3 from = 0.5f * size + random.in_cube(i % 5 ? 1.0f : 0.5f) * size;
        vec3 d = awkward ? random.awkward_direction() : random.direction();
        if (i % 3 == 0) d = 0.5f * size + 0.4f * random.in_cube() * size - from;
        if (awkward && i % 4 == 1) from = glm::floor(from);
        kernels::Ray r = ray(from, d * random.uniform(0.01f, 10));
        if (i % 7 == 0) r.t_max = random.uniform(0, 20);
        Hit a = kernels::no_hit(r.t_max), b = a;
        kernels::sdf_voxels_closest(scene, 0, 0, r, a);
        dense_closest(scene, dense, 0, r, b);
        ASSERT_EQ(a.t, b.t) << describe(r);
        if (!(a.t < r.t_max)) continue;
        ++found;
        ASSERT_TRUE(a.cell == b.cell && a.face == b.face && a.primitive == b.primitive && a.normal == b.normal &&
                    a.uv == b.uv)
            << describe(r);
    }
    EXPECT_GT(found, 2000);
}

TEST(SdfVoxels, hits_are_those_of_the_walk_over_every_cell) {
    expect_the_walk_over_every_cell("sphere(30.3)", "");
    expect_the_walk_over_every_cell("intersection(gyroid(24, 3), box(70, 40, 60))", R"(, "strata": [-8, 6.5])");
    expect_the_walk_over_every_cell("union(twist(0.1, box(8, 60, 8)), translate(20, 0, 3, torus(9, 2)))",
                                    R"(, "cell": 0.5)");
    expect_the_walk_over_every_cell("displace(1.5, 0.7, sphere(20))", R"(, "strata": [0], "cell": 0.9)");
}

// Cells whose middle lies exactly on the surface are solid; glass is walked through, air inside of it too.
TEST(SdfVoxels, the_zero_itself_is_solid_and_glass_has_an_exit) {
    const auto compiled = compile_text(scene_text("box(6, 7, 7)", R"(, "strata": [-10, -9])"));
    ASSERT_TRUE(compiled) << compiled.error().message;
    const kernels::SceneView scene = compiled->view();
    const kernels::Ray r = ray({20, 0.2f, 0.1f}, {-1, 0, 0});
    const Hit enter = kernels::trace_closest(scene, r, kernels::TRACE_ALL);
    ASSERT_TRUE(kernels::is_hit(enter));
    EXPECT_FLOAT_EQ(enter.t, 17.0f);
    EXPECT_EQ(enter.primitive, 3u);
    kernels::Ray onward = r;
    onward.t_min = enter.t;
    const Hit leave = kernels::trace_closest(scene, onward, kernels::TRACE_ALL);
    ASSERT_TRUE(kernels::is_hit(leave));
    EXPECT_FLOAT_EQ(leave.t, 23.0f);
    const kernels::Surface s = kernels::surface_at(scene, r, enter);
    EXPECT_NEAR(s.position.x, 3, 1e-5f);
}

// A world of 10^15 cells takes as much room as its expression, and a ray through it few steps.
TEST(SdfVoxels, a_world_of_any_size_costs_its_expression) {
    const auto compiled = compile_text(scene_text("union(plane(0, 1, 0, 0), translate(40000, 10, 0, sphere(8)))",
                                                  R"(, "bounds": [[-50000, -50, -50000], [50000, 50, 50000]])"));
    ASSERT_TRUE(compiled) << compiled.error().message;
    EXPECT_LT(compiled->words.size() + compiled->floats.size() + compiled->voxel_nodes.size(), 100000u);
    const kernels::SceneView scene = compiled->view();
    const Hit hit = kernels::trace_closest(scene, ray({-45000, 12.5f, 0.5f}, {1, 0, 0}), kernels::TRACE_ALL);
    ASSERT_TRUE(kernels::is_hit(hit));
    EXPECT_NEAR(hit.t, 45000 + 40000 - 8, 1.5f);
}

TEST(SdfVoxels, what_has_no_cells_or_too_many_is_refused) {
    const auto thin = compile_text(scene_text("sphere(0.1)"));
    ASSERT_FALSE(thin);
    EXPECT_NE(thin.error().message.find("holds no cell"), std::string::npos) << thin.error().message;
    const auto huge = compile_text(scene_text("sphere(1000)", R"(, "cell": 0.001)"));
    ASSERT_FALSE(huge);
    EXPECT_NE(huge.error().message.find("cells along an edge"), std::string::npos) << huge.error().message;
    const auto falling = compile_text(scene_text("sphere(9)", R"(, "strata": [2, 1])"));
    ASSERT_FALSE(falling);
    EXPECT_NE(falling.error().message.find("strata that do not rise"), std::string::npos) << falling.error().message;
}

}  // namespace
}  // namespace spinel::sdf_voxels_test
