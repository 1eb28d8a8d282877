#include <cmath>
#include <glm/gtc/packing.hpp>
#include <map>
#include <utility>

#include "image/pixels.h"
#include "image/tone_map.h"
#include "kernels/texture.h"
#include "scene/compilation.h"
#include "scene/texture_place.h"

namespace spinel {
namespace {

using kernels::uint;

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

// Texels of a picture; textures that show the same one share them.
struct Texels {
    uint kind;
    uint word_first;
};
using TexelsOf = std::map<std::pair<const PixelBuffer*, bool>, Texels>;

Result<Texels> append_texels(const PixelBuffer& pixels, bool srgb, std::vector<uint>& words, TexelsOf& known) {
    const auto [entry, fresh] = known.try_emplace({&pixels, srgb}, Texels{kernels::TEXTURE_RGBA8, 0});
    if (!fresh) return entry->second;
    const std::size_t count = std::size_t(pixels.width) * std::size_t(pixels.height);
    const std::size_t words_a_texel = std::holds_alternative<std::vector<float>>(pixels.data) ? 2 : 1;
    const Result<uint> first = pool_place(words.size(), words_a_texel * count, WORDS);
    if (!first) return first.error();
    entry->second.word_first = *first;
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&pixels.data)) {
        words.reserve(words.size() + count);
        for (std::size_t i = 0; i < count; ++i) {
            const auto p =
                rgba_of<std::uint8_t>(bytes->data() + i * std::size_t(pixels.channels), pixels.channels, 255);
            words.push_back(uint(p.x) | uint(p.y) << 8 | uint(p.z) << 16 | uint(p.w) << 24);
        }
    } else {
        const auto& floats = std::get<std::vector<float>>(pixels.data);
        entry->second.kind = kernels::TEXTURE_RGBA16F;
        words.reserve(words.size() + 2 * count);
        for (std::size_t i = 0; i < count; ++i) {
            auto p = rgba_of<float>(floats.data() + i * std::size_t(pixels.channels), pixels.channels, 1.0f);
            if (srgb && pixels.encoded)
                for (int k = 0; k < 3; ++k) p[k] = srgb_decoded(p[k]);
            for (int k = 0; k < 4; ++k) p[k] = std::isfinite(p[k]) ? glm::clamp(p[k], -65504.0f, 65504.0f) : 0.0f;
            words.push_back(glm::packHalf2x16({p.x, p.y}));
            words.push_back(glm::packHalf2x16({p.z, p.w}));
        }
    }
    return entry->second;
}

template <class PictureTexture>
Result<kernels::Texture> picture_record(const PictureTexture& picture, std::vector<uint>& words, TexelsOf& known) {
    const PixelBuffer& pixels = *picture.pixels;
    const Result<Texels> texels = append_texels(pixels, picture.srgb, words, known);
    if (!texels) return texels.error();
    kernels::Texture t = {};
    t.kind = texels->kind;
    t.width = uint(pixels.width);
    t.height = uint(pixels.height);
    t.word_first = texels->word_first;
    t.srgb = t.kind == kernels::TEXTURE_RGBA8 && picture.srgb ? 1 : 0;
    t.filter_kind = picture.filter == Filter::nearest ? kernels::FILTER_NEAREST : kernels::FILTER_TRILINEAR;
    t.face_first = kernels::NONE;
    return t;
}

Result<kernels::Texture> image_record(const ImageTexture& image, std::vector<uint>& words, TexelsOf& known) {
    Result<kernels::Texture> t = picture_record(image, words, known);
    if (!t) return t;
    const TexturePlace place = texture_place(image);
    t->wrap_u = place.wrap_u;
    t->wrap_v = place.wrap_v;
    t->uv_set = uint(image.uv_set);
    t->row_u = place.row_u;
    t->row_v = place.row_v;
    t->offset = image.offset;
    return t;
}

Result<kernels::Texture> face_record(const FaceTexture& faces, std::vector<uint>& words, TexelsOf& known) {
    Result<kernels::Texture> t = picture_record(faces, words, known);
    if (!t) return t;
    const Result<uint> first = pool_place(words.size(), 24, WORDS);
    if (!first) return first.error();
    t->wrap_u = t->wrap_v = kernels::WRAP_CLAMP;
    t->face_first = *first;
    for (const glm::ivec4& rectangle : faces.faces)
        for (int i = 0; i < 4; ++i) words.push_back(uint(rectangle[i]));
    return t;
}

kernels::Texture checker_record(const CheckerTexture& checker) {
    kernels::Texture t = {};
    t.kind = kernels::TEXTURE_CHECKER;
    t.face_first = kernels::NONE;
    t.row_u = {checker.scale.x, 0};
    t.row_v = {0, checker.scale.y};
    t.offset = checker.offset;
    t.color_a = checker.color_a;
    t.color_b = checker.color_b;
    return t;
}

}  // namespace

Result<void> add_textures(Compilation& c) {
    TexelsOf known;
    for (const Texture& texture : c.scene.textures) {
        Result<kernels::Texture> record = kernels::Texture{};
        if (const auto* image = std::get_if<ImageTexture>(&texture.data))
            record = image_record(*image, c.out.words, known);
        else if (const auto* faces = std::get_if<FaceTexture>(&texture.data))
            record = face_record(*faces, c.out.words, known);
        else record = checker_record(std::get<CheckerTexture>(texture.data));
        if (!record) return record.error();
        c.out.textures.push_back(*record);
    }
    return {};
}

vec3 mean_color(const CompiledScene& out, kernels::uint texture, kernels::uint face) {
    if (texture == kernels::NONE) return vec3(1);
    const kernels::Texture& t = out.textures[texture];
    if (t.kind == kernels::TEXTURE_CHECKER) return 0.5f * (t.color_a + t.color_b);
    const kernels::SceneView view = out.view();
    int left = 0, top = 0, right = int(t.width), bottom = int(t.height);
    if (t.face_first != kernels::NONE) {
        const uint* rectangle = &out.words[t.face_first + 4 * std::min(face, 5u)];
        left = int(rectangle[0]), top = int(rectangle[1]);
        right = left + int(rectangle[2]), bottom = top + int(rectangle[3]);
    }
    // A grid of texels is enough for a light's power, which only steers sampling.
    const int step_x = std::max(1, (right - left) / 256), step_y = std::max(1, (bottom - top) / 256);
    glm::dvec3 sum(0);
    double count = 0;
    for (int y = top; y < bottom; y += step_y)
        for (int x = left; x < right; x += step_x, ++count) sum += glm::dvec3(vec3(kernels::texel_at(view, t, x, y)));
    return vec3(sum / count);
}

}  // namespace spinel
