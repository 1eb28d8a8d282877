#pragma once
// Grids that are mostly background, read from a file, against the library that wrote them.

#include <gtest/gtest.h>

#include <random>

#include "spinel/scene.h"

namespace spinel::test {

// Looks at 200 000 places of index space from (−77, −77, −77) on, half of them within 320 voxels of the origin, where
// the grid should hold `expected(place)`; returns at how many that is not the background. World is index space.
template <class Expected>
int expect_sparse_samples(const Grid& grid, float background, const Expected& expected) {
    const glm::dmat4 to_index = glm::inverse(glm::dmat4(glm::mat4(grid.index_to_local)));
    const ivec3 origin(glm::floor(glm::dvec3(to_index * glm::dvec4(0, 0, 0, 1))));
    std::mt19937 random(1);
    int different = 0;
    for (int i = 0; i < 200000; ++i) {
        const int reach = i % 2 == 0 ? 2000 : 320;
        ivec3 place;
        for (int axis = 0; axis < 3; ++axis) place[axis] = int(random() % std::uint32_t(reach + 77)) - 77;
        if (glm::any(glm::greaterThanEqual(origin + place, grid.samples->size()))) continue;
        const float value = expected(place);
        EXPECT_EQ(grid.samples->at(origin + place), value) << place.x << ' ' << place.y << ' ' << place.z;
        if (testing::Test::HasFailure()) break;
        different += value != background;
    }
    return different;
}

}  // namespace spinel::test
