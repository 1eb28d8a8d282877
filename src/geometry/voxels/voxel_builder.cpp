#include "geometry/voxels/voxel_builder.h"

#include <string>

#include "kernels/voxels.h"

namespace spinel {

Result<VoxelData> build_voxels(const VoxelGeometry& voxels) {
    const ivec3 size = voxels.tree->size();
    constexpr std::uint64_t limit = 0xfffffffcull / 6;  // a face of a cell is numbered in 32 bits, NONE excepted
    const std::uint64_t layer = std::uint64_t(size.x) * std::uint64_t(size.y);
    if (layer > limit || layer * std::uint64_t(size.z) > limit)
        return Error{"voxel grid of size " + std::to_string(size.x) + "×" + std::to_string(size.y) + "×" +
                     std::to_string(size.z) + " is too large: at most " + std::to_string(limit) + " cells"};
    if (voxels.tree->palette_maximum() > 255)
        return Error{"voxel grid has palette index " + std::to_string(voxels.tree->palette_maximum()) +
                     "; at most 255 is allowed"};
    VoxelData data;
    data.grid.size = size;
    data.grid.word_first = 0;
    data.words.assign((layer * std::uint64_t(size.z) + 3) / 4, 0u);
    voxels.tree->for_each([&](ivec3 cell, std::uint16_t palette) {
        const std::size_t i = std::size_t(kernels::voxel_linear(size, cell));
        data.words[i / 4] |= std::uint32_t(palette) << (8 * (i % 4));
    });
    data.slot_count = voxels.tree->palette_maximum();
    return data;
}

}  // namespace spinel
