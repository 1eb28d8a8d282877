#include "image/tone_map.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "core/parallel.h"

namespace spinel {
namespace {

using glm::mat3;
using glm::vec3;

// Finite and not negative. The bound leaves room for the squares in the curves below.
float sanitised(float x) {
    if (!(x > 0.0f)) return 0.0f;  // also NaN
    return std::min(x, 1e15f);
}

vec3 aces(vec3 color) {
    // sRGB to AP1 with the reference transform's saturation, and back (rows of the published matrices).
    const mat3 to_ap1 = glm::transpose(mat3(0.59719f, 0.35458f, 0.04823f,  //
                                            0.07600f, 0.90834f, 0.01566f,  //
                                            0.02840f, 0.13383f, 0.83777f));
    const mat3 from_ap1 = glm::transpose(mat3(1.60475f, -0.53108f, -0.07367f,  //
                                              -0.10208f, 1.10813f, -0.00605f,  //
                                              -0.00327f, -0.07276f, 1.07602f));
    const vec3 v = to_ap1 * color;
    const vec3 fitted = (v * (v + 0.0245786f) - 0.000090537f) / (v * (0.983729f * v + 0.4329510f) + 0.238081f);
    return from_ap1 * fitted;
}

// Gives display code values, already encoded.
vec3 agx_encoded(vec3 color) {
    // The inset pulls the primaries inwards, so that a bright saturated colour reaches all three channels.
    static const mat3 inset(0.842479062253094f, 0.0423282422610123f, 0.0423756549057051f,  //
                            0.0784335999999992f, 0.878468636469772f, 0.0784336f,           //
                            0.0792237451477643f, 0.0791661274605434f, 0.879142973793104f);
    static const mat3 outset = glm::inverse(inset);
    const float lowest = -12.47393f;  // stops; middle grey of 0.18 sits 10 stops above
    const float highest = 4.026069f;
    vec3 x = glm::max(inset * color, vec3(1e-10f));
    x = (glm::clamp(glm::log2(x), lowest, highest) - lowest) / (highest - lowest);
    const vec3 sigmoid =
        (((((15.5f * x - 40.14f) * x + 31.96f) * x - 6.868f) * x + 0.4298f) * x + 0.1191f) * x - 0.00232f;
    return outset * sigmoid;
}

vec3 display_color(vec3 color, ToneMap tone_map) {
    if (tone_map == ToneMap::agx) return glm::clamp(agx_encoded(color), 0.0f, 1.0f);
    if (tone_map == ToneMap::aces) color = aces(color);
    color = glm::clamp(color, 0.0f, 1.0f);
    return {srgb_encoded(color.x), srgb_encoded(color.y), srgb_encoded(color.z)};
}

}  // namespace

float srgb_encoded(float linear) {
    if (!(linear > 0.0f)) return 0.0f;  // also NaN
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

float srgb_decoded(float encoded) {
    if (!(encoded > 0.0f)) return 0.0f;  // also NaN
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

Image tone_mapped(const Image& linear, ToneMap tone_map, float exposure_stops) {
    Image result = linear;
    const float scale = std::exp2(exposure_stops);
    const std::size_t channels = static_cast<std::size_t>(linear.channels);
    const std::size_t pixel_count = channels == 0 ? 0 : linear.values.size() / channels;
    parallel_for(pixel_count, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            float* pixel = result.values.data() + i * channels;
            vec3 color(0.0f);
            for (int c = 0; c < 3; ++c) color[c] = sanitised(pixel[channels >= 3 ? c : 0] * scale);
            color = display_color(color, tone_map);
            if (channels >= 3) {
                for (int c = 0; c < 3; ++c) pixel[c] = color[c];
            } else {
                pixel[0] = color.y;
            }
            if (channels == 2 || channels == 4) pixel[channels - 1] = std::min(sanitised(pixel[channels - 1]), 1.0f);
        }
    });
    return result;
}

}  // namespace spinel
