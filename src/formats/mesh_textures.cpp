#include "formats/mesh_textures.h"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "formats/file_bytes.h"
#include "image/image_io.h"
#include "image/tone_map.h"
#include "kernels/constants.h"

namespace spinel {
namespace {

constexpr int GL_NEAREST = 9728;  // that glTF names its filters by

// "a%20b" → "a b": glTF's references are URIs.
std::string percent_decoded(const std::string& text) {
    const auto digit = [](char c) {
        if (c >= '0' && c <= '9') return c - '0';
        if (c >= 'a' && c <= 'f') return c - 'a' + 10;
        if (c >= 'A' && c <= 'F') return c - 'A' + 10;
        return -1;
    };
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%' && i + 2 < text.size() && digit(text[i + 1]) >= 0 && digit(text[i + 2]) >= 0) {
            result += char(digit(text[i + 1]) * 16 + digit(text[i + 2]));
            i += 2;
        } else {
            result += text[i];
        }
    }
    return result;
}

// 16-bit PNGs hold sRGB-encoded values in floats; float textures are linear.
void decode_srgb(PixelBuffer& pixels) {
    auto* values = std::get_if<std::vector<float>>(&pixels.data);
    if (!values) return;
    const std::size_t channels = std::size_t(pixels.channels), colors = channels >= 3 ? 3 : 1;
    for (std::size_t i = 0; i < values->size(); ++i)
        if (i % channels < colors) (*values)[i] = srgb_decoded((*values)[i]);
}

// A picture of opacity alone: grey 1 and, in the alpha channel, what `opacity` makes of a texel.
template <class T, class Opacity>
PixelBuffer opacity_picture(const PixelBuffer& source, const std::vector<T>& values, T one, Opacity opacity) {
    PixelBuffer result{source.width, source.height, 2, {}};
    auto& out = result.data.emplace<std::vector<T>>();
    out.reserve(result.value_count());
    for (std::size_t i = 0; i < values.size(); i += std::size_t(source.channels)) {
        out.push_back(one);
        out.push_back(opacity(&values[i], one));
    }
    return result;
}

// Null: opaque everywhere.
std::shared_ptr<const PixelBuffer> opacity_of(const PixelBuffer& source, TextureRole role, float cutoff) {
    const bool has_alpha = source.channels == 2 || source.channels == 4;
    if (!has_alpha && role != TextureRole::coverage) return nullptr;
    return std::visit(
        [&](const auto& values) {
            using T = typename std::decay_t<decltype(values)>::value_type;
            const T one = std::is_same_v<T, float> ? T(1) : T(255);
            const int channel = has_alpha ? source.channels - 1 : 0;
            return std::make_shared<const PixelBuffer>(
                opacity_picture<T>(source, values, one, [&](const T* texel, T full) {
                    if (role == TextureRole::mask) return float(texel[channel]) >= cutoff * float(full) ? full : T(0);
                    return texel[channel];
                }));
        },
        source.data);
}

float channel(const PixelBuffer& source, int x, int y, int c) {
    const std::size_t index =
        (std::size_t(y) * std::size_t(source.width) + std::size_t(x)) * std::size_t(source.channels) + std::size_t(c);
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&source.data)) return float((*bytes)[index]) / 255;
    return std::get<std::vector<float>>(source.data)[index];
}

// Heights are grey; normals are colours, mostly of (½, ½, 1).
bool is_normal_map(const PixelBuffer& source) {
    if (source.channels < 3) return false;
    glm::dvec3 sum(0);
    for (int y = 0; y < source.height; ++y)
        for (int x = 0; x < source.width; ++x)
            sum += glm::dvec3(channel(source, x, y, 0), channel(source, x, y, 1), channel(source, x, y, 2));
    sum /= double(source.width) * double(source.height);
    return sum.z > std::max(sum.x, sum.y) + 0.1;
}

// Normals of the surface whose heights are the picture's grey, `depth` texels from black to white, by differences to
// both sides. Tangent space: x along +u, y along +v, which is up in the picture.
std::shared_ptr<const PixelBuffer> normals_of_heights(const PixelBuffer& source, float depth, Wrap wrap) {
    const auto beside = [&](int i, int size) {
        return wrap == Wrap::repeat ? (i + size) % size : std::clamp(i, 0, size - 1);
    };
    PixelBuffer result{source.width, source.height, 3, {}};
    auto& bytes = result.data.emplace<std::vector<std::uint8_t>>();
    bytes.reserve(result.value_count());
    for (int y = 0; y < source.height; ++y) {
        for (int x = 0; x < source.width; ++x) {
            const auto height = [&](int i, int j) {
                return channel(source, beside(i, source.width), beside(j, source.height), 0);
            };
            const glm::vec3 slope(height(x - 1, y) - height(x + 1, y), height(x, y + 1) - height(x, y - 1), 0);
            const glm::vec3 n = glm::normalize(0.5f * depth * slope + glm::vec3(0, 0, 1));
            for (int c = 0; c < 3; ++c) bytes.push_back(std::uint8_t(std::lround((0.5f + 0.5f * n[c]) * 255)));
        }
    }
    return std::make_shared<const PixelBuffer>(std::move(result));
}

Wrap wrap_of(int mode) {
    if (mode == aiTextureMapMode_Clamp) return Wrap::clamp;
    if (mode == aiTextureMapMode_Mirror) return Wrap::mirror;
    return Wrap::repeat;
}

}  // namespace

MeshTextures::MeshTextures(const std::filesystem::path& model, const aiScene& source, Scene& scene)
    : model_(model), source_(source), scene_(scene) {}

Result<std::shared_ptr<const PixelBuffer>> MeshTextures::pixels(const std::string& name, bool srgb) {
    auto& known = pixels_[{name, srgb}];
    if (known) return known;

    Result<PixelBuffer> read = Error{};
    std::string extension = std::filesystem::path(name).extension().string();
    if (const aiTexture* embedded = source_.GetEmbeddedTexture(name.c_str())) {
        const std::string title = model_.string() + ", texture " + name;
        if (embedded->mHeight == 0) {  // an encoded picture of mWidth bytes
            extension = std::string(".") + embedded->achFormatHint;
            read = read_pixels_from_memory(embedded->pcData, embedded->mWidth, title + extension);
        } else {
            PixelBuffer raw{int(embedded->mWidth), int(embedded->mHeight), 4, {}};
            auto& bytes = raw.data.emplace<std::vector<std::uint8_t>>();
            for (std::size_t i = 0; i < std::size_t(raw.width) * std::size_t(raw.height); ++i) {
                const aiTexel& texel = embedded->pcData[i];
                bytes.insert(bytes.end(), {texel.r, texel.g, texel.b, texel.a});
            }
            read = std::move(raw);
        }
    } else {
        std::string file = name;
        std::replace(file.begin(), file.end(), '\\', '/');
        std::error_code error;
        std::filesystem::path path = model_.parent_path() / file;
        if (!std::filesystem::exists(path, error)) path = model_.parent_path() / percent_decoded(file);
        if (!std::filesystem::exists(path, error)) {
            if (!missing_allowed_) return cannot_read(model_, "its texture '" + name + "' is not there");
            if (std::find(missing_.begin(), missing_.end(), name) == missing_.end()) missing_.push_back(name);
            return std::shared_ptr<const PixelBuffer>();
        }
        read = read_pixels(path);
    }
    if (!read) return read.error();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (srgb && extension != ".exr" && extension != ".hdr") decode_srgb(*read);
    known = std::make_shared<const PixelBuffer>(std::move(*read));
    return known;
}

Result<std::uint32_t> MeshTextures::add(const aiMaterial& material, const Use& use) {
    const auto type = aiTextureType(use.type);
    aiString file;
    aiTextureMapping mapping = aiTextureMapping_UV;
    unsigned uv_set = 0;
    if (material.GetTexture(type, use.number, &file, &mapping, &uv_set) != AI_SUCCESS) return kernels::NONE;
    const std::string name = file.C_Str();
    if (name.empty()) return kernels::NONE;
    if (use.place) uv_set = use.place->uv_set;
    auto known_set = std::find(uv_sets_.begin(), uv_sets_.end(), uv_set);
    if (known_set == uv_sets_.end()) {
        if (uv_sets_.size() == 2)
            return cannot_read(model_, "material '" + std::string(material.GetName().C_Str()) +
                                           "' uses three sets of texture coordinates, two are supported");
        known_set = uv_sets_.insert(uv_sets_.end(), uv_set);
    }

    ImageTexture texture;
    texture.srgb = use.role == TextureRole::color;
    texture.uv_set = int(known_set - uv_sets_.begin());
    int wrap_u = aiTextureMapMode_Wrap, wrap_v = aiTextureMapMode_Wrap, magnification = 0;
    material.Get(AI_MATKEY_MAPPINGMODE_U(type, use.number), wrap_u);
    material.Get(AI_MATKEY_MAPPINGMODE_V(type, use.number), wrap_v);
    material.Get(AI_MATKEY_GLTF_MAPPINGFILTER_MAG(type, use.number), magnification);
    texture.wrap = wrap_of(wrap_u);
    if (wrap_v != wrap_u) texture.wrap_v = WrapV(int(wrap_of(wrap_v)) + 1);
    texture.filter = magnification == GL_NEAREST ? Filter::nearest : Filter::linear;
    aiUVTransform transform;
    if (use.place) {
        texture.scale = use.place->scale;
        texture.rotation = use.place->rotation;
        texture.offset = use.place->offset;
    } else if (material.Get(AI_MATKEY_UVTRANSFORM(type, use.number), transform) == AI_SUCCESS) {
        if (transform.mRotation != 0)
            return cannot_read(model_, "texture '" + name + "' is rotated, which is not supported");
        texture.scale = {transform.mScaling.x, transform.mScaling.y};
        texture.offset = {transform.mTranslation.x, transform.mTranslation.y};
    }

    std::ostringstream key;
    key << name << '|' << int(use.role) << '|' << use.amount << '|' << int(texture.wrap) << '|' << int(texture.wrap_v)
        << '|' << int(texture.filter) << '|' << texture.uv_set << '|' << texture.scale.x << ' ' << texture.scale.y
        << ' ' << texture.rotation << ' ' << texture.offset.x << ' ' << texture.offset.y;
    if (const auto known = textures_.find(key.str()); known != textures_.end()) return known->second;

    const Result<std::shared_ptr<const PixelBuffer>> read = pixels(name, texture.srgb);
    if (!read) return read.error();
    if (!*read) return textures_[key.str()] = kernels::NONE;
    texture.pixels = *read;
    if (use.role == TextureRole::relief) {
        if (!is_normal_map(**read)) texture.pixels = normals_of_heights(**read, use.amount, texture.wrap);
    } else if (use.role != TextureRole::color && use.role != TextureRole::data) {
        texture.pixels = opacity_of(**read, use.role, use.amount);
        if (!texture.pixels) return textures_[key.str()] = kernels::NONE;
    }
    texture.file = name[0] == '*' ? model_.string() + " " + name : name;
    scene_.textures.push_back({name, std::move(texture)});
    return textures_[key.str()] = std::uint32_t(scene_.textures.size() - 1);
}

}  // namespace spinel
