#pragma once
// From voxels to a mesh of their visible faces, neighbours of one palette index merged to rectangles.

#include <functional>

#include "core/result.h"
#include "spinel/scene.h"
#include "spinel/voxels.h"

namespace spinel {

// Whether a face of a voxel is hidden by its neighbour across it (0: there is none).
using HidesFace = std::function<bool(std::uint16_t palette, std::uint16_t neighbour)>;

// Two triangles for each rectangle, in the cells' space, outwards; slot p − 1 for palette index p. Faces in one plane
// are merged row by row as far as they go (Lysenko, "Meshing in a Minecraft Game", 2012): few rectangles, not fewest.
// Edges of large rectangles pass corners of small ones (T-junctions); what must be watertight to the last bit needs the
// faces one by one. An error if there are too many faces, or none.
Result<MeshGeometry> greedy_mesh(const VoxelTree& tree, const HidesFace& hides);

}  // namespace spinel
