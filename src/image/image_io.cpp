#include "image/image_io.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/atomic_file.h"

namespace spinel {
namespace {

constexpr std::int64_t MAX_EDGE = 65536;
constexpr std::int64_t MAX_VALUES = std::int64_t(1) << 30;  // 4 GiB as floats

// First line of the library's complaint, without a final stop, so that ours stays one sentence.
std::string first_line(std::string text) {
    text = text.substr(0, text.find('\n'));
    while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
    return text.empty() ? "it is damaged or of an unknown format" : text;
}

Error cannot_read(const std::string& name, const std::string& why) {
    return {"cannot read image '" + name + "': " + why};
}
Error cannot_write(const std::filesystem::path& path, const std::string& why) {
    return {"cannot write image '" + path.string() + "': " + why};
}

// Which of the file's channels are read, in order. Empty: none can be chosen.
std::vector<int> chosen_channels(const OIIO::ImageSpec& spec) {
    std::vector<int> chosen;
    if (spec.nchannels <= 4) {
        for (int c = 0; c < spec.nchannels; ++c) chosen.push_back(c);
        return chosen;
    }
    for (const char* name : {"R", "G", "B", "A"}) {
        const int c = spec.channelindex(name);
        if (c >= 0) chosen.push_back(c);
        else if (name[0] != 'A') return {};
    }
    return chosen;
}

// Reads the file's data window into the display window.
template <class T>
bool read_values(OIIO::ImageInput& input, const OIIO::ImageSpec& spec, const std::vector<int>& chosen,
                 OIIO::TypeDesc type, std::vector<T>& result) {
    const auto [first, last] = std::minmax_element(chosen.begin(), chosen.end());
    const int stored_begin = *first, stored_count = *last - *first + 1;
    std::vector<T> stored(std::size_t(spec.width) * std::size_t(spec.height) * std::size_t(stored_count));
    if (!input.read_image(0, 0, stored_begin, stored_begin + stored_count, type, stored.data())) return false;

    const std::size_t channels = chosen.size();
    const bool whole = spec.full_x == spec.x && spec.full_y == spec.y && spec.full_width == spec.width &&
                       spec.full_height == spec.height;
    if (whole && std::size_t(stored_count) == channels && std::is_sorted(chosen.begin(), chosen.end())) {
        result = std::move(stored);
        return true;
    }
    result.assign(std::size_t(spec.full_width) * std::size_t(spec.full_height) * channels, T(0));
    const int x_begin = std::max(spec.x, spec.full_x);
    const int x_end = std::min(spec.x + spec.width, spec.full_x + spec.full_width);
    const int y_begin = std::max(spec.y, spec.full_y);
    const int y_end = std::min(spec.y + spec.height, spec.full_y + spec.full_height);
    for (int y = y_begin; y < y_end; ++y) {
        for (int x = x_begin; x < x_end; ++x) {
            const T* from =
                stored.data() + (std::size_t(y - spec.y) * std::size_t(spec.width) + std::size_t(x - spec.x)) *
                                    std::size_t(stored_count);
            T* to =
                result.data() +
                (std::size_t(y - spec.full_y) * std::size_t(spec.full_width) + std::size_t(x - spec.full_x)) * channels;
            for (std::size_t c = 0; c < channels; ++c) to[c] = from[chosen[c] - stored_begin];
        }
    }
    return true;
}

Result<PixelBuffer> read(const std::string& name, OIIO::Filesystem::IOProxy* proxy) {
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    // Said twice: 2.4 hands the proxy to the plugin by the argument when it probes, by the attribute when it
    // opens.
    if (proxy) config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    const auto input = OIIO::ImageInput::open(name, &config, proxy);
    if (!input) return cannot_read(name, first_line(OIIO::geterror()));
    const OIIO::ImageSpec spec = input->spec();

    if (spec.deep) return cannot_read(name, "deep pictures are not supported");
    if (spec.depth > 1 || spec.full_depth > 1) return cannot_read(name, "volumes in picture formats are not supported");
    for (const std::int64_t edge : {spec.width, spec.height, spec.full_width, spec.full_height}) {
        if (edge < 1 || edge > MAX_EDGE)
            return cannot_read(
                name, "an edge of " + std::to_string(edge) + " pixels is outside 1 … " + std::to_string(MAX_EDGE));
    }
    // A window far from the origin would overflow the sums below.
    for (const std::int64_t corner : {spec.x, spec.y, spec.full_x, spec.full_y}) {
        if (std::abs(corner) > (std::int64_t(1) << 30))
            return cannot_read(name, "its window lies " + std::to_string(corner) + " pixels away from the origin");
    }
    const std::vector<int> chosen = chosen_channels(spec);
    if (chosen.empty())
        return cannot_read(name, "R, G and B are not among its " + std::to_string(spec.nchannels) + " channels");
    const auto [first, last] = std::minmax_element(chosen.begin(), chosen.end());
    const std::int64_t values =
        std::max(std::int64_t(spec.width) * spec.height * (*last - *first + 1),
                 std::int64_t(spec.full_width) * spec.full_height * std::int64_t(chosen.size()));
    if (values > MAX_VALUES)
        return cannot_read(name, "its " + std::to_string(values) + " values are more than the " +
                                     std::to_string(MAX_VALUES) + " allowed");

    PixelBuffer result{spec.full_width, spec.full_height, int(chosen.size()), {}, !spec.format.is_floating_point()};
    bool done = false;
    if (spec.format == OIIO::TypeDesc::UINT8 && spec.channelformats.empty()) {
        done =
            read_values(*input, spec, chosen, OIIO::TypeDesc::UINT8, result.data.emplace<std::vector<std::uint8_t>>());
    } else {
        done = read_values(*input, spec, chosen, OIIO::TypeDesc::FLOAT, result.data.emplace<std::vector<float>>());
    }
    if (!done) return cannot_read(name, first_line(input->geterror()));
    return result;
}

std::uint8_t to_byte(float value) {
    if (!(value > 0.0f)) return 0;  // also NaN
    return static_cast<std::uint8_t>(std::lround(std::min(value, 1.0f) * 255.0f));
}

// Writes values of any channel layout that `spec` describes to a file beside `path`, then moves it there.
Result<void> write(const std::filesystem::path& path, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
                   const void* values) {
    return write_file_atomically(path, [&](const std::filesystem::path& aside) -> Result<void> {
        const auto output = OIIO::ImageOutput::create(aside.string());
        if (!output) return cannot_write(path, first_line(OIIO::geterror()));
        if (!output->open(aside.string(), spec) || !output->write_image(type, values) || !output->close())
            return cannot_write(path, first_line(output->geterror()));
        return {};
    });
}

Result<void> write_png(const std::filesystem::path& path, const NamedPlane& plane, OIIO::ImageSpec spec) {
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.set_format(OIIO::TypeDesc::UINT8);
    std::vector<std::uint8_t> bytes(plane.image.values.size());
    std::transform(plane.image.values.begin(), plane.image.values.end(), bytes.begin(), to_byte);
    return write(path, spec, OIIO::TypeDesc::UINT8, bytes.data());
}

Result<void> write_exr(const std::filesystem::path& path, const std::vector<NamedPlane>& planes, OIIO::ImageSpec spec) {
    spec.set_format(OIIO::TypeDesc::FLOAT);
    spec.channelformats.clear();
    for (const NamedPlane& plane : planes)
        spec.channelformats.insert(spec.channelformats.end(), plane.channels.size(),
                                   plane.half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
    spec.attribute("compression", "zip");
    spec.attribute("oiio:ColorSpace", "Linear");
    const std::size_t pixels = std::size_t(spec.width) * std::size_t(spec.height);
    const std::size_t stride = std::size_t(spec.nchannels);
    std::vector<float> interleaved(pixels * stride);
    std::size_t first = 0;
    for (const NamedPlane& plane : planes) {
        const std::size_t count = plane.channels.size();
        for (std::size_t i = 0; i < pixels; ++i)
            std::copy_n(plane.image.values.data() + i * count, count, interleaved.data() + i * stride + first);
        first += count;
    }
    return write(path, spec, OIIO::TypeDesc::FLOAT, interleaved.data());
}

}  // namespace

Result<PixelBuffer> read_pixels(const std::filesystem::path& path) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) return cannot_read(path.string(), "there is no such file");
    if (std::filesystem::is_directory(path, error)) return cannot_read(path.string(), "that is a folder");
    return read(path.string(), nullptr);
}

Result<PixelBuffer> read_pixels_from_memory(const void* bytes, std::size_t size, const std::string& name) {
    OIIO::Filesystem::IOMemReader reader(const_cast<void*>(bytes), size);
    return read(name, &reader);
}

Result<Image> read_image(const std::filesystem::path& path) {
    Result<PixelBuffer> pixels = read_pixels(path);
    if (!pixels) return pixels.error();
    Image image{pixels->width, pixels->height, pixels->channels, {}};
    if (auto* floats = std::get_if<std::vector<float>>(&pixels->data)) {
        image.values = std::move(*floats);
    } else {
        const auto& bytes = std::get<std::vector<std::uint8_t>>(pixels->data);
        image.values.resize(bytes.size());
        std::transform(bytes.begin(), bytes.end(), image.values.begin(),
                       [](std::uint8_t byte) { return float(byte) / 255.0f; });
    }
    return image;
}

Result<void> write_image(const std::filesystem::path& path, const std::vector<NamedPlane>& planes,
                         const ImageMetadata& metadata) {
    if (planes.empty()) return cannot_write(path, "there is nothing to write");
    const int width = planes[0].image.width, height = planes[0].image.height;
    OIIO::ImageSpec spec(width, height, 0, OIIO::TypeDesc::FLOAT);
    spec.channelnames.clear();
    for (const NamedPlane& plane : planes) {
        const Image& image = plane.image;
        if (image.width < 1 || image.height < 1 || image.width != width || image.height != height)
            return cannot_write(path, "a plane of " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                                          " pixels does not fit a picture of " + std::to_string(width) + "x" +
                                          std::to_string(height));
        if (image.channels < 1 || plane.channels.size() != std::size_t(image.channels) ||
            image.values.size() != std::size_t(width) * std::size_t(height) * std::size_t(image.channels))
            return cannot_write(path, "a plane's channels do not match its values");
        for (const std::string& name : plane.channels) {
            if (std::count(spec.channelnames.begin(), spec.channelnames.end(), name))
                return cannot_write(path, "there are two channels '" + name + "'");
            spec.channelnames.push_back(name);
        }
    }
    spec.nchannels = int(spec.channelnames.size());
    for (const auto& [key, value] : metadata) spec.attribute(key, value);

    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (extension == ".exr") return write_exr(path, planes, std::move(spec));
    if (extension == ".png") {
        if (planes.size() != 1 || spec.nchannels == 2 || spec.nchannels > 4)
            return cannot_write(path, "a PNG holds one plane of 1, 3 or 4 channels; .exr holds any");
        return write_png(path, planes[0], std::move(spec));
    }
    return cannot_write(path, "unknown extension '" + extension + "'; writable: .png, .exr");
}

}  // namespace spinel
