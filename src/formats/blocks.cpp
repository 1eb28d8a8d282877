#include "formats/blocks.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "formats/block_colors.h"
#include "formats/luanti_nodes.h"
#include "image/tone_map.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel {
namespace {

using glm::vec3;
using Properties = std::map<std::string_view, std::string_view>;

// Radiance of what shines, as a factor to its colour. White in full sun under the sky of a bare model is about 1; a
// lamp is to be seen by day and to light a room by night.
struct Glow {
    std::string_view name;
    float factor;
};
constexpr Glow GLOWS[] = {
    {"lava", 6},           {"flowing_lava", 6},        {"glowstone", 8},      {"sea_lantern", 5},
    {"jack_o_lantern", 4}, {"shroomlight", 6},         {"beacon", 6},         {"ochre_froglight", 5},
    {"magma_block", 0.6f}, {"verdant_froglight", 5},   {"conduit", 4},        {"pearlescent_froglight", 5},
    {"fire", 8},           {"soul_fire", 4},           {"torch", 20},         {"wall_torch", 20},
    {"soul_torch", 10},    {"soul_wall_torch", 10},    {"copper_torch", 12},  {"copper_wall_torch", 12},
    {"redstone_torch", 3}, {"redstone_wall_torch", 3}, {"lantern", 12},       {"soul_lantern", 6},
    {"end_rod", 10},       {"nether_portal", 2},       {"end_portal", 1},     {"end_gateway", 1},
    {"meselamp", 6},       {"lava_cauldron", 1},       {"glow_lichen", 0.5f}, {"sea_pickle", 0.5f},
    {"campfire", 3},       {"soul_campfire", 2},       {"redstone_lamp", 8},  {"copper_bulb", 6},
};
// Of those only when `lit`, which the state tells (campfires burn unless it says otherwise).
constexpr std::string_view SWITCHED[] = {"redstone_lamp", "copper_bulb", "campfire", "soul_campfire"};

constexpr std::string_view NOTHING[] = {"air",      "cave_air",      "void_air",      "barrier",    "structure_void",
                                        "light",    "tripwire",      "tripwire_hook", "string",     "ignore",
                                        "vacuum",   "redstone_wire", "lever",         "item_frame", "glow_item_frame",
                                        "painting", "end_gateway",   "sculk_vein",    "frogspawn",  "resin_clump"};

constexpr std::string_view PLANTS[] = {"short_grass",
                                       "grass",
                                       "tall_grass",
                                       "fern",
                                       "large_fern",
                                       "dead_bush",
                                       "dandelion",
                                       "poppy",
                                       "blue_orchid",
                                       "allium",
                                       "azure_bluet",
                                       "red_tulip",
                                       "orange_tulip",
                                       "white_tulip",
                                       "pink_tulip",
                                       "oxeye_daisy",
                                       "cornflower",
                                       "lily_of_the_valley",
                                       "wither_rose",
                                       "torchflower",
                                       "sunflower",
                                       "lilac",
                                       "rose_bush",
                                       "peony",
                                       "brown_mushroom",
                                       "red_mushroom",
                                       "wheat",
                                       "carrots",
                                       "potatoes",
                                       "beetroots",
                                       "melon_stem",
                                       "pumpkin_stem",
                                       "attached_melon_stem",
                                       "attached_pumpkin_stem",
                                       "sweet_berry_bush",
                                       "nether_wart",
                                       "bamboo_sapling",
                                       "spore_blossom",
                                       "cave_vines",
                                       "cave_vines_plant",
                                       "small_dripleaf",
                                       "hanging_roots",
                                       "pale_hanging_moss",
                                       "crimson_fungus",
                                       "warped_fungus",
                                       "crimson_roots",
                                       "warped_roots",
                                       "nether_sprouts",
                                       "weeping_vines",
                                       "weeping_vines_plant",
                                       "twisting_vines",
                                       "twisting_vines_plant",
                                       "sugar_cane",
                                       "cobweb",
                                       "tube_coral",
                                       "brain_coral",
                                       "bubble_coral",
                                       "fire_coral",
                                       "horn_coral",
                                       "bush",
                                       "firefly_bush",
                                       "closed_eyeblossom",
                                       "open_eyeblossom",
                                       "cactus_flower",
                                       "pitcher_plant",
                                       "pitcher_crop",
                                       "torchflower_crop",
                                       "short_dry_grass",
                                       "tall_dry_grass"};

// Plants that stand in water always, and are not seen for it.
constexpr std::string_view WATER_PLANTS[] = {"kelp", "kelp_plant", "seagrass", "tall_seagrass", "bubble_column"};

// A layer on the floor, in 1/16 of a block.
struct Layer {
    std::string_view name;
    float height;
};
constexpr Layer LAYERS[] = {{"rail", 1},
                            {"powered_rail", 1},
                            {"detector_rail", 1},
                            {"activator_rail", 1},
                            {"lily_pad", 1},
                            {"repeater", 2},
                            {"comparator", 2},
                            {"daylight_detector", 6},
                            {"enchanting_table", 12},
                            {"cake", 8},
                            {"leaf_litter", 1},
                            {"pink_petals", 2},
                            {"wildflowers", 2},
                            {"stonecutter", 9},
                            {"end_portal_frame", 13},
                            {"glow_lichen", 1},
                            {"campfire", 7},
                            {"soul_campfire", 7},
                            {"sculk_sensor", 8},
                            {"calibrated_sculk_sensor", 8},
                            {"sculk_shrieker", 8}};

// Boxes about the middle of the cell, in 1/16: how far from the sides, and from where to where in height.
struct Inset {
    std::string_view name;
    float side, bottom, top;
};
constexpr Inset INSETS[] = {{"torch", 7, 0, 10},
                            {"soul_torch", 7, 0, 10},
                            {"redstone_torch", 7, 0, 10},
                            {"copper_torch", 7, 0, 10},
                            {"end_rod", 7, 0, 16},
                            {"chain", 7, 0, 16},
                            {"iron_chain", 7, 0, 16},
                            {"lightning_rod", 7, 0, 16},
                            {"candle", 7, 0, 6},
                            {"flower_pot", 5, 0, 6},
                            {"chest", 1, 0, 14},
                            {"trapped_chest", 1, 0, 14},
                            {"ender_chest", 1, 0, 14},
                            {"cactus", 1, 0, 16},
                            {"bamboo", 6.5f, 0, 16},
                            {"brewing_stand", 5, 0, 14},
                            {"anvil", 2, 0, 16},
                            {"chipped_anvil", 2, 0, 16},
                            {"damaged_anvil", 2, 0, 16},
                            {"bell", 4, 3, 13},
                            {"hopper", 2, 4, 16},
                            {"lectern", 2, 0, 15},
                            {"grindstone", 3, 2, 16},
                            {"decorated_pot", 1, 0, 16},
                            {"dragon_egg", 1, 0, 16},
                            {"turtle_egg", 4, 0, 7},
                            {"sniffer_egg", 1, 0, 16},
                            {"sea_pickle", 5, 0, 6},
                            {"conduit", 5, 5, 11},
                            {"chorus_plant", 3, 0, 16},
                            {"cocoa", 5, 4, 12},
                            {"pointed_dripstone", 5, 0, 16},
                            {"apple", 5, 7, 13},
                            {"heavy_core", 4, 0, 8},
                            {"big_dripleaf", 0, 11, 15},
                            {"small_amethyst_bud", 6, 0, 4},
                            {"medium_amethyst_bud", 5, 0, 6},
                            {"large_amethyst_bud", 4, 0, 8},
                            {"amethyst_cluster", 4, 0, 10},
                            {"scaffolding", 0, 14, 16}};

template <std::size_t n>
bool is_one_of(std::string_view name, const std::string_view (&list)[n]) {
    return std::find(std::begin(list), std::end(list), name) != std::end(list);
}

template <class Row, std::size_t n>
const Row* row_of(std::string_view name, const Row (&table)[n]) {
    for (const Row& row : table)
        if (row.name == name) return &row;
    return nullptr;
}

std::string_view value_of(const Properties& properties, std::string_view key) {
    const auto found = properties.find(key);
    return found == properties.end() ? std::string_view() : found->second;
}

BlockBox sixteenths(float x0, float y0, float z0, float x1, float y1, float z1) {
    return {vec3(x0, y0, z0) / 16.0f, vec3(x1, y1, z1) / 16.0f};
}

// A plate upright at the wall that something faces away from.
BlockBox plate(std::string_view facing, float thickness, float bottom = 0, float top = 16) {
    if (facing == "east") return sixteenths(0, bottom, 0, thickness, top, 16);
    if (facing == "west") return sixteenths(16 - thickness, bottom, 0, 16, top, 16);
    if (facing == "south") return sixteenths(0, bottom, 0, 16, top, thickness);
    return sixteenths(0, bottom, 16 - thickness, 16, top, 16);
}

BlockBox half_towards(std::string_view facing, float bottom, float top) {
    if (facing == "east") return sixteenths(8, bottom, 0, 16, top, 16);
    if (facing == "west") return sixteenths(0, bottom, 0, 8, top, 16);
    if (facing == "south") return sixteenths(0, bottom, 8, 16, top, 16);
    return sixteenths(0, bottom, 0, 16, top, 8);
}

// Where a leaf of a door that faces `facing` stands when it is open.
std::string_view opened(std::string_view facing, bool hinge_right) {
    constexpr std::string_view turn[4] = {"north", "east", "south", "west"};
    const std::size_t at = std::size_t(std::find(turn, turn + 4, facing) - turn) % 4;
    return turn[(at + (hinge_right ? 3 : 1)) % 4];
}

BlockBox door(const Properties& properties, float bottom, float top) {
    const std::string_view facing = value_of(properties, "facing");
    if (value_of(properties, "open") != "true") return plate(facing, 3, bottom, top);
    return plate(opened(facing, value_of(properties, "hinge") == "right"), 3, bottom, top);
}

std::vector<BlockBox> stairs(const Properties& properties) {
    const bool top = value_of(properties, "half") == "top";
    const float low = top ? 0.0f : 8.0f;  // of the step
    std::vector<BlockBox> boxes = {top ? sixteenths(0, 8, 0, 16, 16, 16) : sixteenths(0, 0, 0, 16, 8, 16)};
    const std::string_view facing = value_of(properties, "facing"), shape = value_of(properties, "shape");
    BlockBox step = half_towards(facing, low, low + 8);
    // A corner turns to the left or right of where the stairs face: the outer ones keep a quarter of the cell, the
    // inner ones add one.
    if (shape.starts_with("outer") || shape.starts_with("inner")) {
        const std::string_view side = opened(facing, shape.ends_with("left"));
        const BlockBox beside = half_towards(side, low, low + 8);
        if (shape.starts_with("outer")) step = {glm::max(step.lower, beside.lower), glm::min(step.upper, beside.upper)};
        else {
            const BlockBox behind = half_towards(opened(opened(facing, true), true), low, low + 8);
            boxes.push_back({glm::max(behind.lower, beside.lower), glm::min(behind.upper, beside.upper)});
        }
    }
    boxes.push_back(step);
    return boxes;
}

std::vector<BlockBox> plant_boxes(bool low) {
    const float top = low ? 7.0f : 13.0f;
    return {sixteenths(3, 0, 7.5f, 13, top, 8.5f), sixteenths(7.5f, 0, 3, 8.5f, top, 13)};
}

unsigned told_sides(const Properties& properties) {
    const auto joins = [&](std::string_view side) {
        const std::string_view value = value_of(properties, side);
        return value == "true" || value == "low" || value == "tall";
    };
    return (joins("north") ? JOINS_NORTH : 0) | (joins("south") ? JOINS_SOUTH : 0) | (joins("west") ? JOINS_WEST : 0) |
           (joins("east") ? JOINS_EAST : 0);
}

// Fills in what the block occupies.
void shape_block(std::string_view name, const Properties& properties, Block& block) {
    const auto ends = [&](std::string_view suffix) { return name.ends_with(suffix); };
    const auto value = [&](std::string_view key) { return value_of(properties, key); };
    std::vector<BlockBox>& boxes = block.boxes;
    if (is_one_of(name, NOTHING)) return;
    if (is_one_of(name, WATER_PLANTS)) {
        block.in_water = true;
        return;
    }
    block.in_water = value("waterlogged") == "true";

    if (ends("_slab") && value("type") != "double") {
        const float low = value("type") == "top" ? 8.0f : 0.0f;
        boxes = {sixteenths(0, low, 0, 16, low + 8, 16)};
    } else if (ends("_stairs")) {
        boxes = stairs(properties);
    } else if (name == "snow" && value("layers") != "8") {
        const std::string_view layers = value("layers");
        boxes = {sixteenths(0, 0, 0, 16, layers.size() == 1 ? 2.0f * float(layers[0] - '0') : 2.0f, 16)};
    } else if (ends("_carpet")) {
        boxes = {sixteenths(0, 0, 0, 16, 1, 16)};
    } else if (ends("_pressure_plate")) {
        boxes = {sixteenths(1, 0, 1, 15, 1, 15)};
    } else if (ends("_bed")) {
        boxes = {sixteenths(0, 3, 0, 16, 9, 16)};
    } else if (ends("_fence_gate")) {
        const bool along_x = value("facing") == "north" || value("facing") == "south";
        if (value("open") != "true")
            boxes = {along_x ? sixteenths(0, 5, 7, 16, 16, 9) : sixteenths(7, 5, 0, 9, 16, 16)};
        else if (along_x) boxes = {sixteenths(0, 5, 0, 2, 16, 9), sixteenths(14, 5, 0, 16, 16, 9)};
        else boxes = {sixteenths(0, 5, 0, 9, 16, 2), sixteenths(0, 5, 14, 9, 16, 16)};
    } else if (ends("_fence") || ends("_wall") || ends("_pane") || ends("_bars")) {
        const auto joint = ends("_fence")  ? Block::Joint::fence
                           : ends("_wall") ? Block::Joint::wall
                                           : Block::Joint::pane;
        if (properties.count("north")) boxes = joined_boxes(joint, told_sides(properties));
        else block.joint = joint;
    } else if (ends("_trapdoor")) {
        if (value("open") == "true") boxes = {plate(value("facing"), 3)};
        else boxes = {value("half") == "top" ? sixteenths(0, 13, 0, 16, 16, 16) : sixteenths(0, 0, 0, 16, 3, 16)};
    } else if (ends("_door")) {
        // Files of numeric ids tell where a door stands in its lower half only, which is then as high as both.
        boxes = {door(properties, 0, value("half") == "both" ? 32.0f : 16.0f)};
    } else if (name == "ladder" || ends("_wall_fan")) {
        boxes = {plate(value("facing"), 1)};
    } else if (name == "vine") {
        for (const std::string_view side : {"north", "south", "west", "east"}) {
            constexpr std::pair<std::string_view, std::string_view> away[] = {
                {"north", "south"}, {"south", "north"}, {"west", "east"}, {"east", "west"}};
            if (value(side) != "true") continue;
            for (const auto& [from, to] : away)
                if (from == side) boxes.push_back(plate(to, 1));
        }
    } else if (ends("_wall_sign") || ends("_wall_banner")) {
        boxes = {plate(value("facing"), 2, ends("_banner") ? 0.0f : 4.5f, ends("_banner") ? 14.0f : 12.5f)};
    } else if (ends("_hanging_sign")) {
        boxes = {sixteenths(1, 0, 7, 15, 10, 9)};
    } else if (ends("_sign") || ends("_banner")) {
        boxes = {sixteenths(7, 0, 7, 9, 8, 9), sixteenths(0, 8, 7, 16, 16, 9)};
    } else if (ends("wall_torch")) {
        // Leans from the wall behind it.
        const BlockBox wall = plate(value("facing"), 5);
        const vec3 middle = 0.5f * (wall.lower + wall.upper);
        boxes = {{vec3(middle.x, 0, middle.z) + vec3(-1, 3, -1) / 16.0f,
                  vec3(middle.x, 0, middle.z) + vec3(1, 13, 1) / 16.0f}};
    } else if (name == "lantern" || (ends("_lantern") && name != "sea_lantern" && name != "jack_o_lantern")) {
        boxes = {sixteenths(5, 1, 5, 11, 9, 11)};
    } else if (ends("_candle")) {
        boxes = {sixteenths(7, 0, 7, 9, 6, 9)};
    } else if (ends("_button")) {
        if (value("face") == "floor") boxes = {sixteenths(5, 0, 6, 11, 2, 10)};
        else if (value("face") == "ceiling") boxes = {sixteenths(5, 14, 6, 11, 16, 10)};
        else {
            const BlockBox wall = plate(value("facing"), 2, 6, 10);
            const bool along_x = wall.upper.x - wall.lower.x > 0.5f;
            boxes = {along_x
                         ? BlockBox{{5 / 16.0f, wall.lower.y, wall.lower.z}, {11 / 16.0f, wall.upper.y, wall.upper.z}}
                         : BlockBox{{wall.lower.x, wall.lower.y, 5 / 16.0f}, {wall.upper.x, wall.upper.y, 11 / 16.0f}}};
        }
    } else if (ends("_head") || ends("_skull")) {
        if (name == "piston_head") block.cube = true;
        else boxes = {sixteenths(4, 0, 4, 12, 8, 12)};
    } else if (ends("_sapling") || ends("_propagule") || is_one_of(name, PLANTS) || ends("_fan") || ends("_coral")) {
        boxes = plant_boxes(name == "short_grass" || name == "grass" || ends("_mushroom") || ends("_fan"));
    } else if (name.starts_with("potted_")) {
        boxes = {sixteenths(5, 0, 5, 11, 6, 11)};
    } else if (name == "fire" || name == "soul_fire") {
        boxes = plant_boxes(false);
    } else if (name == "nether_portal") {
        boxes = {value("axis") == "z" ? sixteenths(6, 0, 0, 10, 16, 16) : sixteenths(0, 0, 6, 16, 16, 10)};
    } else if (const Layer* layer = row_of(name, LAYERS)) {
        boxes = {sixteenths(0, 0, 0, 16, layer->height, 16)};
    } else if (const Inset* inset = row_of(name, INSETS)) {
        boxes = {sixteenths(inset->side, inset->bottom, inset->side, 16 - inset->side, inset->top, 16 - inset->side)};
    } else {
        block.cube = true;
    }
}

vec3 linear_color(std::uint32_t rgb) {
    vec3 color;
    for (int c = 0; c < 3; ++c) color[c] = srgb_decoded(float(rgb >> (16 - 8 * c) & 255) / 255.0f);
    return color;
}

// A dielectric through one block of which white light takes on the colour, to the power of `strength`.
kernels::Material clear(float ior, int priority, vec3 color, float strength) {
    kernels::Material material = default_material(kernels::MATERIAL_DIELECTRIC);
    material.ior = ior;
    material.priority = priority;
    material.absorption = -glm::log(glm::clamp(color, vec3(0.01f), vec3(1.0f))) * strength;
    return material;
}

// Priorities decide where the boxes of panes stand in water or against glass.
kernels::Material look_of(std::string_view name, const Properties& properties, vec3 color) {
    if (name == "water" || name == "flowing_water" || is_one_of(name, WATER_PLANTS))
        return clear(1.333f, 0, color, 0.05f);
    if (name == "ice" || name == "frosted_ice") return clear(1.31f, 1, color, 0.35f);
    if (name == "slime_block") return clear(1.4f, 1, color, 1.0f);
    if (name == "honey_block") return clear(1.5f, 1, color, 1.0f);
    if (name == "glass" || name == "glass_pane" || name.ends_with("clear_glass")) return clear(1.5f, 2, color, 0.1f);
    if (name == "tinted_glass") return clear(1.5f, 2, color, 1.0f);
    if (name.ends_with("glass")) return clear(1.5f, 2, color, 0.7f);
    if (name.ends_with("glass_pane")) return clear(1.5f, 2, color, 5.0f);  // an eighth of a block thick
    kernels::Material material = default_material(kernels::MATERIAL_DIFFUSE);
    material.color = color;
    const bool off = value_of(properties, "lit") == "false";
    const bool on = value_of(properties, "lit") == "true";
    if (const Glow* glow = row_of(name, GLOWS); glow && !off) {
        const bool burns = name.ends_with("campfire");
        if (on || burns || !is_one_of(name, SWITCHED)) material.emission = color * glow->factor;
    } else if (on && name.ends_with("candle")) {
        material.emission = color * 10.0f;
    } else if (on && name.ends_with("copper_bulb")) {
        material.emission = vec3(6.0f, 4.2f, 2.4f);
    }
    return material;
}

Properties properties_of(std::string_view text) {
    Properties properties;
    while (!text.empty()) {
        const std::string_view pair = text.substr(0, text.find(','));
        text.remove_prefix(std::min(text.size(), pair.size() + 1));
        if (const std::size_t equals = pair.find('='); equals != pair.npos)
            properties[pair.substr(0, equals)] = pair.substr(equals + 1);
    }
    return properties;
}

}  // namespace

std::vector<BlockBox> joined_boxes(Block::Joint joint, unsigned sides) {
    struct Measures {
        float post, arm, bottom, top;  // half widths and the arm's height, 1/16
    };
    const Measures m = joint == Block::Joint::fence  ? Measures{2, 1, 6, 15}
                       : joint == Block::Joint::wall ? Measures{4, 3, 0, 14}
                                                     : Measures{1, 1, 0, 16};
    std::vector<BlockBox> boxes;
    const bool along_z = (sides & JOINS_NORTH) && (sides & JOINS_SOUTH);
    const bool along_x = (sides & JOINS_WEST) && (sides & JOINS_EAST);
    // Straight lines are one box, so that panes have no seams in the middle.
    if (along_z && joint != Block::Joint::fence)
        boxes.push_back(sixteenths(8 - m.arm, m.bottom, 0, 8 + m.arm, m.top, 16));
    if (along_x && joint != Block::Joint::fence && !along_z)
        boxes.push_back(sixteenths(0, m.bottom, 8 - m.arm, 16, m.top, 8 + m.arm));
    const bool straight = !boxes.empty();
    if (!straight) boxes.push_back(sixteenths(8 - m.post, 0, 8 - m.post, 8 + m.post, 16, 8 + m.post));
    const float inner = straight ? m.arm : m.post;
    if ((sides & JOINS_NORTH) && !(straight && along_z))
        boxes.push_back(sixteenths(8 - m.arm, m.bottom, 0, 8 + m.arm, m.top, 8 - inner));
    if ((sides & JOINS_SOUTH) && !(straight && along_z))
        boxes.push_back(sixteenths(8 - m.arm, m.bottom, 8 + inner, 8 + m.arm, m.top, 16));
    if ((sides & JOINS_WEST) && (along_z || !(straight && along_x)))
        boxes.push_back(sixteenths(0, m.bottom, 8 - m.arm, 8 - inner, m.top, 8 + m.arm));
    if ((sides & JOINS_EAST) && (along_z || !(straight && along_x)))
        boxes.push_back(sixteenths(8 + inner, m.bottom, 8 - m.arm, 16, m.top, 8 + m.arm));
    return boxes;
}

Block block_of(std::string_view state) {
    const std::size_t bracket = state.find('[');
    std::string_view full = state.substr(0, bracket);
    std::string_view inside = bracket == state.npos ? std::string_view() : state.substr(bracket + 1);
    if (!inside.empty() && inside.back() == ']') inside.remove_suffix(1);

    Block block;
    block.name = std::string(full);
    // Luanti's nodes are told in the words of the other game.
    const std::optional<std::string> translated = luanti_node(full);
    std::string_view name = translated ? std::string_view(*translated) : full;
    if (const std::size_t inner = name.find('['); inner != name.npos) {
        inside = name.substr(inner + 1, name.size() - inner - 2);
        name = name.substr(0, inner);
    }
    const bool foreign = !translated && name.find(':') != name.npos && !name.starts_with("minecraft:");
    if (const std::size_t colon = name.rfind(':'); colon != name.npos) name.remove_prefix(colon + 1);

    const Properties properties = properties_of(inside);
    shape_block(name, properties, block);
    const BlockColor color = block_color(name);
    const bool seen = block.cube || !block.boxes.empty() || block.joint != Block::Joint::none;
    block.known = !seen || (color.known && !foreign);
    vec3 linear = linear_color(color.rgb);
    if (name == "grass_block" && value_of(properties, "snowy") == "true") linear = linear_color(0xf0f5f5);
    block.material = look_of(name, properties, linear);
    return block;
}

}  // namespace spinel
