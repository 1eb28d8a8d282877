#pragma once
// From scene-referred light to what a display shows.

#include "image/pixels.h"

namespace spinel {

// linear  clips at 1.
// aces    Stephen Hill's fit of the ACES reference rendering and output transforms for an sRGB display
//         (the curve of "Baking Lab", 2016): filmic contrast, bright colours turn pale.
// agx     Troy Sobotka's AgX (2022) with the polynomial of Benjamin Wrensch's minimal implementation for its
// sigmoid:
//         16.5 stops, hues keep their place as they brighten.
enum class ToneMap { linear, aces, agx };

// Transfer function of IEC 61966-2-1, the exact piecewise form. Defined for all x ≥ 0; negatives and NaN give
// 0.
float srgb_encoded(float linear);
float srgb_decoded(float encoded);

// Ready for a display: exposed by 2^exposure_stops, tone mapped, sRGB-encoded, every value in [0, 1] whatever
// came in (NaN and negatives are black, infinity is white). One channel is taken as grey; a fourth is alpha
// and only clamped.
Image tone_mapped(const Image& linear, ToneMap tone_map, float exposure_stops = 0);

}  // namespace spinel
