#pragma once
// Structures of Minecraft, each a box of blocks:
//   .schem      Sponge schematics, versions 1 to 3
//   .schematic  MCEdit's, with numeric ids
//   .litematic  Litematica's, of one or several regions
//   .nbt        the game's own structures
// Entities and biomes are not read.

#include <filesystem>

#include "core/result.h"
#include "spinel/formats.h"
#include "spinel/scene.h"

namespace spinel {

Result<Scene> load_sponge_schematic(const std::filesystem::path& path, const LoadOptions& options = {});
Result<Scene> load_mcedit_schematic(const std::filesystem::path& path, const LoadOptions& options = {});
Result<Scene> load_litematic(const std::filesystem::path& path, const LoadOptions& options = {});
Result<Scene> load_structure(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace spinel
