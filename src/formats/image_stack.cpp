#include "formats/image_stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "formats/file_bytes.h"
#include "formats/samples.h"
#include "image/image_io.h"

namespace spinel {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t MAX_SLICES = 65536;
constexpr std::array<std::string_view, 4> EXTENSIONS = {".png", ".tif", ".tiff", ".exr"};

// "ct_%04d.png": what stands before and behind the number, and how many digits it has at least.
struct Pattern {
    std::string before, behind;
    int digits = 1;
};

std::optional<Pattern> pattern_of(const std::string& name) {
    const auto percent = name.find('%');
    if (percent == name.npos) return std::nullopt;
    std::size_t at = percent + 1;
    Pattern pattern{name.substr(0, percent), {}, 1};
    if (at < name.size() && name[at] == '0') ++at;
    if (at < name.size() && name[at] >= '1' && name[at] <= '9') pattern.digits = name[at++] - '0';
    if (at >= name.size() || name[at] != 'd') return std::nullopt;
    pattern.behind = name.substr(at + 1);
    return pattern;
}

std::string lower_extension(const fs::path& path) {
    std::string text = path.extension().string();
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

// a2 stands before a10: runs of digits compare as numbers.
bool in_order(const std::string& a, const std::string& b) {
    const auto digit = [](char c) { return c >= '0' && c <= '9'; };
    std::size_t i = 0, k = 0;
    while (i < a.size() && k < b.size()) {
        if (digit(a[i]) && digit(b[k])) {
            std::size_t ie = i, ke = k;
            while (ie < a.size() && digit(a[ie])) ++ie;
            while (ke < b.size() && digit(b[ke])) ++ke;
            while (i < ie && a[i] == '0') ++i;
            while (k < ke && b[k] == '0') ++k;
            if (ie - i != ke - k) return ie - i < ke - k;
            if (const int c = a.compare(i, ie - i, b, k, ke - k); c != 0) return c < 0;
            i = ie, k = ke;
        } else {
            if (a[i] != b[k]) return a[i] < b[k];
            ++i, ++k;
        }
    }
    return a.size() - i < b.size() - k;
}

Result<std::vector<fs::path>> slices_of(const fs::path& path) {
    std::vector<fs::path> slices;
    std::error_code error;
    if (const auto pattern = pattern_of(path.filename().string())) {
        const auto name = [&](std::size_t number) {
            return path.parent_path() /
                   fmt::format("{}{:0{}}{}", pattern->before, number, pattern->digits, pattern->behind);
        };
        std::size_t number = 0;
        while (number < 1000 && !fs::is_regular_file(name(number), error)) ++number;
        for (; slices.size() < MAX_SLICES && fs::is_regular_file(name(number), error); ++number)
            slices.push_back(name(number));
        if (slices.empty()) return Error{"there is no picture of that name and a number below 1000"};
        return slices;
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(path, error))
        if (entry.is_regular_file(error) &&
            std::find(EXTENSIONS.begin(), EXTENSIONS.end(), lower_extension(entry.path())) != EXTENSIONS.end())
            slices.push_back(entry.path());
    if (slices.empty()) return Error{"it is a folder without pictures (.png, .tif, .tiff, .exr)"};
    if (slices.size() > MAX_SLICES) return Error{fmt::format("it holds more than the {} pictures allowed", MAX_SLICES)};
    std::sort(slices.begin(), slices.end(), [](const fs::path& a, const fs::path& b) {
        return in_order(a.filename().string(), b.filename().string());
    });
    std::erase_if(slices, [extension = lower_extension(slices.front())](const fs::path& slice) {
        return lower_extension(slice) != extension;
    });
    return slices;
}

}  // namespace

bool is_image_stack(const fs::path& path) {
    std::error_code error;
    return fs::is_directory(path, error) ||
           (pattern_of(path.filename().string()) && !fs::exists(path, error) &&
            std::find(EXTENSIONS.begin(), EXTENSIONS.end(), lower_extension(path)) != EXTENSIONS.end());
}

Result<Scene> load_image_stack(const fs::path& path) {
    const Result<std::vector<fs::path>> slices = slices_of(path);
    if (!slices) return cannot_read(path, slices.error().message);
    DecodedSamples samples;
    ivec3 size(0);
    for (const fs::path& slice : *slices) {
        const Result<Image> image = read_image(slice);
        if (!image) return image.error();
        if (size.z == 0) {
            size = {image->width, image->height, int(slices->size())};
            if (!bytes_of_samples(size, SampleType::f32))
                return cannot_read(path, fmt::format("its {}×{}×{} samples are more than the {} allowed", size.x,
                                                     size.y, size.z, MAX_VOLUME_SAMPLES));
            samples.values.reserve(std::size_t(size.x) * std::size_t(size.y));
            size.z = 0;
        }
        if (image->width != size.x || image->height != size.y)
            return cannot_read(slice, fmt::format("it has {}×{} pixels, the slices before it {}×{}", image->width,
                                                  image->height, size.x, size.y));
        const int colors = image->channels < 3 ? 1 : 3;  // without alpha
        for (int y = size.y - 1; y >= 0; --y)
            for (int x = 0; x < size.x; ++x) {
                const float* pixel = image->at(x, y);
                float value = pixel[0];
                if (colors == 3) value = (pixel[0] + pixel[1] + pixel[2]) / 3;
                const bool finite = std::isfinite(value);
                samples.replaced += !finite;
                samples.values.push_back(finite ? value : 0);
            }
        ++size.z;
    }
    const std::string name = path.has_filename() ? path.stem().string() : path.parent_path().stem().string();
    Result<Scene> scene = scan_scene(name, size, std::move(samples), mat4x3(1), "");
    return scene ? std::move(scene) : Result<Scene>(cannot_read(path, scene.error().message));
}

}  // namespace spinel
