#include "geometry/voxels/field_voxels.h"

#include <gtest/gtest.h>

#include "geometry/sdf/sdf_reference.h"
#include "geometry/sdf/sdf_text.h"

namespace spinel::field_voxels_test {
namespace {

TEST(FieldVoxels, pruning_by_the_slope_changes_no_cell) {
    for (const char* text : {"sphere(1)", "difference(box(2, 1.4, 1), translate(0.5, 0.2, 0, sphere(0.6)))",
                             "intersection(sphere(1), gyroid(0.9, 0.15))", "twist(1.5, box(0.6, 2, 0.6))"}) {
        SCOPED_TRACE(text);
        const auto node = parse_sdf_text(text, "");
        ASSERT_TRUE(node) << node.error().message;
        const auto data = build_sdf({*node, {}});
        ASSERT_TRUE(data);
        const auto frame = fit_voxel_frame(glm::dvec3(-1.3), glm::dvec3(1.3), 70);
        mat4x3 to_object(1);
        to_object[0] = vec3(0.8f, 0.3f, 0);  // turned and stretched
        to_object[1] = vec3(-0.2f, 1.1f, 0);
        const VoxelFunction f = sdf_voxels(*data, *frame, to_object, 3);
        const auto pruned = build_voxel_tree(frame->size, f);
        const auto plain = build_voxel_tree(frame->size, {f.palette, {}});
        ASSERT_TRUE(pruned && plain);
        EXPECT_EQ((*pruned)->voxel_count(), (*plain)->voxel_count());
        std::uint64_t odd = 0;
        for (int z = 0; z < 70; ++z)
            for (int y = 0; y < 70; ++y)
                for (int x = 0; x < 70; ++x) {
                    ASSERT_EQ((*pruned)->at({x, y, z}), (*plain)->at({x, y, z}));
                    const vec3 p = to_object * vec4(vec3(frame->centre({x, y, z})), 1);
                    odd += (sdf_reference(*node, glm::dvec3(p)) < 0) != ((*plain)->at({x, y, z}) == 3);
                }
        EXPECT_LE(odd, 3u);  // centres on the surface, to the precision of floats
    }
}

TEST(FieldVoxels, a_volume_is_solid_where_it_is_dense_enough) {
    Grid grid;
    grid.samples = *build_grid({4, 1, 1}, std::vector<float>{0, 1, 0.6f, 0});
    const auto frame = fit_voxel_frame({0, 0, 0}, {4, 1, 1}, 8);
    const auto row = [&](Filter filter, float threshold) {
        grid.filter = filter;
        const VoxelFunction f = volume_voxels(grid, *frame, mat4x3(1), threshold, 1);
        std::string cells;
        for (int x = 0; x < 8; ++x) cells += f.palette({x, 0, 0}) ? '#' : '.';
        return cells;
    };
    EXPECT_EQ(row(Filter::nearest, 0.5f), "..####..");
    EXPECT_EQ(row(Filter::nearest, 0.7f), "..##....");
    EXPECT_EQ(row(Filter::linear, 0.5f), "..###...");  // 0, .25, .75, .9, .7, .45, .15, 0
    EXPECT_EQ(row(Filter::linear, 0.2f), ".#####..");
}

}  // namespace
}  // namespace spinel::field_voxels_test
