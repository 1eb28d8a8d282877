// Numeric block ids of Minecraft before 1.13, in the words of today.

#include <array>
#include <string>
#include <string_view>

#include "formats/blocks.h"

namespace spinel {
namespace {

// '#' is replaced by one of a family that the data chooses; what turns is told behind '@' (see facing_of()).
constexpr std::string_view NAMES[256] = {
    "air",
    "",
    "grass_block",
    "",
    "cobblestone",
    "#wood_planks",
    "#sapling",
    "bedrock",
    "water",
    "water",
    "lava",
    "lava",
    "",
    "gravel",
    "gold_ore",
    "iron_ore",
    "coal_ore",
    "",
    "",
    "",
    "glass",
    "lapis_ore",
    "lapis_block",
    "dispenser",
    "",
    "note_block",
    "red_bed",
    "powered_rail",
    "detector_rail",
    "sticky_piston",
    "cobweb",
    "",
    "dead_bush",
    "piston",
    "piston_head",
    "#dye_wool",
    "moving_piston",
    "dandelion",
    "",
    "brown_mushroom",
    "red_mushroom",
    "gold_block",
    "iron_block",
    "",
    "",
    "bricks",
    "tnt",
    "bookshelf",
    "mossy_cobblestone",
    "obsidian",
    "torch@torch",
    "fire",
    "spawner",
    "oak_stairs@stairs",
    "chest",
    "redstone_wire",
    "diamond_ore",
    "diamond_block",
    "crafting_table",
    "wheat",
    "farmland",
    "furnace",
    "furnace",
    "oak_sign",
    "oak_door@door",
    "ladder@wall",
    "rail",
    "cobblestone_stairs@stairs",
    "oak_wall_sign@wall",
    "lever",
    "stone_pressure_plate",
    "iron_door@door",
    "oak_pressure_plate",
    "redstone_ore",
    "redstone_ore",
    "redstone_torch@torch",
    "redstone_torch@torch",
    "stone_button@button",
    "",
    "ice",
    "snow_block",
    "cactus",
    "clay",
    "sugar_cane",
    "jukebox",
    "oak_fence",
    "carved_pumpkin",
    "netherrack",
    "soul_sand",
    "glowstone",
    "nether_portal@portal",
    "jack_o_lantern",
    "cake",
    "repeater",
    "repeater",
    "#dye_stained_glass",
    "oak_trapdoor@trapdoor",
    "",
    "",
    "brown_mushroom_block",
    "red_mushroom_block",
    "iron_bars",
    "glass_pane",
    "melon",
    "pumpkin_stem",
    "melon_stem",
    "vine@vine",
    "oak_fence_gate@gate",
    "brick_stairs@stairs",
    "stone_brick_stairs@stairs",
    "mycelium",
    "lily_pad",
    "nether_bricks",
    "nether_brick_fence",
    "nether_brick_stairs@stairs",
    "nether_wart",
    "enchanting_table",
    "brewing_stand",
    "cauldron",
    "end_portal",
    "end_portal_frame",
    "end_stone",
    "dragon_egg",
    "redstone_lamp",
    "redstone_lamp[lit=true]",
    "",
    "",
    "cocoa",
    "sandstone_stairs@stairs",
    "emerald_ore",
    "ender_chest",
    "tripwire_hook",
    "tripwire",
    "emerald_block",
    "spruce_stairs@stairs",
    "birch_stairs@stairs",
    "jungle_stairs@stairs",
    "command_block",
    "beacon",
    "",
    "flower_pot",
    "carrots",
    "potatoes",
    "oak_button@button",
    "skeleton_skull",
    "anvil",
    "trapped_chest",
    "light_weighted_pressure_plate",
    "heavy_weighted_pressure_plate",
    "comparator",
    "comparator",
    "daylight_detector",
    "redstone_block",
    "nether_quartz_ore",
    "hopper",
    "",
    "quartz_stairs@stairs",
    "activator_rail",
    "dropper",
    "#dye_terracotta",
    "#dye_stained_glass_pane",
    "",
    "",
    "acacia_stairs@stairs",
    "dark_oak_stairs@stairs",
    "slime_block",
    "barrier",
    "iron_trapdoor@trapdoor",
    "",
    "sea_lantern",
    "hay_block",
    "#dye_carpet",
    "terracotta",
    "coal_block",
    "packed_ice",
    "",
    "white_banner",
    "white_wall_banner@wall",
    "daylight_detector",
    "",
    "red_sandstone_stairs@stairs",
    "",
    "",
    "spruce_fence_gate@gate",
    "birch_fence_gate@gate",
    "jungle_fence_gate@gate",
    "dark_oak_fence_gate@gate",
    "acacia_fence_gate@gate",
    "spruce_fence",
    "birch_fence",
    "jungle_fence",
    "dark_oak_fence",
    "acacia_fence",
    "spruce_door@door",
    "birch_door@door",
    "jungle_door@door",
    "acacia_door@door",
    "dark_oak_door@door",
    "end_rod",
    "chorus_plant",
    "chorus_flower",
    "purpur_block",
    "purpur_pillar",
    "purpur_stairs@stairs",
    "",
    "",
    "end_stone_bricks",
    "beetroots",
    "dirt_path",
    "end_gateway",
    "repeating_command_block",
    "chain_command_block",
    "frosted_ice",
    "magma_block",
    "nether_wart_block",
    "red_nether_bricks",
    "bone_block",
    "structure_void",
    "observer",
    "white_shulker_box",
    "orange_shulker_box",
    "magenta_shulker_box",
    "light_blue_shulker_box",
    "yellow_shulker_box",
    "lime_shulker_box",
    "pink_shulker_box",
    "gray_shulker_box",
    "light_gray_shulker_box",
    "cyan_shulker_box",
    "purple_shulker_box",
    "blue_shulker_box",
    "brown_shulker_box",
    "green_shulker_box",
    "red_shulker_box",
    "black_shulker_box",
    "white_glazed_terracotta",
    "orange_glazed_terracotta",
    "magenta_glazed_terracotta",
    "light_blue_glazed_terracotta",
    "yellow_glazed_terracotta",
    "lime_glazed_terracotta",
    "pink_glazed_terracotta",
    "gray_glazed_terracotta",
    "light_gray_glazed_terracotta",
    "cyan_glazed_terracotta",
    "purple_glazed_terracotta",
    "blue_glazed_terracotta",
    "brown_glazed_terracotta",
    "green_glazed_terracotta",
    "red_glazed_terracotta",
    "black_glazed_terracotta",
    "#dye_concrete",
    "#dye_concrete_powder",
    "",
    "",
    "structure_block",
};

constexpr std::array<std::string_view, 16> LEGACY_DYES = {
    "white",      "orange", "magenta", "light_blue", "yellow", "lime",  "pink", "gray",
    "light_gray", "cyan",   "purple",  "blue",       "brown",  "green", "red",  "black"};
constexpr std::array<std::string_view, 8> LEGACY_WOODS = {"oak",    "spruce",   "birch", "jungle",
                                                          "acacia", "dark_oak", "oak",   "oak"};
constexpr std::array<std::string_view, 8> STONE_SLABS = {"smooth_stone", "sandstone",   "petrified_oak", "cobblestone",
                                                         "brick",        "stone_brick", "nether_brick",  "quartz"};

template <std::size_t n>
std::string pick(const std::array<std::string_view, n>& list, int data) {
    return std::string(list[std::size_t(data) % n]);
}

std::string slab(std::string base, int data, bool is_double) {
    return std::move(base) + "_slab[type=" + (is_double ? "double" : data & 8 ? "top" : "bottom") + "]";
}

// Blocks that are another thing for another value of the data.
std::string variant(int id, int data) {
    using V = std::array<std::string_view, 8>;
    switch (id) {
        case 1:
            return pick(V{"stone", "granite", "polished_granite", "diorite", "polished_diorite", "andesite",
                          "polished_andesite", "stone"},
                        data);
        case 3: return pick(std::array<std::string_view, 4>{"dirt", "coarse_dirt", "podzol", "dirt"}, data);
        case 12: return data == 1 ? "red_sand" : "sand";
        case 17: return pick(LEGACY_WOODS, data & 3) + "_log";
        case 18: return pick(LEGACY_WOODS, data & 3) + "_leaves";
        case 19: return data == 1 ? "wet_sponge" : "sponge";
        case 24:
            return pick(
                std::array<std::string_view, 4>{"sandstone", "chiseled_sandstone", "cut_sandstone", "sandstone"}, data);
        case 31: return data == 0 ? "dead_bush" : data == 2 ? "fern" : "short_grass";
        case 38: {
            constexpr std::array<std::string_view, 9> flowers = {"poppy",       "blue_orchid", "allium",
                                                                 "azure_bluet", "red_tulip",   "orange_tulip",
                                                                 "white_tulip", "pink_tulip",  "oxeye_daisy"};
            return pick(flowers, data < 9 ? data : 0);
        }
        case 43: return slab(pick(STONE_SLABS, data & 7), data, true);
        case 44: return slab(pick(STONE_SLABS, data & 7), data, false);
        case 78: return "snow[layers=" + std::to_string((data & 7) + 1) + "]";
        case 97:
            return pick(V{"stone", "cobblestone", "stone_bricks", "mossy_stone_bricks", "cracked_stone_bricks",
                          "chiseled_stone_bricks", "stone", "stone"},
                        data);
        case 98:
            return pick(std::array<std::string_view, 4>{"stone_bricks", "mossy_stone_bricks", "cracked_stone_bricks",
                                                        "chiseled_stone_bricks"},
                        data);
        case 125: return slab(pick(LEGACY_WOODS, data & 7), data, true);
        case 126: return slab(pick(LEGACY_WOODS, data & 7), data, false);
        case 139: return data == 1 ? "mossy_cobblestone_wall" : "cobblestone_wall";
        case 155:
            return pick(V{"quartz_block", "chiseled_quartz_block", "quartz_pillar", "quartz_pillar", "quartz_pillar",
                          "quartz_block", "quartz_block", "quartz_block"},
                        data);
        case 161: return pick(LEGACY_WOODS, 4 + (data & 1)) + "_leaves";
        case 162: return pick(LEGACY_WOODS, 4 + (data & 1)) + "_log";
        case 168:
            return pick(
                std::array<std::string_view, 4>{"prismarine", "prismarine_bricks", "dark_prismarine", "prismarine"},
                data);
        case 175:
            return pick(
                V{"sunflower", "lilac", "tall_grass", "large_fern", "rose_bush", "peony", "tall_grass", "tall_grass"},
                data & 7);
        case 179:
            return pick(std::array<std::string_view, 4>{"red_sandstone", "chiseled_red_sandstone", "cut_red_sandstone",
                                                        "red_sandstone"},
                        data);
        case 181: return slab("red_sandstone", data, true);
        case 182: return slab("red_sandstone", data, false);
        case 204: return slab("purpur", data, true);
        case 205: return slab("purpur", data, false);
        default: return {};
    }
}

// How data turns a block, as properties.
std::string turned(std::string_view how, int data) {
    constexpr std::array<std::string_view, 4> stairs = {"east", "west", "south", "north"};
    constexpr std::array<std::string_view, 4> clockwise = {"east", "south", "west", "north"};
    constexpr std::array<std::string_view, 4> gate = {"south", "west", "north", "east"};
    constexpr std::array<std::string_view, 4> trapdoor = {"north", "south", "west", "east"};
    constexpr std::array<std::string_view, 4> wall = {"north", "south", "west", "east"};  // from data 2 on
    if (how == "stairs") return "[facing=" + pick(stairs, data & 3) + ",half=" + (data & 4 ? "top" : "bottom") + "]";
    if (how == "gate") return "[facing=" + pick(gate, data & 3) + ",open=" + (data & 4 ? "true" : "false") + "]";
    if (how == "trapdoor")
        return "[facing=" + pick(trapdoor, data & 3) + ",open=" + (data & 4 ? "true" : "false") +
               ",half=" + (data & 8 ? "top" : "bottom") + "]";
    if (how == "wall") return "[facing=" + pick(wall, data >= 2 ? data - 2 : 0) + "]";
    if (how == "door")  // the lower half tells where it stands
        return "[facing=" + pick(clockwise, data & 3) + ",open=" + (data & 4 ? "true" : "false") + ",half=both]";
    if (how == "button")
        return (data & 7) == 5 || (data & 7) == 6 ? "[face=floor]"
               : (data & 7) == 0                  ? "[face=ceiling]"
                                                  : "[facing=" + pick(stairs, (data & 7) - 1) + "]";
    if (how == "portal") return (data & 3) == 2 ? "[axis=z]" : "[axis=x]";
    if (how == "vine") {
        std::string sides;
        constexpr std::array<std::string_view, 4> names = {"south", "west", "north", "east"};
        for (std::size_t bit = 0; bit < 4; ++bit)
            if ((data >> bit) & 1) sides += (sides.empty() ? "[" : ",") + std::string(names[bit]) + "=true";
        return sides.empty() ? sides : sides + "]";
    }
    return {};
}

}  // namespace

std::string legacy_block(int id, int data) {
    if (id < 0 || id > 255) return {};
    if (std::string name = variant(id, data); !name.empty()) return name;
    std::string_view name = NAMES[std::size_t(id)];
    if (name.starts_with("#dye_")) return pick(LEGACY_DYES, data) + std::string(name.substr(4));
    if (name.starts_with("#wood_")) return pick(LEGACY_WOODS, data & 7) + std::string(name.substr(5));
    if (name == "#sapling") return pick(LEGACY_WOODS, data & 7) + "_sapling";
    const std::size_t at = name.find('@');
    if (at == name.npos) return std::string(name);
    const std::string_view how = name.substr(at + 1);
    name = name.substr(0, at);
    if (how == "door" && (data & 8)) return "air";  // the upper half: its lower one is as high as both
    if (how == "torch") {
        if (data == 0 || data >= 5) return std::string(name);
        constexpr std::array<std::string_view, 4> facings = {"east", "west", "south", "north"};
        const std::string wall_name = name == "torch" ? "wall_torch" : "redstone_wall_torch";
        return wall_name + "[facing=" + pick(facings, data - 1) + "]";
    }
    return std::string(name) + turned(how, data);
}

}  // namespace spinel
