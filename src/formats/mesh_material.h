#pragma once
// Materials of mesh files in the terms of the renderer.

#include <filesystem>

#include "core/result.h"
#include "formats/gltf_extras.h"
#include "formats/mesh_textures.h"
#include "spinel/scene.h"

struct aiMaterial;

namespace spinel {

// What is read:
//   metallic-roughness (glTF, and MTL with Pr/Pm)  principled: base colour, metallic, roughness, normal map,
//   emission;
//       opacity by alpha mode; KHR transmission makes a dielectric with KHR ior and the attenuation of KHR
//       volume
//   Phong (MTL)  diffuse from Kd; plastic where Ks is not small; mirror and glass for illum 3, 5 and 4, 6, 7,
//   9;
//       opacity d, map_d; emission Ke; index Ni
// A file's way to say "no material" gives the renderer's default. `extras` belongs to a glTF material, else
// null.
Result<Material> mesh_material(const aiMaterial& source, const GltfExtras::MaterialExtras* extras,
                               MeshTextures& textures);

}  // namespace spinel
