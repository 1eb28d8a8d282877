#include "formats/block_colors.h"

#include <string>
#include <unordered_map>

namespace spinel {
namespace {

struct Named {
    std::string_view name;
    std::uint32_t rgb;
};

// What comes in sixteen colours.
struct Dye {
    std::string_view name;
    std::uint32_t wool, concrete, powder, terracotta, glazed, dye;
};
constexpr Dye DYES[] = {
    {"white", 0xe9ecec, 0xcfd5d6, 0xe1e3e3, 0xd1b2a1, 0xbcd4ca, 0xf9fffe},
    {"orange", 0xf07613, 0xe06100, 0xe3831f, 0xa15325, 0x9a935b, 0xf9801d},
    {"magenta", 0xbd44b3, 0xa9309f, 0xc053b8, 0x95586c, 0xd064bf, 0xc74ebd},
    {"light_blue", 0x3aafd9, 0x2389c6, 0x4ab4d5, 0x716c89, 0x5ea4d0, 0x3ab3da},
    {"yellow", 0xf8c527, 0xf0af15, 0xe8c736, 0xba8523, 0xeac058, 0xfed83d},
    {"lime", 0x70b919, 0x5ea818, 0x7dbd29, 0x677534, 0xa2c537, 0x80c71f},
    {"pink", 0xed8dac, 0xd5658e, 0xe499b5, 0xa14e4e, 0xeb9ab5, 0xf38baa},
    {"gray", 0x3e4447, 0x36393d, 0x4c5154, 0x392a23, 0x535a5d, 0x474f52},
    {"light_gray", 0x8e8e86, 0x7d7d73, 0x9a9a94, 0x876a61, 0x90a6a7, 0x9d9d97},
    {"cyan", 0x158991, 0x157788, 0x24939d, 0x565b5b, 0x34767d, 0x169c9c},
    {"purple", 0x792aac, 0x641f9c, 0x8337b1, 0x764656, 0x6d3098, 0x8932b8},
    {"blue", 0x35399d, 0x2c2e8f, 0x4649a6, 0x4a3b5b, 0x2f408b, 0x3c44aa},
    {"brown", 0x724728, 0x603b1f, 0x7d5435, 0x4d3323, 0x776a55, 0x835432},
    {"green", 0x546d1b, 0x495b24, 0x61772c, 0x4c532a, 0x758e43, 0x5e7c16},
    {"red", 0xa12722, 0x8e2020, 0xa83632, 0x8f3d2e, 0xb53b35, 0xb02e26},
    {"black", 0x141519, 0x080a0f, 0x191a1f, 0x251610, 0x431e20, 0x1d1d21},
};

// What comes of every wood. The bark of nether stems and the culm of bamboo stand for logs.
struct Wood {
    std::string_view name;
    std::uint32_t planks, bark, stripped, leaves, door;
};
constexpr Wood WOODS[] = {
    {"oak", 0xa2834f, 0x6d5533, 0xb19056, 0x4a7a2c, 0x8c6e41},
    {"spruce", 0x735531, 0x3a2510, 0x745a34, 0x3c5b3c, 0x6a5030},
    {"birch", 0xc0af79, 0xd9d7d2, 0xc5b076, 0x5d7a3d, 0xdcd3b3},
    {"jungle", 0xa07351, 0x554419, 0xab8455, 0x3f7a1c, 0xa37755},
    {"acacia", 0xa85a32, 0x676157, 0xaf5d3c, 0x5b7a28, 0xa55e3b},
    {"dark_oak", 0x432b14, 0x3c2f1a, 0x60502f, 0x3f6b24, 0x4c3218},
    {"mangrove", 0x763631, 0x544329, 0x77362f, 0x4e7a27, 0x712f2d},
    {"cherry", 0xe3b3ad, 0x37212c, 0xd79195, 0xe5adc2, 0xdfa9a3},
    {"pale_oak", 0xe4dad8, 0x585451, 0xf6eeed, 0x737a73, 0xdfd5d3},
    {"bamboo", 0xc1ad50, 0x7f903a, 0xc1b24f, 0x5f8b2d, 0xbfab54},
    {"crimson", 0x653147, 0x5d1a1e, 0x8a395a, 0x770606, 0x723750},
    {"warped", 0x2b6963, 0x3a3b4e, 0x3a9795, 0x177879, 0x2d7f7a},
};

constexpr Named BLOCKS[] = {
    // Stone and what is made of it.
    {"stone", 0x7e7e7e},
    {"cobblestone", 0x807f80},
    {"mossy_cobblestone", 0x6e775f},
    {"smooth_stone", 0x9f9f9f},
    {"stone_bricks", 0x7b7a7b},
    {"mossy_stone_bricks", 0x737969},
    {"cracked_stone_bricks", 0x767576},
    {"chiseled_stone_bricks", 0x787778},
    {"granite", 0x956756},
    {"polished_granite", 0x9a6b59},
    {"diorite", 0xbdbcbd},
    {"polished_diorite", 0xc1c1c3},
    {"andesite", 0x888889},
    {"polished_andesite", 0x848787},
    {"bedrock", 0x555555},
    {"deepslate", 0x505053},
    {"cobbled_deepslate", 0x4d4d51},
    {"polished_deepslate", 0x484849},
    {"deepslate_bricks", 0x474747},
    {"deepslate_tiles", 0x373738},
    {"chiseled_deepslate", 0x363637},
    {"reinforced_deepslate", 0x666d64},
    {"tuff", 0x6c6d67},
    {"polished_tuff", 0x616864},
    {"tuff_bricks", 0x62675f},
    {"chiseled_tuff", 0x59605a},
    {"calcite", 0xdfe0dd},
    {"dripstone_block", 0x866c5d},
    {"pointed_dripstone", 0x81685b},
    {"bricks", 0x976253},
    {"obsidian", 0x0f0b19},
    {"crying_obsidian", 0x200a3c},
    {"sandstone", 0xd8cb9c},
    {"smooth_sandstone", 0xe0d6aa},
    {"cut_sandstone", 0xdacf9f},
    {"chiseled_sandstone", 0xd8ca9a},
    {"red_sandstone", 0xbb631d},
    {"smooth_red_sandstone", 0xb5621f},
    {"cut_red_sandstone", 0xbd6520},
    {"chiseled_red_sandstone", 0xb76019},
    {"prismarine", 0x639c97},
    {"prismarine_bricks", 0x63ac9f},
    {"dark_prismarine", 0x345c4c},
    {"sea_lantern", 0xacc8be},
    {"quartz_block", 0xece6df},
    {"quartz_pillar", 0xece7df},
    {"smooth_quartz", 0xece6df},
    {"chiseled_quartz_block", 0xe8e3d9},
    {"quartz_bricks", 0xeae5dd},
    {"end_stone", 0xdcdf9e},
    {"end_stone_bricks", 0xdae0a2},
    {"purpur_block", 0xaa7eaa},
    {"purpur_pillar", 0xac80ab},
    {"netherrack", 0x622626},
    {"nether_bricks", 0x2c161a},
    {"red_nether_bricks", 0x460709},
    {"cracked_nether_bricks", 0x281417},
    {"chiseled_nether_bricks", 0x2f181c},
    {"nether_wart_block", 0x730302},
    {"warped_wart_block", 0x177879},
    {"basalt", 0x505156},
    {"polished_basalt", 0x646465},
    {"smooth_basalt", 0x48484e},
    {"blackstone", 0x2a2429},
    {"polished_blackstone", 0x353139},
    {"polished_blackstone_bricks", 0x302b32},
    {"chiseled_polished_blackstone", 0x363239},
    {"cracked_polished_blackstone_bricks", 0x2c262b},
    {"gilded_blackstone", 0x382b26},
    {"soul_sand", 0x513e33},
    {"soul_soil", 0x4b3a2f},
    {"magma_block", 0x8e3f20},
    {"glowstone", 0xab8354},
    {"shroomlight", 0xf09346},
    {"amethyst_block", 0x8662bf},
    {"budding_amethyst", 0x8460ba},
    {"sculk", 0x0d1e24},
    {"sculk_catalyst", 0x0f2026},
    {"sculk_shrieker", 0xc7cda9},
    {"sculk_sensor", 0x074654},
    {"resin_block", 0xd9641a},
    {"resin_bricks", 0xce581b},
    {"bone_block", 0xe5e2d0},
    // Earth and plants.
    {"grass_block", 0x7fa84f},
    {"dirt", 0x866043},
    {"coarse_dirt", 0x77553b},
    {"rooted_dirt", 0x906850},
    {"podzol", 0x5b3f18},
    {"mycelium", 0x6f6365},
    {"dirt_path", 0x947a41},
    {"farmland", 0x8f6747},
    {"mud", 0x3c393d},
    {"packed_mud", 0x8e6b50},
    {"mud_bricks", 0x89684f},
    {"muddy_mangrove_roots", 0x463b2d},
    {"mangrove_roots", 0x4b3c26},
    {"sand", 0xdbcfa3},
    {"red_sand", 0xbe6621},
    {"suspicious_sand", 0xd9cd9e},
    {"gravel", 0x847f7f},
    {"suspicious_gravel", 0x817c7b},
    {"clay", 0xa1a6b3},
    {"terracotta", 0x985e44},
    {"snow", 0xf9fefe},
    {"snow_block", 0xf9fefe},
    {"powder_snow", 0xf8fdfd},
    {"ice", 0x91b7fd},
    {"frosted_ice", 0x8cb5fc},
    {"packed_ice", 0x8db4fa},
    {"blue_ice", 0x74a8fd},
    {"moss_block", 0x596e2d},
    {"moss_carpet", 0x596e2d},
    {"pale_moss_block", 0x6b7069},
    {"pale_moss_carpet", 0x6b7069},
    {"crimson_nylium", 0x831f1f},
    {"warped_nylium", 0x2b7265},
    {"water", 0x3f76e4},
    {"flowing_water", 0x3f76e4},
    {"bubble_column", 0x3f76e4},
    {"lava", 0xd45a12},
    {"flowing_lava", 0xd45a12},
    {"fire", 0xd4913b},
    {"soul_fire", 0x33c1c5},
    {"short_grass", 0x6f9a45},
    {"grass", 0x6f9a45},
    {"tall_grass", 0x6f9a45},
    {"fern", 0x5f8c3b},
    {"large_fern", 0x5f8c3b},
    {"dead_bush", 0x6b4f29},
    {"vine", 0x4c6e25},
    {"glow_lichen", 0x70837a},
    {"lily_pad", 0x207f2c},
    {"sugar_cane", 0x86b257},
    {"cactus", 0x558134},
    {"kelp", 0x578c2d},
    {"kelp_plant", 0x57822b},
    {"seagrass", 0x337f08},
    {"tall_seagrass", 0x3b8b0e},
    {"sea_pickle", 0x5a6128},
    {"dried_kelp_block", 0x323b26},
    {"dandelion", 0xc9b42a},
    {"poppy", 0xb8271a},
    {"blue_orchid", 0x2fa2a8},
    {"allium", 0x9f78b9},
    {"azure_bluet", 0xa9c98a},
    {"red_tulip", 0x9c3b18},
    {"orange_tulip", 0xc77b2b},
    {"white_tulip", 0xb6c5b0},
    {"pink_tulip", 0xb8a3a3},
    {"oxeye_daisy", 0xc9ccb3},
    {"cornflower", 0x466ad0},
    {"lily_of_the_valley", 0xb4c9a8},
    {"wither_rose", 0x292d17},
    {"torchflower", 0xc26b2d},
    {"sunflower", 0xd3a32c},
    {"lilac", 0xa6849f},
    {"rose_bush", 0x8d3b22},
    {"peony", 0xb68fae},
    {"pink_petals", 0xf2b5d4},
    {"wildflowers", 0xe5d34a},
    {"leaf_litter", 0x8d6a3d},
    {"bush", 0x6f9a45},
    {"firefly_bush", 0x5d6b34},
    {"brown_mushroom", 0x9a745c},
    {"red_mushroom", 0xc8271d},
    {"brown_mushroom_block", 0x957051},
    {"red_mushroom_block", 0xc82f2d},
    {"mushroom_stem", 0xcbc4b9},
    {"wheat", 0xa7964a},
    {"carrots", 0x3f8a2a},
    {"potatoes", 0x4f8a3a},
    {"beetroots", 0x4f7a35},
    {"melon_stem", 0x8b9a3a},
    {"pumpkin_stem", 0x8b9a3a},
    {"attached_melon_stem", 0x8b9a3a},
    {"attached_pumpkin_stem", 0x8b9a3a},
    {"sweet_berry_bush", 0x35603d},
    {"cocoa", 0x96622e},
    {"nether_wart", 0x761512},
    {"pumpkin", 0xc67718},
    {"carved_pumpkin", 0xb5700f},
    {"jack_o_lantern", 0xd79835},
    {"melon", 0x6f9a1e},
    {"hay_block", 0xa68c0d},
    {"bamboo", 0x5d9013},
    {"bamboo_sapling", 0x5d7815},
    {"azalea", 0x667d30},
    {"flowering_azalea", 0x707a40},
    {"azalea_leaves", 0x5a732c},
    {"flowering_azalea_leaves", 0x646f3d},
    {"spore_blossom", 0xcf619f},
    {"cave_vines", 0x5a6e29},
    {"cave_vines_plant", 0x58652a},
    {"big_dripleaf", 0x6f8e33},
    {"small_dripleaf", 0x5f782e},
    {"hanging_roots", 0xa1735c},
    {"pale_hanging_moss", 0x6b7069},
    {"crimson_fungus", 0x8d2c1e},
    {"warped_fungus", 0x4a6d57},
    {"crimson_roots", 0x7e0829},
    {"warped_roots", 0x148a7c},
    {"nether_sprouts", 0x139785},
    {"weeping_vines", 0x680100},
    {"weeping_vines_plant", 0x841015},
    {"twisting_vines", 0x148f7c},
    {"twisting_vines_plant", 0x147a6d},
    {"chorus_plant", 0x5d395d},
    {"chorus_flower", 0x977896},
    {"sponge", 0xc3c04a},
    {"wet_sponge", 0xabb546},
    {"slime_block", 0x6fc05b},
    {"honey_block", 0xfbb934},
    {"honeycomb_block", 0xe5941d},
    {"bee_nest", 0xc9a04b},
    {"beehive", 0xb4925a},
    {"cobweb", 0xe4e9ea},
    {"turtle_egg", 0xe4e3bf},
    {"sniffer_egg", 0x8c5a4f},
    {"frogspawn", 0x6a5b52},
    {"dragon_egg", 0x0c090f},
    {"tube_coral_block", 0x3157cf},
    {"brain_coral_block", 0xcf5b9f},
    {"bubble_coral_block", 0xa51aa2},
    {"fire_coral_block", 0xa3232e},
    {"horn_coral_block", 0xd8c742},
    {"tube_coral", 0x2f53c5},
    {"brain_coral", 0xc55497},
    {"bubble_coral", 0xa118a0},
    {"fire_coral", 0xa6252f},
    {"horn_coral", 0xd1ba3e},
    {"dead_coral_block", 0x837b77},
    // Ores and minerals.
    {"coal_ore", 0x696969},
    {"iron_ore", 0x88827f},
    {"copper_ore", 0x7d7e78},
    {"gold_ore", 0x91866b},
    {"redstone_ore", 0x8c6e6e},
    {"lapis_ore", 0x6b768e},
    {"diamond_ore", 0x798d8d},
    {"emerald_ore", 0x6c8874},
    {"deepslate_coal_ore", 0x4a4a4c},
    {"deepslate_iron_ore", 0x6b645f},
    {"deepslate_copper_ore", 0x5c5d5a},
    {"deepslate_gold_ore", 0x73674e},
    {"deepslate_redstone_ore", 0x68494a},
    {"deepslate_lapis_ore", 0x505b73},
    {"deepslate_diamond_ore", 0x536a6b},
    {"deepslate_emerald_ore", 0x4e6858},
    {"nether_quartz_ore", 0x764240},
    {"nether_gold_ore", 0x73372a},
    {"ancient_debris", 0x5f4039},
    {"coal_block", 0x101010},
    {"iron_block", 0xdcdcdc},
    {"gold_block", 0xf6d03e},
    {"diamond_block", 0x62ede4},
    {"emerald_block", 0x2acb58},
    {"lapis_block", 0x1f438c},
    {"redstone_block", 0xb01905},
    {"netherite_block", 0x433d40},
    {"raw_iron_block", 0xa6886b},
    {"raw_copper_block", 0x9a6a4f},
    {"raw_gold_block", 0xdea92f},
    {"copper_block", 0xc06c50},
    {"exposed_copper", 0xa17e68},
    {"weathered_copper", 0x6c996e},
    {"oxidized_copper", 0x52a384},
    {"cut_copper", 0xbf6b51},
    {"exposed_cut_copper", 0x9b7a66},
    {"weathered_cut_copper", 0x6d916b},
    {"oxidized_cut_copper", 0x50997f},
    {"chiseled_copper", 0xb8654a},
    {"copper_bulb", 0x9d573f},
    {"copper_grate", 0xc06c50},
    {"small_amethyst_bud", 0x8463bb},
    {"medium_amethyst_bud", 0x9e78c9},
    {"large_amethyst_bud", 0xa17ecb},
    {"amethyst_cluster", 0xa37fcf},
    // Things that are made.
    {"crafting_table", 0x78552f},
    {"furnace", 0x6f6f6f},
    {"blast_furnace", 0x5c5b5c},
    {"smoker", 0x665b4b},
    {"chest", 0x8a6830},
    {"trapped_chest", 0x8a6830},
    {"ender_chest", 0x2c3b3c},
    {"barrel", 0x7a5b32},
    {"bookshelf", 0x75603d},
    {"chiseled_bookshelf", 0xb1905a},
    {"lectern", 0xad8951},
    {"loom", 0x8e7653},
    {"cartography_table", 0x67574b},
    {"fletching_table", 0xc5b485},
    {"smithing_table", 0x393a46},
    {"stonecutter", 0x7b776f},
    {"grindstone", 0x8e8e8e},
    {"anvil", 0x444444},
    {"chipped_anvil", 0x444444},
    {"damaged_anvil", 0x444444},
    {"enchanting_table", 0x804b55},
    {"brewing_stand", 0x7a6552},
    {"cauldron", 0x4a494a},
    {"water_cauldron", 0x4a494a},
    {"lava_cauldron", 0x4a494a},
    {"composter", 0x70461f},
    {"hopper", 0x4b4a4b},
    {"dropper", 0x6f6f6f},
    {"dispenser", 0x6f6f6f},
    {"crafter", 0x706364},
    {"observer", 0x626262},
    {"piston", 0x6e6961},
    {"sticky_piston", 0x6e6961},
    {"piston_head", 0x9a8259},
    {"moving_piston", 0x9a8259},
    {"note_block", 0x593a29},
    {"jukebox", 0x5d402f},
    {"tnt", 0xb6584d},
    {"target", 0xe2aa9d},
    {"lodestone", 0x77797c},
    {"respawn_anchor", 0x3c2a55},
    {"beacon", 0x76ddd7},
    {"conduit", 0x9f8b71},
    {"spawner", 0x252f3e},
    {"trial_spawner", 0x3b4c57},
    {"vault", 0x37444e},
    {"heavy_core", 0x525760},
    {"bell", 0xfcd33e},
    {"flower_pot", 0x7c4535},
    {"decorated_pot", 0x8e5440},
    {"cake", 0xf8ddd2},
    {"scaffolding", 0xaa8349},
    {"ladder", 0x7c6137},
    {"iron_bars", 0x888b87},
    {"chain", 0x333a4a},
    {"iron_door", 0xc2c2c2},
    {"iron_trapdoor", 0xcac9c9},
    {"heavy_weighted_pressure_plate", 0xdcdcdc},
    {"light_weighted_pressure_plate", 0xf6d03e},
    {"lever", 0x6f5d43},
    {"rail", 0x7d6f58},
    {"powered_rail", 0x8a6d4a},
    {"detector_rail", 0x7b6859},
    {"activator_rail", 0x735748},
    {"redstone_wire", 0xa00a05},
    {"repeater", 0xa09d9c},
    {"comparator", 0xa6a2a0},
    {"redstone_torch", 0xd05038},
    {"redstone_wall_torch", 0xd05038},
    {"redstone_lamp", 0x8f5a34},
    {"daylight_detector", 0x82745e},
    {"torch", 0xf2c565},
    {"wall_torch", 0xf2c565},
    {"soul_torch", 0x7bd5d8},
    {"soul_wall_torch", 0x7bd5d8},
    {"copper_torch", 0x9fe07f},
    {"copper_wall_torch", 0x9fe07f},
    {"lantern", 0xf0b45a},
    {"soul_lantern", 0x7bd5d8},
    {"campfire", 0xd78d3c},
    {"soul_campfire", 0x4dc3c6},
    {"end_rod", 0xf3e9df},
    {"candle", 0xe8c999},
    {"lightning_rod", 0xc56f54},
    {"item_frame", 0x8a6a3c},
    {"end_portal_frame", 0x5b7860},
    {"end_portal", 0x0b1a20},
    {"end_gateway", 0x0b1a20},
    {"nether_portal", 0x5c0fc4},
    {"command_block", 0xb58a6e},
    {"chain_command_block", 0x84a396},
    {"repeating_command_block", 0x8270ad},
    {"structure_block", 0x594a5a},
    {"jigsaw", 0x504551},
    {"shulker_box", 0x8b618b},
    {"glass", 0xd8eef0},
    {"tinted_glass", 0x2c262d},
    {"ochre_froglight", 0xfbf5ce},
    {"verdant_froglight", 0xe5f4e4},
    {"pearlescent_froglight", 0xf5f0ef},
    {"skeleton_skull", 0xc4c4c4},
    {"wither_skeleton_skull", 0x2f2f2f},
    {"zombie_head", 0x4d7a3a},
    {"player_head", 0x9a6b50},
    {"creeper_head", 0x5cab4d},
    {"dragon_head", 0x1d1b1d},
    {"piglin_head", 0xe0a07a},
    {"infested_block", 0x7e7e7e},
    {"waxed_copper_block", 0xc06c50},
    {"petrified_oak_slab", 0xa2834f},
    // Luanti's (default game) where they have no twin above.
    {"silver_sand", 0xc2c0b9},
    {"silver_sandstone", 0xc5c3bb},
    {"desert_sand", 0xd0a778},
    {"desert_stone", 0x87503a},
    {"desert_sandstone", 0xc7a178},
    {"mese", 0xdfe020},
    {"meselamp", 0xfefac0},
    {"bronze_block", 0xba6624},
    {"tin_block", 0x96969a},
    {"permafrost", 0x776a5c},
    {"apple", 0xc8281c},
    {"dry_dirt", 0xb79a6e},
    {"dry_grass_block", 0xbfa355},
    {"rainforest_litter", 0x4b3a22},
    {"coniferous_litter", 0x6c4b2c},
};

// What a name that is not known is made of, by the words in it; the first that fits.
constexpr Named WORDS[] = {
    {"leaves", 0x4a7a2c},   {"leaf", 0x4a7a2c},    {"needles", 0x3c5b3c},   {"grass", 0x6f9a45},
    {"moss", 0x596e2d},     {"sapling", 0x4f7a2e}, {"flower", 0xc04a6a},    {"bush", 0x4f7a2e},
    {"plant", 0x4f7a2e},    {"crop", 0x7f8f3a},    {"log", 0x6d5533},       {"trunk", 0x6d5533},
    {"bark", 0x6d5533},     {"tree", 0x6d5533},    {"planks", 0xa2834f},    {"wood", 0x8c6e41},
    {"glass", 0xd8eef0},    {"water", 0x3f76e4},   {"lava", 0xd45a12},      {"magma", 0x8e3f20},
    {"snow", 0xf9fefe},     {"ice", 0x8db4fa},     {"sandstone", 0xd8cb9c}, {"sand", 0xdbcfa3},
    {"gravel", 0x847f7f},   {"dirt", 0x866043},    {"soil", 0x866043},      {"mud", 0x3c393d},
    {"clay", 0xa1a6b3},     {"copper", 0xc06c50},  {"gold", 0xf6d03e},      {"iron", 0xdcdcdc},
    {"steel", 0xc0c0c4},    {"metal", 0xb0b0b4},   {"ore", 0x7f7a76},       {"marble", 0xe4e2de},
    {"basalt", 0x505156},   {"granite", 0x956756}, {"limestone", 0xc9c4ae}, {"slate", 0x505053},
    {"brick", 0x976253},    {"cobble", 0x807f80},  {"stone", 0x7e7e7e},     {"rock", 0x777472},
    {"concrete", 0xa0a0a0}, {"wool", 0xe9ecec},    {"quartz", 0xece6df},    {"lamp", 0xfefac0},
    {"light", 0xfefac0},
};

const Dye* dye_of(std::string_view& name) {
    for (const Dye& dye : DYES) {
        if (name.size() > dye.name.size() && name.starts_with(dye.name) && name[dye.name.size()] == '_') {
            name.remove_prefix(dye.name.size() + 1);
            return &dye;
        }
    }
    return nullptr;
}

std::optional<std::uint32_t> dyed_color(std::string_view name) {
    const Dye* dye = dye_of(name);
    if (!dye) return std::nullopt;
    if (name == "wool" || name == "carpet" || name == "bed") return dye->wool;
    if (name == "concrete") return dye->concrete;
    if (name == "concrete_powder") return dye->powder;
    if (name == "terracotta" || name == "stained_hardened_clay") return dye->terracotta;
    if (name == "glazed_terracotta") return dye->glazed;
    for (const std::string_view thing : {"stained_glass", "stained_glass_pane", "shulker_box", "banner", "wall_banner",
                                         "candle", "candle_cake", "dye"})
        if (name == thing) return dye->dye;
    return std::nullopt;
}

std::optional<std::uint32_t> wooden_color(std::string_view name) {
    const bool stripped = name.starts_with("stripped_");
    if (stripped) name.remove_prefix(9);
    for (const Wood& wood : WOODS) {
        if (name.size() <= wood.name.size() || !name.starts_with(wood.name) || name[wood.name.size()] != '_') continue;
        const std::string_view part = name.substr(wood.name.size() + 1);
        for (const std::string_view trunk : {"log", "wood", "stem", "hyphae", "block"})
            if (part == trunk) return stripped ? wood.stripped : wood.bark;
        if (part == "leaves" || part == "sapling" || part == "propagule") return wood.leaves;
        if (part == "door" || part == "trapdoor") return wood.door;
        for (const std::string_view thing :
             {"planks", "slab", "stairs", "fence", "fence_gate", "pressure_plate", "button", "sign", "wall_sign",
              "hanging_sign", "wall_hanging_sign", "mosaic", "mosaic_slab", "mosaic_stairs", "shelf"})
            if (part == thing) return wood.planks;
    }
    return std::nullopt;
}

std::optional<std::uint32_t> plain_color(std::string_view name) {
    static const std::unordered_map<std::string_view, std::uint32_t> table = [] {
        std::unordered_map<std::string_view, std::uint32_t> colors;
        for (const Named& block : BLOCKS) colors.emplace(block.name, block.rgb);
        return colors;
    }();
    if (const auto found = table.find(name); found != table.end()) return found->second;
    if (const auto color = dyed_color(name)) return color;
    return wooden_color(name);
}

// Of "brick_slab" the colour of "bricks", of "infested_stone" that of "stone".
std::optional<std::uint32_t> derived_color(std::string_view name) {
    if (name.starts_with("dead_") && name.find("coral") != name.npos) return plain_color("dead_coral_block");
    for (const std::string_view suffix :
         {"_slab",         "_stairs",      "_wall",      "_fence_gate", "_fence", "_pressure_plate",
          "_button",       "_double_slab", "_pane",      "_trapdoor",   "_door",  "_wall_fan",
          "_fan",          "_cake",        "_bars",      "_lantern",    "_chain", "_chest",
          "_golem_statue", "_wall_head",   "_wall_skull"}) {
        if (!name.ends_with(suffix)) continue;
        const std::string base(name.substr(0, name.size() - suffix.size()));
        if (suffix == "_wall_head") return plain_color(base + "_head");
        if (suffix == "_wall_skull") return plain_color(base + "_skull");
        for (const char* ending : {"", "s", "_block", "_planks"})
            if (const auto color = plain_color(base + ending)) return color;
        if (const auto color = derived_color(base)) return color;
    }
    for (const std::string_view prefix : {"infested_", "waxed_", "potted_", "dead_", "smooth_", "cut_", "polished_",
                                          "chiseled_", "cracked_", "mossy_", "hardened_", "lit_", "unlit_"}) {
        if (!name.starts_with(prefix)) continue;
        const std::string_view base = name.substr(prefix.size());
        if (const auto color = plain_color(base)) return color;
        if (const auto color = derived_color(base)) return color;
    }
    if (name.ends_with("_copper_bulb") || name.ends_with("_copper_grate"))
        return plain_color(name.substr(0, name.rfind('_')));
    return std::nullopt;
}

// FNV-1a: the same on every machine.
std::uint32_t hash_of(std::string_view text) {
    std::uint32_t hash = 2166136261u;
    for (const char c : text) hash = (hash ^ std::uint8_t(c)) * 16777619u;
    return hash;
}

}  // namespace

BlockColor block_color(std::string_view name) {
    if (const auto color = plain_color(name)) return {*color, true};
    if (const auto color = derived_color(name)) return {*color, true};
    const std::uint32_t hash = hash_of(name);
    std::uint32_t rgb = 0x606060u + (hash & 0x3f3f3fu);  // no word is known: a soft colour of its own
    const auto holds = [&](std::string_view word) { return name.find(word) != name.npos; };
    for (const Named& word : WORDS) {
        if (!holds(word.name)) continue;
        rgb = word.rgb;
        break;
    }
    for (const Dye& dye : DYES)
        if (name.starts_with(std::string(dye.name) + "_") || name.ends_with("_" + std::string(dye.name)))
            rgb = dye.concrete;
    return {rgb, false};
}

}  // namespace spinel
