#pragma once
// NIfTI-1 and NIfTI-2 in one file, `.nii` or `.nii.gz`, of either byte order: scalar samples of every type but complex
// and colours, scaled by scl_slope and scl_inter, in the units of the file (millimetres as a rule).
//
// Sample (i,j,k) stands where the sform says, else the qform, else at multiples of the spacing. The patient's right is
// +x, the head up +y and the back of the head +z. Of a row of volumes LoadOptions::frame chooses one.
//
//   https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h, nifti2.h

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_nifti(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
