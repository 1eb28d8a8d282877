#pragma once
// The film: for every pixel running sums of its own samples. Pixels own their samples, so that a part of a picture is
// the same as that part of the whole, bit by bit.

#include <cstdint>
#include <string>
#include <vector>

#include "core/result.h"
#include "image/image_io.h"
#include "kernels/pixel_sample.h"
#include "spinel/render.h"
#include "spinel/scene.h"

namespace spinel {

struct FilmPixel {
    glm::dvec3 sum = {0, 0, 0};  // of radiance
    double mean = 0;             // of luminance, and …
    double deviation = 0;        // … its sum of squared deviations (Welford 1962)
    vec3 normal = {0, 0, 0};     // sums over the samples that hit something
    vec3 albedo = {0, 0, 0};
    double depth = 0;
    std::uint32_t hits = 0;
    std::uint32_t count = 0;   // samples
    std::uint32_t object = 0;  // of the first sample that hit something, plus 1; 0: background

    // A sample that is not finite counts as black; gives false.
    bool add(const kernels::PixelSample& sample);
    // Variance of the mean luminance.
    double error_variance() const;
};

struct FilmBuffer {
    ivec2 size = {0, 0};  // of the whole picture
    Crop crop;
    std::vector<FilmPixel> pixels;    // of the crop, row by row
    std::uint64_t bound_reached = 0;  // samples cut by a safety bound
    std::uint64_t not_finite = 0;     // samples that were thrown away

    FilmBuffer() = default;
    FilmBuffer(ivec2 size, Crop crop);
    FilmPixel& at(int x, int y);  // coordinates of the whole picture
    const FilmPixel& at(int x, int y) const;

    Image radiance() const;  // mean, linear
    double mean_luminance() const;
    // Root mean square over the pixels of the standard error of luminance, over the picture's mean luminance.
    double relative_error() const;
    std::uint64_t sample_count() const;
};

// Auxiliary outputs by name: depth, normal, albedo, object, samples, variance.
struct AovInfo {
    const char* name;
    const char* doc;
};
const std::vector<AovInfo>& aov_infos();
Result<NamedPlane> aov_plane(const FilmBuffer& film, const std::string& name);

}  // namespace spinel
