#pragma once
// From triangles to the wide hierarchy that CPUs walk (WideUnit), by presets.

#include <span>
#include <string_view>

#include "accel/compact_bvh.h"
#include "accel/grain_bvh.h"
#include "accel/split_bvh.h"
#include "accel/wide_bvh.h"

namespace spinel {

// A way to build; `spinel bench` and scenes name it.
struct WidePreset {
    std::string_view name;
    std::string_view doc;
    bool grains;             // by build_wide_grains(), if compact by build_grain_bvh() …
    SplitBvhOptions binary;  // … or else by build_split_bvh()
    WideBvhOptions wide;
};

// "fast", "balanced", "high"; the last is the default.
std::span<const WidePreset> wide_presets();
const WidePreset& default_wide_preset();

WideBvh build_wide_mesh(std::span<const kernels::Triangle> triangles, const WidePreset& preset = default_wide_preset());
// In the compact layout.
WideBvh build_compact_mesh(std::span<const kernels::Triangle> triangles,
                           const WidePreset& preset = default_wide_preset());

// ClipPrimitive of triangles: the parts of a box below and above a plane that hold the triangle's. Crossings are worked
// out in double and rounded outwards, so nothing is lost.
void clip_triangle(const kernels::Triangle& triangle, const Box& box, int axis, float plane, Box& below, Box& above);

}  // namespace spinel
