#pragma once
// NRRD, `.nrrd` with the samples behind the header or `.nhdr` with the name of a file that holds them, raw or packed by
// gzip; and MetaImage, `.mha`. Scalar samples of two or three dimensions, in their own units. Axes may be oblique;
// where the space is anatomical, the patient's right is +x, the head up +y and the back of the head +z.
//
//   https://teem.sourceforge.net/nrrd/format.html, https://itk.org/Wiki/ITK/MetaIO/Documentation

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_nrrd(const std::filesystem::path& path, const LoadOptions& options = {});
Result<Scene> load_metaimage(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
