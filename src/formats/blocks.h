#pragma once
// What the blocks of Minecraft and Luanti look like to a path tracer, by name. Lengths are in blocks.
//
// Cubes fill their cell, and so do leaves, since their holes are finer than a block. Blocks of other shapes are boxes
// within the cell, as the game has them where that is a few boxes (slabs, stairs, fences, panes, doors, torches), and
// a stand-in where it is not (plants, rails). Air, wires and what cannot be seen are nothing. Water, glass, ice, slime
// and honey are dielectrics that absorb; lava, lamps and torches emit.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/scene_view.h"

namespace spinel {

struct BlockBox {
    glm::vec3 lower, upper;  // of the cell [0,1]³; a door's reaches above it
};

struct Block {
    // What joins with its neighbours at the four sides, where the file does not say whether it does.
    enum class Joint { none, fence, wall, pane };

    std::string name;
    bool cube = false;            // fills its cell
    std::vector<BlockBox> boxes;  // of other shapes; neither: nothing is seen
    Joint joint = Joint::none;
    kernels::Material material{};  // of the cube or the boxes
    bool in_water = false;         // the cell is full of water besides
    bool known = true;             // false: the look is a guess
};

// Of a block state: "minecraft:oak_stairs[facing=east,half=top]". The namespace may be absent; Luanti's nodes are known
// by theirs ("default:tree").
Block block_of(std::string_view state);

// The state that a numeric id and its four bits of data meant before Minecraft 1.13; empty: there was none.
std::string legacy_block(int id, int data);

constexpr unsigned JOINS_NORTH = 1, JOINS_SOUTH = 2, JOINS_WEST = 4, JOINS_EAST = 8;  // −z, +z, −x, +x
std::vector<BlockBox> joined_boxes(Block::Joint joint, unsigned sides);

}  // namespace spinel
