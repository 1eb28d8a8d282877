#pragma once
// Dense volumes in two plain forms.
//
// .bits: 4096 bytes, 32×32×32 bits of a solid. Little-endian word x + 32·z holds the column above (x, z): bit
// y, the least significant first, is 1 inside. Fills the unit cube [0,1]³.
//
// .svol: lines of text, an empty line, then the samples, little-endian, x fastest, then y, then z:
//     spinel volume 1
//     size 64 64 32
//     type u8                (u8 and u16: 0 … their greatest value means 0 … 1; f32: as it is, finite)
//     spacing 0.5 0.5 1      (between samples; optional, 1 1 1)
//     origin 0 0 0           (the corner of the box that the samples fill; optional, 0 0 0)
//     filter linear          (or nearest; optional)
// Sample (i,j,k) sits at origin + spacing·(i+½, j+½, k+½).
//
// The fragment is that of volume_scene.h.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_bits(const std::filesystem::path& path, const LoadOptions& options = {});
Result<Scene> load_svol(const std::filesystem::path& path, const LoadOptions& options = {});

// Writes the scene's only grid as f32. A grid that is turned, mirrored or sheared in its object's space is
// refused.
Result<Notes> save_svol(const Scene& scene, const std::filesystem::path& path);

}  // namespace spinel
