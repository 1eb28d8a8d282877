#pragma once
// Scenes of one representation from scenes of others.

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

struct VoxeliseOptions {
    int resolution = 0;      // cells along the longest edge of all that is converted
    bool solid = false;      // meshes are filled; otherwise their surface alone
    float threshold = 0.5f;  // of volumes: what is at least so dense is solid
    int max_colors = 255;    // of the palette: materials and colours of textures together
};

// One set of voxels in the space of the world, of all objects of the scene: where several are, the last one counts.
//
// A material without a texture is one entry of the palette, as it is. Colours of textures and of vertices are averaged
// over each cell, and quantised together; the entries are the material in these colours. A texel that is more
// transparent than not makes no voxel. Other textures (roughness, normals, emission) are left out.
// What meshes enclose is one entry: that of the first slot. Infinite planes are left out, and a note says so.
Result<Scene> voxelise_scene(const Scene& scene, const VoxeliseOptions& options);

// Every set of voxels becomes a mesh of its visible faces (greedy_mesh.h), every mesh stays. Other kinds are refused.
Result<Scene> mesh_scene(const Scene& scene);

}  // namespace spinel
