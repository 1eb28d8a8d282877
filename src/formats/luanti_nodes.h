#pragma once
// Luanti's nodes in the words of Minecraft's blocks, whose looks are known (blocks.h).

#include <optional>
#include <string>
#include <string_view>

namespace spinel {

// Of "default:tree" "oak_log"; nothing for nodes of mods that are not known, and for Minecraft's own names.
std::optional<std::string> luanti_node(std::string_view name);

}  // namespace spinel
