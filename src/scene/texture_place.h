#pragma once
// Where texture coordinates lie in a picture.

#include <cmath>

#include "spinel/scene.h"

namespace spinel {

// (row_u·uv, row_v·uv) + offset: scaled, then turned counter-clockwise about (0, 0).
struct TexturePlace {
    vec2 row_u, row_v;
    kernels::uint wrap_u, wrap_v;
};

inline TexturePlace texture_place(const ImageTexture& image) {
    static_assert(kernels::uint(Wrap::repeat) == kernels::WRAP_REPEAT &&
                  kernels::uint(Wrap::clamp) == kernels::WRAP_CLAMP &&
                  kernels::uint(Wrap::mirror) == kernels::WRAP_MIRROR);
    const double angle = glm::radians(double(image.rotation));
    const float c = float(std::cos(angle)), s = float(std::sin(angle));
    const auto wrap_u = kernels::uint(image.wrap);
    return {{c * image.scale.x, -s * image.scale.y},
            {s * image.scale.x, c * image.scale.y},
            wrap_u,
            image.wrap_v == WrapV::same ? wrap_u : kernels::uint(image.wrap_v) - 1u};
}

}  // namespace spinel
