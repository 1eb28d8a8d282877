#include "formats/luanti_nodes.h"

#include <unordered_map>

namespace spinel {
namespace {

struct Pair {
    std::string_view node, block;
};

// Nodes of the default game that are not called alike.
constexpr Pair DEFAULTS[] = {
    {"tree", "oak_log"},
    {"leaves", "oak_leaves"},
    {"wood", "oak_planks"},
    {"sapling", "oak_sapling"},
    {"bush_stem", "oak_log"},
    {"bush_leaves", "oak_leaves"},
    {"bush_sapling", "oak_sapling"},
    {"jungletree", "jungle_log"},
    {"jungleleaves", "jungle_leaves"},
    {"junglewood", "jungle_planks"},
    {"junglesapling", "jungle_sapling"},
    {"emergent_jungle_sapling", "jungle_sapling"},
    {"junglegrass", "tall_grass"},
    {"pine_tree", "spruce_log"},
    {"pine_needles", "spruce_leaves"},
    {"pine_wood", "spruce_planks"},
    {"pine_sapling", "spruce_sapling"},
    {"pine_bush_stem", "spruce_log"},
    {"pine_bush_needles", "spruce_leaves"},
    {"acacia_tree", "acacia_log"},
    {"acacia_wood", "acacia_planks"},
    {"acacia_bush_stem", "acacia_log"},
    {"acacia_bush_leaves", "acacia_leaves"},
    {"aspen_tree", "birch_log"},
    {"aspen_leaves", "birch_leaves"},
    {"aspen_wood", "birch_planks"},
    {"aspen_sapling", "birch_sapling"},
    {"blueberry_bush_leaves", "oak_leaves"},
    {"blueberry_bush_leaves_with_berries", "oak_leaves"},
    {"large_cactus_seedling", "cactus"},
    {"cobble", "cobblestone"},
    {"mossycobble", "mossy_cobblestone"},
    {"stonebrick", "stone_bricks"},
    {"stone_block", "smooth_stone"},
    {"desert_cobble", "desert_stone"},
    {"desert_stonebrick", "desert_stone"},
    {"desert_stone_block", "desert_stone"},
    {"sandstonebrick", "sandstone"},
    {"sandstone_block", "sandstone"},
    {"desert_sandstone_brick", "desert_sandstone"},
    {"desert_sandstone_block", "desert_sandstone"},
    {"silver_sandstone_brick", "silver_sandstone"},
    {"silver_sandstone_block", "silver_sandstone"},
    {"obsidianbrick", "obsidian"},
    {"obsidian_block", "obsidian"},
    {"brick", "bricks"},
    {"dirt_with_grass", "grass_block"},
    {"dirt_with_grass_footsteps", "grass_block"},
    {"dirt_with_dry_grass", "dry_grass_block"},
    {"dirt_with_snow", "snow_block"},
    {"dirt_with_rainforest_litter", "rainforest_litter"},
    {"dirt_with_coniferous_litter", "coniferous_litter"},
    {"dry_dirt_with_dry_grass", "dry_grass_block"},
    {"permafrost_with_stones", "permafrost"},
    {"permafrost_with_moss", "moss_block"},
    {"snowblock", "snow_block"},
    {"snow", "snow[layers=2]"},
    {"cave_ice", "packed_ice"},
    {"water_source", "water"},
    {"water_flowing", "water"},
    {"river_water_source", "water"},
    {"river_water_flowing", "water"},
    {"lava_source", "lava"},
    {"lava_flowing", "lava"},
    {"papyrus", "sugar_cane"},
    {"dry_shrub", "dead_bush"},
    {"sand_with_kelp", "sand"},
    {"coral_skeleton", "dead_coral_block"},
    {"coral_brown", "brown_mushroom_block"},
    {"coral_orange", "horn_coral_block"},
    {"coral_cyan", "tube_coral_block"},
    {"coral_green", "moss_block"},
    {"coral_pink", "brain_coral_block"},
    {"stone_with_coal", "coal_ore"},
    {"stone_with_iron", "iron_ore"},
    {"stone_with_copper", "copper_ore"},
    {"stone_with_tin", "iron_ore"},
    {"stone_with_gold", "gold_ore"},
    {"stone_with_diamond", "diamond_ore"},
    {"stone_with_mese", "gold_ore"},
    {"coalblock", "coal_block"},
    {"steelblock", "iron_block"},
    {"copperblock", "copper_block"},
    {"tinblock", "tin_block"},
    {"bronzeblock", "bronze_block"},
    {"goldblock", "gold_block"},
    {"diamondblock", "diamond_block"},
    {"obsidian_glass", "tinted_glass"},
    {"torch", "torch"},
    {"torch_wall", "torch"},
    {"torch_ceiling", "torch"},
    {"mese_post_light", "meselamp"},
    {"furnace_active", "furnace"},
    {"chest_locked", "chest"},
    {"ladder_wood", "ladder"},
    {"ladder_steel", "ladder"},
    {"sign_wall_wood", "oak_sign"},
    {"sign_wall_steel", "oak_sign"},
    {"fence_wood", "oak_fence"},
    {"fence_junglewood", "jungle_fence"},
    {"fence_pine_wood", "spruce_fence"},
    {"fence_acacia_wood", "acacia_fence"},
    {"fence_aspen_wood", "birch_fence"},
    {"marram_grass_1", "short_grass"},
    {"marram_grass_2", "short_grass"},
    {"marram_grass_3", "short_grass"},
    {"cloud", "white_wool"},
};

}  // namespace

std::optional<std::string> luanti_node(std::string_view name) {
    static const std::unordered_map<std::string_view, std::string_view> table = [] {
        std::unordered_map<std::string_view, std::string_view> blocks;
        for (const Pair& pair : DEFAULTS) blocks.emplace(pair.node, pair.block);
        return blocks;
    }();
    const std::size_t colon = name.find(':');
    if (colon == name.npos) return std::nullopt;
    const std::string_view mod = name.substr(0, colon);
    std::string_view node = name.substr(colon + 1);
    if (mod == "default") {
        if (const auto found = table.find(node); found != table.end()) return std::string(found->second);
        for (const std::string_view grass : {"grass_", "dry_grass_", "fern_"})
            if (node.starts_with(grass) && node.size() == grass.size() + 1) return "short_grass";
        return std::string(node);
    }
    if (mod == "wool") {
        std::string color(node);
        if (color == "dark_grey") color = "gray";
        else if (color == "grey") color = "light_gray";
        else if (color == "violet") color = "purple";
        else if (color == "dark_green") color = "green";
        else if (color == "green") color = "lime";
        return color + "_wool";
    }
    if (mod == "flowers") {
        if (node == "dandelion_yellow") return "dandelion";
        if (node == "dandelion_white") return "white_tulip";
        if (node == "rose") return "poppy";
        if (node == "tulip") return "orange_tulip";
        if (node == "tulip_black") return "wither_rose";
        if (node == "geranium") return "cornflower";
        if (node == "viola") return "allium";
        if (node == "chrysanthemum_green") return "azure_bluet";
        if (node == "mushroom_red") return "red_mushroom";
        if (node == "mushroom_brown") return "brown_mushroom";
        if (node.starts_with("waterlily")) return "lily_pad";
    }
    if (mod == "stairs") {  // of a whole block of the default game
        for (const std::string_view kind : {"slab_", "stair_inner_", "stair_outer_", "stair_"}) {
            if (!node.starts_with(kind)) continue;
            std::string base = *luanti_node("default:" + std::string(node.substr(kind.size())));
            for (const std::string_view ending : {"_planks", "_block"})
                if (base.ends_with(ending)) base.resize(base.size() - ending.size());
            return base + (kind == "slab_" ? "_slab" : "_stairs");
        }
    }
    if (mod == "fire") return "fire";
    return std::nullopt;
}

}  // namespace spinel
