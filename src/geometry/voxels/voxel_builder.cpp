#include "geometry/voxels/voxel_builder.h"

#include <algorithm>
#include <string>

namespace spinel {

Result<void> validate_voxels(const VoxelGeometry& voxels) {
    const ivec3 size = voxels.size;
    const std::string shape = std::to_string(size.x) + "×" + std::to_string(size.y) + "×" + std::to_string(size.z);
    if (size.x < 1 || size.y < 1 || size.z < 1)
        return Error{"voxel grid has size " + shape + "; every edge must be at least 1"};
    constexpr std::uint64_t limit = 0xfffffffcull / 6;  // a face of a cell is numbered in 32 bits, NONE excepted
    const std::uint64_t layer = std::uint64_t(size.x) * std::uint64_t(size.y);
    if (layer > limit || layer * std::uint64_t(size.z) > limit) {
        return Error{"voxel grid of size " + shape + " is too large: at most " + std::to_string(limit) + " cells"};
    }
    const std::uint64_t count = layer * std::uint64_t(size.z);
    if (voxels.cells.size() != count) {
        return Error{"voxel grid of size " + shape + " has " + std::to_string(voxels.cells.size()) +
                     " cells instead of " + std::to_string(count)};
    }
    return {};
}

Result<VoxelData> build_voxels(const VoxelGeometry& voxels) {
    if (auto valid = validate_voxels(voxels); !valid) return valid.error();
    VoxelData data;
    data.grid.size = voxels.size;
    data.grid.word_first = 0;
    data.words.assign((voxels.cells.size() + 3) / 4, 0u);
    for (std::size_t i = 0; i < voxels.cells.size(); ++i) {
        data.words[i / 4] |= std::uint32_t(voxels.cells[i]) << (8 * (i % 4));
    }
    data.slot_count = *std::max_element(voxels.cells.begin(), voxels.cells.end());
    return data;
}

}  // namespace spinel
