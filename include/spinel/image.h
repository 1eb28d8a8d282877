#pragma once
// Pictures as files: of light on the way out, of whatever they hold on the way in.

#include <filesystem>

#include "core/result.h"
#include "image/pixels.h"
#include "image/tone_map.h"

namespace spinel {

// Writes linear light by the extension: .exr as it is, .png exposed by 2^exposure_stops, tone mapped and sRGB-encoded.
Result<void> save_picture(const std::filesystem::path& path, const Image& radiance, ToneMap tone_map = ToneMap::agx,
                          float exposure_stops = 0);

// As floats, as stored: nothing is decoded from sRGB (srgb_decoded() does).
Result<Image> load_picture(const std::filesystem::path& path);

}  // namespace spinel
