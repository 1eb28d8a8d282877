#pragma once
// What a MagicaVoxel material looks like to a path tracer. Lengths are in voxels.

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "formats/vox_file.h"
#include "spinel/scene.h"

namespace spinel::vox {

struct Appearance {
    bool cloud = false;            // no surface at all: only the medium counts
    kernels::Material material{};  // of what has a surface; its `interior` is not set here
    std::optional<Medium> medium;  // inside
};

// Every property may be absent; then MagicaVoxel's default holds. Colours are sRGB bytes.
Appearance appearance(const std::array<std::uint8_t, 4>& color, const Dictionary& properties);

}  // namespace spinel::vox
