#include "render/film.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>

#include "kernels/constants.h"

namespace spinel {

bool FilmPixel::add(const kernels::PixelSample& sample) {
    vec3 radiance = sample.radiance;
    const bool finite = std::isfinite(radiance.x) && std::isfinite(radiance.y) && std::isfinite(radiance.z);
    if (!finite) radiance = vec3(0);
    if (sample.first.object != kernels::NONE) {
        if (object == 0) object = sample.first.object + 1;
        ++hits;
        normal += sample.first.normal;
        albedo += sample.first.albedo;
        depth += double(sample.first.depth);
    }
    sum += glm::dvec3(radiance);
    ++count;
    const double l = kernels::luminance(radiance), delta = l - mean;
    mean += delta / count;
    deviation += delta * (l - mean);
    return finite;
}

double FilmPixel::error_variance() const {
    return count < 2 ? mean * mean : deviation / (double(count - 1) * double(count));
}

FilmBuffer::FilmBuffer(ivec2 film_size, Crop film_crop) : size(film_size), crop(film_crop) {
    pixels.resize(std::size_t(crop.size().x) * std::size_t(crop.size().y));
}

FilmPixel& FilmBuffer::at(int x, int y) {
    return pixels[std::size_t(y - crop.lower.y) * std::size_t(crop.size().x) + std::size_t(x - crop.lower.x)];
}
const FilmPixel& FilmBuffer::at(int x, int y) const { return const_cast<FilmBuffer*>(this)->at(x, y); }

Image FilmBuffer::radiance() const {
    Image image{crop.size().x, crop.size().y, 3, {}};
    image.values.reserve(pixels.size() * 3);
    for (const FilmPixel& p : pixels)
        for (int k = 0; k < 3; ++k) image.values.push_back(p.count > 0 ? float(p.sum[k] / p.count) : 0.0f);
    return image;
}

double FilmBuffer::mean_luminance() const {
    double sum = 0;
    for (const FilmPixel& p : pixels) sum += p.mean;
    return sum / double(std::max<std::size_t>(pixels.size(), 1));
}

double FilmBuffer::relative_error() const {
    double variance = 0;
    for (const FilmPixel& p : pixels) variance += p.error_variance();
    const double mean = mean_luminance();
    return mean > 0 ? std::sqrt(variance / double(std::max<std::size_t>(pixels.size(), 1))) / mean : 0;
}

std::uint64_t FilmBuffer::sample_count() const {
    std::uint64_t n = 0;
    for (const FilmPixel& p : pixels) n += p.count;
    return n;
}

namespace {

struct AovRow {
    AovInfo info;
    std::vector<std::string> channels;
    std::function<void(const FilmPixel&, float*)> value;
};

void mean_of(vec3 sum, std::uint32_t n, float* to) {
    for (int k = 0; k < 3; ++k) to[k] = n > 0 ? sum[k] / float(n) : 0.0f;
}

const std::vector<AovRow>& aov_rows() {
    static const std::vector<AovRow> rows = {
        {{"depth", "distance from the camera to the first surface; 0 where there is none"},
         {"depth.Z"},
         [](const FilmPixel& p, float* to) { *to = p.hits > 0 ? float(p.depth / p.hits) : 0.0f; }},
        {{"normal", "shading normal of the first surface, world space, turned to the camera"},
         {"normal.X", "normal.Y", "normal.Z"},
         [](const FilmPixel& p, float* to) { mean_of(p.normal, p.hits, to); }},
        {{"albedo", "reflectance of the first surface"},
         {"albedo.R", "albedo.G", "albedo.B"},
         [](const FilmPixel& p, float* to) { mean_of(p.albedo, p.count, to); }},
        {{"object", "index of the first object that was seen, plus 1; 0 is the background"},
         {"object.id"},
         [](const FilmPixel& p, float* to) { *to = float(p.object); }},
        {{"samples", "samples of the pixel"},
         {"samples.count"},
         [](const FilmPixel& p, float* to) { *to = float(p.count); }},
        {{"variance", "variance of the pixel's mean luminance"},
         {"variance.Y"},
         [](const FilmPixel& p, float* to) { *to = float(p.error_variance()); }},
    };
    return rows;
}

}  // namespace

const std::vector<AovInfo>& aov_infos() {
    static const std::vector<AovInfo> infos = [] {
        std::vector<AovInfo> list;
        for (const AovRow& row : aov_rows()) list.push_back(row.info);
        return list;
    }();
    return infos;
}

Result<NamedPlane> aov_plane(const FilmBuffer& film, const std::string& name) {
    std::string available;
    for (const AovRow& row : aov_rows()) {
        if (name != row.info.name) {
            available += (available.empty() ? "" : ", ") + std::string(row.info.name);
            continue;
        }
        const int channels = int(row.channels.size());
        NamedPlane plane{row.channels, {film.crop.size().x, film.crop.size().y, channels, {}}};
        plane.image.values.resize(film.pixels.size() * row.channels.size());
        for (std::size_t i = 0; i < film.pixels.size(); ++i)
            row.value(film.pixels[i], plane.image.values.data() + i * std::size_t(channels));
        return plane;
    }
    return Error{fmt::format("unknown output '{}'; available: {}", name, available)};
}

}  // namespace spinel
