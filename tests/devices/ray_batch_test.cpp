#include "render/ray_batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "geometry/test_scene.h"
#include "kernels/traverse.h"

namespace spinel::ray_batch_test {
namespace {

using namespace test;
using kernels::Hit;
using kernels::Ray;

VoxelGeometry speckled(Random& random, ivec3 size) {
    std::vector<std::uint16_t> cells(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
    for (std::uint16_t& cell : cells) cell = std::uint16_t(random.below(8) == 0 ? 1 + random.below(2) : 0);
    return {*build_voxel_tree(size, cells)};
}

// Two sets that overlap, one of them turned and one of them placed twice in the same place, so that hits are met at the
// same t; fog that lets light pass; a ball, and the ground.
TestScene overlapping_sets(Random& random) {
    TestScene parts;
    const auto set = parts.add(speckled(random, {24, 20, 28}));
    const auto fog = parts.add(speckled(random, {9, 9, 9}));
    const glm::mat3 turned(vec3(0.8f, 0.6f, 0), vec3(-0.6f, 0.8f, 0), vec3(0, 0, 1));
    parts.place(kernels::GEOMETRY_SPHERE, 0, affine(glm::mat3(3), vec3(10, 10, 10)), {{0, NO}});
    parts.place(kernels::GEOMETRY_VOXELS, set, mat4x3(1), {{1, NO}, {2, 0}});
    parts.place(kernels::GEOMETRY_VOXELS, set, mat4x3(1), {{3, NO}, {4, 0}});
    parts.place(kernels::GEOMETRY_VOXELS, set, affine(turned, vec3(12, -3, 2)), {{5, NO}, {6, NO}});
    parts.place(kernels::GEOMETRY_VOXELS, fog, affine(glm::mat3(2), vec3(3, 4, 5)), {{NO, 0}, {NO, 1}},
                kernels::INSTANCE_PASS_THROUGH);
    parts.place(kernels::GEOMETRY_PLANE, 0, affine(glm::mat3(1), vec3(0, -4, 0)), {{7, NO}});
    return parts;
}

// Beams of a camera's rays, and rays of no relation between them.
std::vector<Ray> mixed_rays(Random& random, std::size_t count) {
    std::vector<Ray> rays(count);
    for (std::size_t i = 0; i < count; ++i) {
        Ray& r = rays[i];
        if (i / 64 % 3 && i % 64) {
            r = rays[i / 64 * 64];
            r.direction += 0.02f * random.in_cube();
        } else {
            r.origin = vec3(12) + random.in_cube(30);
            r.direction = vec3(12) + random.in_cube(12) - r.origin;
        }
        r.t_min = i % 5 ? 0 : random.uniform(0, 0.5f);
        r.t_max = i % 7 ? kernels::INFINITE : random.uniform(0.5f, 1);
    }
    return rays;
}

TEST(RayBatch, every_ray_finds_what_it_finds_alone_bit_for_bit) {
    Random random(1);
    TestScene parts = overlapping_sets(random);
    const kernels::SceneView& scene = parts.view();
    for (const std::size_t count : {0, 1, 7, 100, 3000, 50000}) {
        const std::vector<Ray> rays = mixed_rays(random, count);
        std::vector<Hit> hits(count), any(count);
        for (const kernels::uint mask : {kernels::TRACE_ALL, kernels::TRACE_SOLID, kernels::TRACE_PASS_THROUGH}) {
            device_batch_closest(scene, rays, mask, hits.data());
            device_batch_any(scene, rays, mask, any.data());
            std::size_t found = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const Hit alone = kernels::trace_closest(scene, rays[i], mask);
                ASSERT_EQ(std::memcmp(&hits[i], &alone, sizeof(Hit)), 0) << describe(rays[i]) << " of " << count;
                ASSERT_EQ(kernels::is_hit(any[i]), kernels::trace_any(scene, rays[i], mask)) << describe(rays[i]);
                found += kernels::is_hit(alone);
            }
            EXPECT_GE(found, count / 4);
        }
    }
}

}  // namespace
}  // namespace spinel::ray_batch_test
