#pragma once
// The colour of a block by its name: averages of the game's textures, as seen in plain daylight. Grass, leaves and
// water have the tint of plains.

#include <cstdint>
#include <optional>
#include <string_view>

namespace spinel {

struct BlockColor {
    std::uint32_t rgb = 0;  // sRGB, 0xrrggbb
    bool known = true;      // false: no such block is known; the colour is a guess from the words of the name
};

// Of a name without its namespace: "oak_planks". Every name has a colour, the same each time.
BlockColor block_color(std::string_view name);

}  // namespace spinel
