#pragma once
// How far two pictures are apart. All fail when the pictures differ in size or channels.

#include <vector>

#include "core/result.h"
#include "image/pixels.h"

namespace spinel {

// Mean of each channel.
std::vector<double> channel_means(const Image& image);

// Root of the mean squared difference, over pixels and channels.
Result<double> rmse(const Image& image, const Image& reference);

// Mean of (a − b)² / (b² + 0.01): squared error relative to the reference, so that a dim corner counts as
// much as a lamp.
Result<double> relative_mse(const Image& image, const Image& reference);

}  // namespace spinel
