#pragma once
// LDR-FLIP, the difference that a person sees when alternating between two pictures on a display:
// Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for Alternating
// Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020.

#include "core/result.h"
#include "image/pixels.h"

namespace spinel {

// Pixels that a degree of the visual field covers. The paper's: 3840 pixels over 0.7 m, seen from 0.7 m.
inline constexpr double flip_pixels_per_degree = 67.0206432766;

// Difference of each pixel, 0 (none is seen) … 1. Both pictures hold display values, sRGB-encoded in [0, 1] (what lies
// outside is clamped), in one channel (grey) or three. Fails where shapes differ and where a value is NaN.
Result<Image> flip_map(const Image& image, const Image& reference, double pixels_per_degree = flip_pixels_per_degree);

// Mean of the map.
Result<double> flip(const Image& image, const Image& reference, double pixels_per_degree = flip_pixels_per_degree);

}  // namespace spinel
