#pragma once
// How far two pictures are apart, value by value. All fail when the pictures differ in size or channels. What a person
// sees of a difference is in flip.h.

#include <vector>

#include "core/result.h"
#include "image/pixels.h"

namespace spinel {

// Fails unless both have the same size and channels, and pixels at all.
Result<void> check_comparable(const Image& image, const Image& reference);

// Mean of each channel.
std::vector<double> channel_means(const Image& image);

// Root of the mean squared difference, over pixels and channels.
Result<double> rmse(const Image& image, const Image& reference);

// Mean of (a − b)² / (b² + 0.01): squared error relative to the reference, so that a dim corner counts as
// much as a lamp.
Result<double> relative_mse(const Image& image, const Image& reference);

// The largest |a − b| / |b| of the channels' means a and b: energy lost or won, however noisy the pictures are.
Result<double> relative_mean_difference(const Image& image, const Image& reference);

}  // namespace spinel
