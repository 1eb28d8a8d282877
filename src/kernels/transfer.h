#ifndef SPINEL_KERNELS_TRANSFER_H
#define SPINEL_KERNELS_TRANSFER_H
// A transfer function: what values of a volume look like, as two tables over the value x, four numbers an entry:
//   extinction table   colour·σ(x), σ(x)          σ per world unit
//   integral table     ∫ of that from entry 0 to x, in units of an entry
// Along a piece of a ray on which the value goes from x0 to x1, linearly, the mean of colour·σ and σ is a difference of
// the second table over x1 − x0: pre-integration without a table of pairs (Engel, Kraus, Ertl, "High-Quality
// Pre-Integrated Volume Rendering Using Hardware-Accelerated Pixel Shading", 2001). A thin layer between two samples is
// not missed, so a step of a voxel is enough. Attenuation within the piece is taken of its mean: colours are not sorted
// within a step.
#include "path_settings.h"
#include "scene_view.h"
KERNELS_BEGIN

// DvrSettings::mode
const uint DVR_COMPOSITE = 0u;
const uint DVR_MAXIMUM = 1u;
const uint DVR_AVERAGE = 2u;
const uint DVR_ISOSURFACE = 3u;

// A shorter way between two values says nothing reliable by difference; the function in its middle does.
const float TRANSFER_LEAST_DIFFERENCE = 0.05f;

FN vec4 transfer_row(const_in(SceneView) scene, uint first, uint i) {
    uint at = first + 4u * i;
    return vec4(scene.floats.at[at], scene.floats.at[at + 1u], scene.floats.at[at + 2u], scene.floats.at[at + 3u]);
}

// Linear between entries.
FN vec4 transfer_entry(const_in(SceneView) scene, uint first, uint size, float x) {
    float at = clamp(x, 0.0f, float(size - 1u));
    uint i = min(uint(at), size - 2u);
    return mix(transfer_row(scene, first, i), transfer_row(scene, first, i + 1u), at - float(i));
}

FN float transfer_place(const_in(DvrSettings) s, float value) { return (value - s.low) * s.scale; }

FN vec4 transfer_at(const_in(SceneView) scene, const_in(DvrSettings) s, float x) {
    return transfer_entry(scene, s.table_first, s.table_size, x);
}

// Mean of colour·σ and of σ between two values.
FN vec4 transfer_between(const_in(SceneView) scene, const_in(DvrSettings) s, float x0, float x1) {
    float last = float(s.table_size - 1u);
    x0 = clamp(x0, 0.0f, last);
    x1 = clamp(x1, 0.0f, last);
    if (abs(x1 - x0) < TRANSFER_LEAST_DIFFERENCE) return transfer_at(scene, s, 0.5f * (x0 + x1));
    uint integral = s.table_first + 4u * s.table_size;
    return (transfer_entry(scene, integral, s.table_size, x1) - transfer_entry(scene, integral, s.table_size, x0)) /
           (x1 - x0);
}

KERNELS_END
#endif
