#pragma once
// Pictures in and out, through OpenImageIO.

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/result.h"
#include "image/pixels.h"

namespace spinel {

// Reads any picture that OpenImageIO knows. Values are as stored: an 8-bit file gives bytes, everything else
// floats (16-bit integers as 0 … 1); alpha is not multiplied in; nothing is decoded from sRGB. The picture is
// the display window, zero where an EXR holds no data. Of more than four channels R, G, B and A are taken.
Result<PixelBuffer> read_pixels(const std::filesystem::path& path);

// The same from an encoded picture in memory; `name` stands for it in messages, and its extension (".png")
// helps to tell the format.
Result<PixelBuffer> read_pixels_from_memory(const void* bytes, std::size_t size, const std::string& name);

// As floats; 8-bit values as 0 … 1, still not decoded.
Result<Image> read_image(const std::filesystem::path& path);

// Some channels of a picture that is written; all planes of a file have the same size.
struct NamedPlane {
    std::vector<std::string> channels;  // one a channel of `image`: {"R", "G", "B"}, {"depth.Z"}, {"normal.X", …}
    Image image;
    bool half = false;  // 16-bit floats: for colour; not for distances, indices and counts
};

using ImageMetadata = std::map<std::string, std::string>;

// By the extension:
//   .png  8 bits; exactly one plane with 1, 3 or 4 channels of display-ready values 0 … 1 (tone_mapped()
//   gives such) .exr  all planes, lossless (ZIP); linear values
// Written atomically: whoever looks at `path` sees the old file or the whole new one.
Result<void> write_image(const std::filesystem::path& path, const std::vector<NamedPlane>& planes,
                         const ImageMetadata& metadata = {});

}  // namespace spinel
