#include <cmath>
#include <glm/gtc/packing.hpp>

#include "image/pixels.h"
#include "image/tone_map.h"
#include "kernels/texture.h"
#include "scene/compilation.h"

namespace spinel {
namespace {

using kernels::uint;

uint kernel_wrap(Wrap wrap) {
    switch (wrap) {
        case Wrap::clamp: return kernels::WRAP_CLAMP;
        case Wrap::mirror: return kernels::WRAP_MIRROR;
        case Wrap::repeat: break;
    }
    return kernels::WRAP_REPEAT;
}

// One- and two-channel images are grey and grey with alpha.
template <class T>
glm::tvec4<T> rgba_of(const T* pixel, int channels, T opaque) {
    switch (channels) {
        case 1: return {pixel[0], pixel[0], pixel[0], opaque};
        case 2: return {pixel[0], pixel[0], pixel[0], pixel[1]};
        case 3: return {pixel[0], pixel[1], pixel[2], opaque};
        default: return {pixel[0], pixel[1], pixel[2], pixel[3]};
    }
}

Result<kernels::Texture> image_record(const ImageTexture& image, std::vector<uint>& words) {
    const PixelBuffer& pixels = *image.pixels;
    const std::size_t count = std::size_t(pixels.width) * std::size_t(pixels.height);
    const std::size_t words_a_texel = std::holds_alternative<std::vector<float>>(pixels.data) ? 2 : 1;
    const Result<uint> first = pool_place(words.size(), words_a_texel * count, WORDS);
    if (!first) return first.error();
    kernels::Texture t = {};
    t.width = uint(pixels.width);
    t.height = uint(pixels.height);
    t.word_first = *first;
    t.filter_kind = image.filter == Filter::nearest ? kernels::FILTER_NEAREST : kernels::FILTER_TRILINEAR;
    t.wrap = kernel_wrap(image.wrap);
    t.scale = image.scale;
    t.offset = image.offset;
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&pixels.data)) {
        t.kind = kernels::TEXTURE_RGBA8;
        t.srgb = image.srgb ? 1 : 0;
        words.reserve(words.size() + count);
        for (std::size_t i = 0; i < count; ++i) {
            const auto p =
                rgba_of<std::uint8_t>(bytes->data() + i * std::size_t(pixels.channels), pixels.channels, 255);
            words.push_back(uint(p.x) | uint(p.y) << 8 | uint(p.z) << 16 | uint(p.w) << 24);
        }
    } else {
        const auto& floats = std::get<std::vector<float>>(pixels.data);
        t.kind = kernels::TEXTURE_RGBA16F;
        words.reserve(words.size() + 2 * count);
        for (std::size_t i = 0; i < count; ++i) {
            auto p = rgba_of<float>(floats.data() + i * std::size_t(pixels.channels), pixels.channels, 1.0f);
            if (image.srgb && pixels.encoded)
                for (int k = 0; k < 3; ++k) p[k] = srgb_decoded(p[k]);
            for (int k = 0; k < 4; ++k) p[k] = std::isfinite(p[k]) ? glm::clamp(p[k], -65504.0f, 65504.0f) : 0.0f;
            words.push_back(glm::packHalf2x16({p.x, p.y}));
            words.push_back(glm::packHalf2x16({p.z, p.w}));
        }
    }
    return t;
}

kernels::Texture checker_record(const CheckerTexture& checker) {
    kernels::Texture t = {};
    t.kind = kernels::TEXTURE_CHECKER;
    t.scale = checker.scale;
    t.offset = checker.offset;
    t.color_a = checker.color_a;
    t.color_b = checker.color_b;
    return t;
}

}  // namespace

Result<void> add_textures(Compilation& c) {
    for (const Texture& texture : c.scene.textures) {
        if (const auto* image = std::get_if<ImageTexture>(&texture.data)) {
            const Result<kernels::Texture> record = image_record(*image, c.out.words);
            if (!record) return record.error();
            c.out.textures.push_back(*record);
        } else {
            c.out.textures.push_back(checker_record(std::get<CheckerTexture>(texture.data)));
        }
    }
    return {};
}

vec3 mean_color(const CompiledScene& out, kernels::uint texture) {
    if (texture == kernels::NONE) return vec3(1);
    const kernels::Texture& t = out.textures[texture];
    if (t.kind == kernels::TEXTURE_CHECKER) return 0.5f * (t.color_a + t.color_b);
    const kernels::SceneView view = out.view();
    // A grid of texels is enough for a light's power, which only steers sampling.
    const int step_x = std::max(1, int(t.width) / 256), step_y = std::max(1, int(t.height) / 256);
    glm::dvec3 sum(0);
    double count = 0;
    for (int y = 0; y < int(t.height); y += step_y)
        for (int x = 0; x < int(t.width); x += step_x, ++count)
            sum += glm::dvec3(vec3(kernels::texel_at(view, t, x, y)));
    return vec3(sum / count);
}

}  // namespace spinel
