#include "scene/host_texture.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "image/palette.h"
#include "image/pixels.h"
#include "kernels/texture.h"
#include "scene/texture_place.h"

namespace spinel {
namespace {

vec4 source_texel(const ImageTexture& image, int x, int y) {
    const PixelBuffer& pixels = *image.pixels;
    const std::size_t first =
        (std::size_t(y) * std::size_t(pixels.width) + std::size_t(x)) * std::size_t(pixels.channels);
    vec4 c(0, 0, 0, 1);
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&pixels.data)) {
        std::uint8_t v[4] = {0, 0, 0, 255};
        std::copy_n(bytes->begin() + std::ptrdiff_t(first), pixels.channels, v);
        if (pixels.channels <= 2) {
            v[3] = pixels.channels == 2 ? v[1] : 255;
            v[1] = v[2] = v[0];
        }
        const std::uint32_t packed = v[0] | std::uint32_t(v[1]) << 8 | std::uint32_t(v[2]) << 16;
        c = vec4(image.srgb ? linear_of_srgb8(packed) : vec3(v[0], v[1], v[2]) / 255.0f, float(v[3]) / 255);
    } else {
        const auto& values = std::get<std::vector<float>>(pixels.data);
        for (int i = 0; i < pixels.channels; ++i) c[i] = values[first + std::size_t(i)];
        if (pixels.channels <= 2) c = vec4(c.x, c.x, c.x, pixels.channels == 2 ? c.y : 1);
    }
    return c;
}

}  // namespace

HostTexture::HostTexture(const Texture& texture) : texture_(texture) {
    const auto* image = std::get_if<ImageTexture>(&texture.data);
    if (!image) return;
    ivec2 size(image->pixels->width, image->pixels->height);
    while (size.x > 1 || size.y > 1) {
        const ivec2 above = size;
        size = glm::max(size / 2, ivec2(1));
        Level level{size.x, size.y, std::vector<vec4>(std::size_t(size.x) * std::size_t(size.y))};
        const int from = int(levels_.size());
        parallel_for(std::size_t(size.y), 16, [&](std::size_t begin, std::size_t end) {
            for (int y = int(begin); y < int(end); ++y)
                for (int x = 0; x < size.x; ++x) {
                    const int x1 = std::min(2 * x + 1, above.x - 1), y1 = std::min(2 * y + 1, above.y - 1);
                    level.texels[std::size_t(x) + std::size_t(size.x) * std::size_t(y)] =
                        0.25f * (texel(from, 2 * x, 2 * y) + texel(from, x1, 2 * y) + texel(from, 2 * x, y1) +
                                 texel(from, x1, y1));
                }
        });
        levels_.push_back(std::move(level));
    }
}

vec4 HostTexture::texel(int level, int x, int y) const {
    const auto& image = std::get<ImageTexture>(texture_.data);
    if (level == 0)
        return source_texel(image, std::min(x, image.pixels->width - 1), std::min(y, image.pixels->height - 1));
    const Level& l = levels_[std::size_t(level - 1)];
    return l
        .texels[std::size_t(std::min(x, l.width - 1)) + std::size_t(l.width) * std::size_t(std::min(y, l.height - 1))];
}

vec4 HostTexture::at(vec2 uv, float footprint) const {
    if (const auto* checker = std::get_if<CheckerTexture>(&texture_.data)) {
        const vec2 st = uv * checker->scale + checker->offset;
        if (!(std::abs(st.x) < 1e6f && std::abs(st.y) < 1e6f))
            return vec4(0.5f * (checker->color_a + checker->color_b), 1);
        const bool even = ((int(std::floor(st.x)) + int(std::floor(st.y))) & 1) == 0;
        return vec4(even ? checker->color_a : checker->color_b, 1);
    }
    const auto& image = std::get<ImageTexture>(texture_.data);
    const TexturePlace place = texture_place(image);
    const vec2 st = vec2(glm::dot(place.row_u, uv), glm::dot(place.row_v, uv)) + image.offset;
    const float texels = footprint * std::max(std::abs(image.scale.x) * float(image.pixels->width),
                                              std::abs(image.scale.y) * float(image.pixels->height));
    const int level = texels > 1 ? std::clamp(int(std::lround(std::log2(texels))), 0, int(levels_.size())) : 0;
    const int width = level == 0 ? image.pixels->width : levels_[std::size_t(level - 1)].width;
    const int height = level == 0 ? image.pixels->height : levels_[std::size_t(level - 1)].height;
    const float x = st.x * float(width), y = (1 - st.y) * float(height);
    if (!(std::abs(x) < 1e9f && std::abs(y) < 1e9f)) return vec4(0, 0, 0, 1);
    return texel(level, kernels::wrap_coordinate(int(std::floor(x)), width, place.wrap_u),
                 kernels::wrap_coordinate(int(std::floor(y)), height, place.wrap_v));
}

int HostTexture::uv_set() const {
    const auto* image = std::get_if<ImageTexture>(&texture_.data);
    return image ? image->uv_set : 0;
}

}  // namespace spinel
