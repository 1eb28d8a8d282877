#pragma once
// Materials of mesh files in the terms of the renderer.

#include <string>
#include <vector>

#include "core/result.h"
#include "formats/gltf_extras.h"
#include "formats/mesh_textures.h"
#include "spinel/scene.h"

struct aiMaterial;

namespace spinel {

// What is read:
//   metallic-roughness (glTF, and MTL with Pr/Pm)  principled: base colour, metallic, roughness, normal map, emission,
//       clear coat, transmission of thin walls; solid glass (transmission and a thickness) is a dielectric with what it
//       absorbs; unlit ones emit their colour; opacity by alpha mode
//   Phong (MTL)  diffuse from Kd; plastic where Ks is not small; mirror and glass for illum 3, 5 and 4, 6, 7, 9;
//       opacity d, map_d; emission Ke; index Ni
// A file's way to say "no material" gives the renderer's default. `extras` belongs to a glTF material, else null. What
// is changed is added to `notes`.
Result<Material> mesh_material(const aiMaterial& source, const GltfExtras::MaterialExtras* extras,
                               MeshTextures& textures, std::vector<std::string>& notes);

}  // namespace spinel
