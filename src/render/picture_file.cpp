#include <algorithm>
#include <cctype>

#include "image/image_io.h"
#include "spinel/image.h"

namespace spinel {

Result<void> save_picture(const std::filesystem::path& path, const Image& radiance, ToneMap tone_map,
                          float exposure_stops) {
    const std::vector<std::string> names =
        radiance.channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B", "A"};
    if (radiance.channels < 1 || radiance.channels == 2 || radiance.channels > 4)
        return Error{"a picture of " + std::to_string(radiance.channels) + " channels has no colours; 1, 3 and 4 have"};
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    const bool encoded = extension != ".exr";
    return write_image(path, {{{names.begin(), names.begin() + radiance.channels},
                               encoded ? tone_mapped(radiance, tone_map, exposure_stops) : radiance}});
}

Result<Image> load_picture(const std::filesystem::path& path) { return read_image(path); }

}  // namespace spinel
