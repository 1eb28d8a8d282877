#pragma once
// From voxels as the user gave them to the words that kernels/voxels.h walks.

#include <cstdint>
#include <vector>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

struct VoxelData {
    std::vector<std::uint32_t> words;  // four cells a word, little end first
    kernels::VoxelGrid grid;           // word_first = 0: relative to `words`
    std::uint32_t slot_count = 0;      // the largest palette index: so many material slots does an instance need
};

// An error where the dense words of a set would be too many, or a palette index does not fit a byte.
Result<VoxelData> build_voxels(const VoxelGeometry& voxels);

}  // namespace spinel
