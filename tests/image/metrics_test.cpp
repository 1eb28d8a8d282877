#include "image/metrics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace spinel::metrics_test {
namespace {

const Image a{2, 1, 3, {1, 2, 3, 4, 5, 6}};
const Image b{2, 1, 3, {1, 2, 3, 4, 5, 9}};

TEST(Metrics, means_are_taken_a_channel_at_a_time) {
    EXPECT_EQ(channel_means(a), (std::vector<double>{2.5, 3.5, 4.5}));
}

TEST(Metrics, rmse_and_relative_mse_follow_their_definitions) {
    EXPECT_NEAR(*rmse(a, b), std::sqrt(9.0 / 6.0), 1e-12);
    EXPECT_NEAR(*relative_mse(a, b), 9.0 / 81.01 / 6.0, 1e-12);
    EXPECT_NEAR(*relative_mse(b, a), 9.0 / 36.01 / 6.0, 1e-12);
    EXPECT_EQ(*rmse(a, a), 0.0);
}

TEST(Metrics, means_are_compared_relative_to_the_reference) {
    EXPECT_NEAR(*relative_mean_difference(a, b), 1.5 / 6.0, 1e-12);
    EXPECT_NEAR(*relative_mean_difference(b, a), 1.5 / 4.5, 1e-12);
    EXPECT_EQ(*relative_mean_difference(a, a), 0.0);
    const Image black{1, 1, 1, {0}}, grey{1, 1, 1, {1}}, nothing{1, 1, 1, {NAN}};
    EXPECT_EQ(*relative_mean_difference(black, black), 0.0);
    EXPECT_EQ(*relative_mean_difference(grey, black), INFINITY);
    EXPECT_TRUE(std::isnan(*relative_mean_difference(nothing, grey)));
}

TEST(Metrics, pictures_of_different_shape_are_refused) {
    const Image c{1, 2, 3, {1, 2, 3, 4, 5, 6}};
    EXPECT_FALSE(rmse(a, c));
    EXPECT_FALSE(relative_mse(a, c));
    EXPECT_FALSE(relative_mean_difference(a, c));
    EXPECT_FALSE(rmse(Image{}, Image{}));
}

}  // namespace
}  // namespace spinel::metrics_test
