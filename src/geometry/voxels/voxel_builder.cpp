#include "geometry/voxels/voxel_builder.h"

namespace spinel {

kernels::VoxelGrid append_voxels(const VoxelTree& tree, std::vector<kernels::VoxelNode>& nodes,
                                 std::vector<std::uint32_t>& words) {
    const VoxelTree::Arrays& arrays = tree.arrays();
    kernels::VoxelGrid grid = {};
    grid.size = tree.size();
    grid.level_count = std::uint32_t(tree.level_count());
    grid.root = arrays.root;
    grid.node_first = std::uint32_t(nodes.size());
    nodes.insert(nodes.end(), arrays.nodes.begin(), arrays.nodes.end());
    grid.palette_first = std::uint32_t(words.size());
    words.insert(words.end(), arrays.palettes.begin(), arrays.palettes.end());
    grid.reference_first = arrays.references.empty() ? kernels::NONE : std::uint32_t(words.size());
    words.insert(words.end(), arrays.references.begin(), arrays.references.end());
    return grid;
}

}  // namespace spinel
