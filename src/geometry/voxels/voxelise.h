#pragma once
// From meshes to voxels.

#include "core/result.h"
#include "spinel/scene.h"
#include "spinel/voxels.h"

namespace spinel {

struct VoxelisedMesh {
    VoxelTreePointer tree;         // palette index: the triangle's material slot + 1
    mat4x3 transform = mat4x3(1);  // from the cells' space to the mesh's
};

// Every cell that a triangle touches; conservative, so a closed mesh gives a shell without holes. `resolution` cells
// along the longest edge of the mesh's box. Where triangles of several slots meet, the last one counts.
Result<VoxelisedMesh> voxelise_surface(const MeshGeometry& mesh, int resolution, const VoxelTreeOptions& options = {});

}  // namespace spinel
