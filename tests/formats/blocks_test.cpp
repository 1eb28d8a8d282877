#include "formats/blocks.h"

#include <gtest/gtest.h>

#include "formats/block_colors.h"
#include "kernels/materials.h"
#include "scene/validate.h"

namespace spinel::blocks_test {
namespace {

TEST(Blocks, the_commonest_are_known_with_colors_of_their_own) {
    for (const char* name : {"stone",
                             "minecraft:grass_block[snowy=false]",
                             "oak_planks",
                             "stripped_dark_oak_wood",
                             "cherry_leaves",
                             "mangrove_propagule",
                             "warped_stem",
                             "crimson_hyphae",
                             "bamboo_mosaic_slab",
                             "light_gray_wool",
                             "cyan_concrete_powder",
                             "magenta_glazed_terracotta",
                             "lime_stained_glass_pane",
                             "deepslate_tile_stairs",
                             "waxed_weathered_cut_copper_slab",
                             "polished_blackstone_brick_wall",
                             "infested_cracked_stone_bricks",
                             "nether_brick_fence",
                             "red_nether_brick_stairs",
                             "end_stone_brick_wall",
                             "prismarine_brick_slab",
                             "mossy_cobblestone_wall",
                             "smooth_quartz_stairs",
                             "quartz_slab",
                             "purpur_stairs",
                             "brick_stairs",
                             "exposed_copper_bulb",
                             "raw_gold_block",
                             "deepslate_emerald_ore",
                             "potted_poppy",
                             "oak_wall_hanging_sign",
                             "dead_tube_coral_fan",
                             "white_wall_banner",
                             "black_bed",
                             "red_candle_cake",
                             "zombie_wall_head",
                             "tuff_brick_wall",
                             "pale_oak_door",
                             "resin_brick_slab",
                             "mud_brick_wall",
                             "andesite_stairs",
                             "polished_granite_slab",
                             "red_sandstone_wall",
                             "cut_sandstone_slab",
                             "smooth_stone_slab"}) {
        const Block block = block_of(name);
        EXPECT_TRUE(block.known) << name;
        EXPECT_TRUE(block.cube || !block.boxes.empty() || block.joint != Block::Joint::none) << name;
    }
}

TEST(Blocks, every_numeric_id_that_there_was_is_known) {
    int count = 0;
    for (int id = 0; id < 256; ++id)
        for (int data = 0; data < 16; ++data) {
            const std::string name = legacy_block(id, data);
            if (name.empty()) continue;
            EXPECT_TRUE(block_of(name).known) << id << ":" << data << " " << name;
            ++count;
        }
    EXPECT_GE(count, 253 * 16);
    EXPECT_EQ(legacy_block(1, 1), "granite");
    EXPECT_EQ(legacy_block(5, 2), "birch_planks");
    EXPECT_EQ(legacy_block(35, 14), "red_wool");
    EXPECT_EQ(legacy_block(44, 8), "smooth_stone_slab[type=top]");
    EXPECT_EQ(legacy_block(53, 6), "oak_stairs[facing=south,half=top]");
    EXPECT_EQ(legacy_block(50, 1), "wall_torch[facing=east]");
    EXPECT_EQ(legacy_block(64, 9), "air");  // the upper half of a door
    EXPECT_EQ(legacy_block(253, 0), "");
    EXPECT_EQ(legacy_block(4000, 0), "");
}

TEST(Blocks, what_is_not_known_is_guessed_from_its_name_and_always_the_same) {
    const Block block = block_of("create:brass_casing");
    EXPECT_FALSE(block.known);
    EXPECT_TRUE(block.cube);
    EXPECT_EQ(block_color("brass_casing").rgb, block_color("brass_casing").rgb);
    EXPECT_NE(block_color("brass_casing").rgb, block_color("zinc_casing").rgb);
    EXPECT_EQ(block_color("ebony_planks").rgb, block_color("oak_planks").rgb);
    EXPECT_EQ(block_color("red_gizmo").rgb, block_color("red_concrete").rgb);
    EXPECT_FALSE(block_of("othermod:stone").known);
    EXPECT_TRUE(block_of("minecraft:stone").known);
}

TEST(Blocks, clear_ones_are_dielectrics_that_absorb_and_lamps_emit) {
    for (const char* name : {"water", "glass", "ice", "blue_stained_glass", "glass_pane[north=true]", "slime_block"})
        EXPECT_EQ(block_of(name).material.kind, kernels::MATERIAL_DIELECTRIC) << name;
    EXPECT_FLOAT_EQ(block_of("water").material.ior, 1.333f);
    EXPECT_GT(block_of("glass").material.priority, block_of("water").material.priority);
    const auto blue = block_of("blue_stained_glass").material.absorption;
    EXPECT_GT(blue.x, blue.z);
    for (const char* name : {"lava", "glowstone", "torch", "wall_torch[facing=east]", "sea_lantern", "campfire",
                             "redstone_lamp[lit=true]", "lantern", "red_candle[lit=true]", "default:meselamp"})
        EXPECT_GT(block_of(name).material.emission.x, 0.0f) << name;
    for (const char* name : {"redstone_lamp[lit=false]", "redstone_lamp", "campfire[lit=false]", "stone", "red_candle"})
        EXPECT_EQ(block_of(name).material.emission.x, 0.0f) << name;
}

TEST(Blocks, shapes_are_boxes_of_the_cell) {
    EXPECT_TRUE(block_of("stone_slab[type=double]").cube);
    const Block top = block_of("stone_slab[type=top]");
    ASSERT_EQ(top.boxes.size(), 1u);
    EXPECT_EQ(top.boxes[0].lower.y, 0.5f);
    EXPECT_EQ(top.boxes[0].upper.y, 1.0f);
    const Block stairs = block_of("oak_stairs[facing=east,half=bottom,shape=straight]");
    ASSERT_EQ(stairs.boxes.size(), 2u);
    EXPECT_EQ(stairs.boxes[1].lower, glm::vec3(0.5f, 0.5f, 0));
    // Facing east its left is north.
    const Block corner = block_of("oak_stairs[facing=east,half=bottom,shape=outer_left]");
    EXPECT_EQ(corner.boxes[1].lower, glm::vec3(0.5f, 0.5f, 0));
    EXPECT_EQ(corner.boxes[1].upper, glm::vec3(1, 1, 0.5f));
    EXPECT_EQ(block_of("snow[layers=3]").boxes[0].upper.y, 6 / 16.0f);
    EXPECT_TRUE(block_of("snow[layers=8]").cube);
    EXPECT_EQ(block_of("oak_fence[east=true,north=false,south=false,west=true]").boxes.size(), 3u);
    EXPECT_EQ(block_of("glass_pane[east=true,north=false,south=false,west=true]").boxes.size(), 1u);
    EXPECT_EQ(block_of("oak_fence").joint, Block::Joint::fence);
    EXPECT_TRUE(block_of("oak_slab[type=top,waterlogged=true]").in_water);
    EXPECT_TRUE(block_of("kelp_plant").in_water);
    for (const char* name : {"air", "minecraft:cave_air", "redstone_wire[power=3]", "barrier", "ignore"}) {
        const Block block = block_of(name);
        EXPECT_FALSE(block.cube || !block.boxes.empty() || block.in_water) << name;
    }
    for (const char* name : {"oak_door[facing=north,half=lower,hinge=left,open=true]", "ladder[facing=west]",
                             "wall_torch[facing=south]", "stone_button[face=wall,facing=east]", "chest", "poppy"})
        for (const BlockBox& box : block_of(name).boxes)
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_GE(box.lower[axis], 0.0f) << name;
                EXPECT_LE(box.upper[axis], 1.0f) << name;
                EXPECT_LT(box.lower[axis], box.upper[axis]) << name;
            }
}

TEST(Blocks, joints_never_overlap) {
    for (const auto joint : {Block::Joint::fence, Block::Joint::wall, Block::Joint::pane})
        for (unsigned sides = 0; sides < 16; ++sides) {
            const std::vector<BlockBox> boxes = joined_boxes(joint, sides);
            for (std::size_t a = 0; a < boxes.size(); ++a)
                for (std::size_t b = a + 1; b < boxes.size(); ++b) {
                    const glm::vec3 lower = glm::max(boxes[a].lower, boxes[b].lower);
                    const glm::vec3 upper = glm::min(boxes[a].upper, boxes[b].upper);
                    EXPECT_FALSE(lower.x < upper.x && lower.y < upper.y && lower.z < upper.z) << sides;
                }
        }
}

TEST(Blocks, nodes_of_luanti_look_like_their_twins) {
    EXPECT_EQ(block_of("default:tree").material.color, block_of("oak_log").material.color);
    EXPECT_EQ(block_of("default:jungleleaves").material.color, block_of("jungle_leaves").material.color);
    EXPECT_EQ(block_of("default:dirt_with_grass").material.color, block_of("grass_block").material.color);
    EXPECT_EQ(block_of("default:water_source").material.kind, kernels::MATERIAL_DIELECTRIC);
    EXPECT_EQ(block_of("wool:dark_green").material.color, block_of("green_wool").material.color);
    EXPECT_EQ(block_of("stairs:slab_wood").boxes.size(), 1u);
    EXPECT_EQ(block_of("stairs:slab_wood").material.color, block_of("oak_planks").material.color);
    for (const char* name : {"default:apple", "default:snow", "default:stone_with_coal", "flowers:rose",
                             "stairs:stair_stonebrick", "default:pine_needles", "default:mese", "default:desert_stone"})
        EXPECT_TRUE(block_of(name).known) << name;
}

TEST(Blocks, every_material_is_valid) {
    Scene scene;
    for (int id = 0; id < 256; ++id)
        for (int data = 0; data < 16; ++data)
            scene.materials.push_back(
                {"m" + std::to_string(id * 16 + data), block_of(legacy_block(id, data)).material});
    const Result<void> valid = validate(scene);
    EXPECT_TRUE(valid) << valid.error().message;
}

}  // namespace
}  // namespace spinel::blocks_test
