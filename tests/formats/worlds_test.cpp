// Worlds, structures and terrain: Minecraft's, Luanti's, heightmaps.

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <map>

#include "formats/anvil.h"
#include "formats/heightmap.h"
#include "formats/mts.h"
#include "formats/schematic.h"
#include "image/image_io.h"
#include "nbt_writer.h"
#include "scene/validate.h"
#include "test_files.h"

namespace spinel::worlds_test {
namespace {

using Cell = std::array<int, 3>;

// The cubes of a scene by their place in world space, with the name of their material.
std::map<Cell, std::string> cubes(const Scene& scene) {
    std::map<Cell, std::string> result;
    for (const Object& object : scene.objects)
        if (const auto* voxels = std::get_if<VoxelGeometry>(&scene.geometries[std::size_t(object.geometry)].data))
            voxels->tree->for_each([&](ivec3 cell, std::uint16_t palette) {
                const vec3 at = object.transform * vec4(vec3(cell), 1);
                result[{int(at.x), int(at.y), int(at.z)}] =
                    scene.materials[std::size_t(object.materials[palette - 1u])].name;
            });
    return result;
}

std::size_t box_count(const Scene& scene) {
    std::size_t count = 0;
    for (const Geometry& geometry : scene.geometries)
        if (const auto* mesh = std::get_if<MeshGeometry>(&geometry.data)) count += mesh->triangles.size() / 12;
    return count;
}

const Scene& valid_scene(const Result<Scene>& scene) {
    static const Scene none;
    EXPECT_TRUE(scene) << scene.error().message;
    if (!scene) return none;
    const Result<void> valid = validate(*scene);
    EXPECT_TRUE(valid) << valid.error().message;
    return *scene;
}

// Whatever is cut off a file, or replaced by a lie, the reader refuses it or gives a valid scene.
template <class Load>
void expect_robust(const FileTest&, const std::filesystem::path& path, const std::string& whole, const Load& load) {
    const auto attempt = [&](const std::string& bytes) {
        std::ofstream(path, std::ios::binary) << bytes;
        const Result<Scene> scene = load(path);
        if (!scene) return expect_refused(scene, path);
        EXPECT_TRUE(validate(*scene));
    };
    const std::size_t step = std::max<std::size_t>(1, whole.size() / 300);
    for (std::size_t size = 0; size < whole.size(); size += step) attempt(whole.substr(0, size));
    for (std::size_t at = 0; at + 4 <= whole.size(); at += step)
        for (const std::uint32_t lie : {0xffffffffu, 0x7fffffffu, 0x01000000u, 0u}) {
            std::string bytes = whole;
            bytes.replace(at, 4, raw(lie));
            attempt(bytes);
        }
}

nbt::Written state(const std::string& name, const nbt::Members& properties = {}) {
    nbt::Members members = {{"Name", nbt::text(name)}};
    if (!properties.empty()) members.push_back({"Properties", nbt::compound(properties)});
    return nbt::compound(members);
}

class Worlds : public FileTest {
  protected:
    // A region of one chunk, at (1, 2) of the region's 32×32.
    std::filesystem::path region(char packing, const std::string& chunk) const {
        std::string header(8192, '\0');
        const int index = 1 + 32 * 2;
        header[index * 4 + 2] = 2;  // the third sector
        header[index * 4 + 3] = 1;
        return write("r.0.0.mca",
                     header + nbt::big_endian(std::uint32_t(chunk.size() + 1)) + std::string(1, packing) + chunk);
    }
};
using AnvilWorlds = Worlds;
using Structures = Worlds;
using Terrain = Worlds;

std::string chunk_of_states(bool modern, bool spanning) {
    // A palette of 17 entries: 5 bits, which do not divide 64. Stone at (3, 0, 0), gold at (15, 15, 15).
    std::vector<nbt::Written> palette = {state("minecraft:air"), state("minecraft:stone"),
                                         state("minecraft:gold_block")};
    while (palette.size() < 17) palette.push_back(state("minecraft:oak_log", {{"axis", nbt::text("y")}}));
    std::vector<unsigned> indices(4096, 0);
    indices[3] = 1;
    indices[4095] = 2;
    const nbt::Written words = nbt::longs(nbt::packed(indices, 5, spanning));
    const nbt::Written list = nbt::list(nbt::Type::compound, palette);
    if (modern)
        return nbt::document(
            {{"sections",
              nbt::list(nbt::Type::compound,
                        {nbt::compound({{"Y", nbt::int8(-1)},
                                        {"block_states", nbt::compound({{"palette", list}, {"data", words}})}})})}});
    return nbt::document(
        {{"Level",
          nbt::compound({{"Sections", nbt::list(nbt::Type::compound, {nbt::compound({{"Y", nbt::int8(-1)},
                                                                                     {"Palette", list},
                                                                                     {"BlockStates", words}})})}})}});
}

TEST_F(AnvilWorlds, read_palettes_of_both_packings_and_both_layouts) {
    for (const bool modern : {false, true})
        for (const bool spanning : {false, true}) {
            const Result<Scene> scene = load_anvil(region(3, chunk_of_states(modern, spanning)));
            EXPECT_EQ(cubes(valid_scene(scene)),
                      (std::map<Cell, std::string>{{{16 + 3, -16, 32}, "minecraft:stone"},
                                                   {{16 + 15, -1, 32 + 15}, "minecraft:gold_block"}}));
        }
}

TEST_F(AnvilWorlds, read_sections_of_one_block) {
    const auto section = nbt::compound(
        {{"Y", nbt::int8(0)},
         {"block_states", nbt::compound({{"palette", nbt::list(nbt::Type::compound, {state("minecraft:dirt")})}})}});
    const Result<Scene> scene =
        load_anvil(region(3, nbt::document({{"sections", nbt::list(nbt::Type::compound, {section})}})));
    EXPECT_EQ(cubes(valid_scene(scene)).size(), 4096u);
}

TEST_F(AnvilWorlds, read_numeric_ids) {
    std::string ids(4096, '\0'), data(2048, '\0'), add(2048, '\0');
    ids[0] = 35;             // wool …
    data[0] = 14;            // … red
    ids[1 + 16 + 256] = 1;   // x 1, z 1, y 1
    ids[2] = 50;             // a torch: no cube
    ids[4] = 5, add[2] = 1;  // id 261, which never was
    const auto section = nbt::compound(
        {{"Y", nbt::int8(4)}, {"Blocks", nbt::bytes(ids)}, {"Data", nbt::bytes(data)}, {"Add", nbt::bytes(add)}});
    const std::string chunk =
        nbt::document({{"Level", nbt::compound({{"Sections", nbt::list(nbt::Type::compound, {section})}})}});
    const Result<Scene> scene = load_anvil(region(3, chunk));
    EXPECT_EQ(
        cubes(valid_scene(scene)),
        (std::map<Cell, std::string>{{{16, 64, 32}, "red_wool"}, {{17, 65, 33}, "stone"}, {{20, 64, 32}, "id:261"}}));
    EXPECT_EQ(box_count(*scene), 1u);
    ASSERT_EQ(scene->notes.size(), 1u);
    EXPECT_NE(scene->notes[0].find("id:261"), std::string::npos);
}

TEST_F(AnvilWorlds, unpack_zlib_and_refuse_what_they_do_not_know) {
    const std::string chunk = chunk_of_states(true, false);
    std::string packed(compressBound(chunk.size()), '\0');
    uLongf size = packed.size();
    ASSERT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(chunk.data()),
                       chunk.size()),
              Z_OK);
    packed.resize(size);
    EXPECT_EQ(cubes(valid_scene(load_anvil(region(2, packed)))).size(), 2u);
    auto path = region(9, chunk);
    expect_refused(load_anvil(path), path, "packing 9");
    path = region(2, chunk);
    expect_refused(load_anvil(path), path, "chunk (1, 2): its compressed data is damaged");
    path = write("r.0.0.mca", std::string(8192, '\0'));
    expect_refused(load_anvil(path), path, "no chunk");
    path = write("r.0.0.mca", "");
    expect_refused(load_anvil(path), path, "header");
}

TEST_F(AnvilWorlds, damaged_ones_are_refused_or_harmless) {
    region(3, chunk_of_states(true, false));
    expect_robust(*this, folder / "r.0.0.mca", bytes_of(folder / "r.0.0.mca"),
                  [](const auto& path) { return load_anvil(path); });
}

// 2×1×3 blocks: x fastest, then z, then y.
nbt::Members sponge_box(const nbt::Members& rest) {
    nbt::Members members = {{"Width", nbt::int16(2)}, {"Height", nbt::int16(1)}, {"Length", nbt::int16(3)}};
    members.insert(members.end(), rest.begin(), rest.end());
    return members;
}
const nbt::Members sponge_palette = {{"minecraft:air", nbt::int32(0)},
                                     {"minecraft:stone", nbt::int32(200)},
                                     {"minecraft:oak_slab[type=top]", nbt::int32(2)}};
const std::string sponge_blocks = std::string("\xc8\x01\x00\x02\x00\xc8\x01\x00", 8);  // 200 takes two bytes
const std::map<Cell, std::string> sponge_cubes = {{{0, 0, 0}, "minecraft:stone"}, {{0, 0, 2}, "minecraft:stone"}};

std::string sponge_file(int version) {
    using namespace nbt;
    if (version < 3)
        return document(sponge_box(
            {{"Version", int32(version)}, {"Palette", compound(sponge_palette)}, {"BlockData", bytes(sponge_blocks)}}));
    return document({{"Schematic", compound(sponge_box({{"Version", int32(3)},
                                                        {"Blocks", compound({{"Palette", compound(sponge_palette)},
                                                                             {"Data", bytes(sponge_blocks)}})}}))}});
}

TEST_F(Structures, sponge_schematics_of_all_versions) {
    for (const int version : {1, 2, 3}) {
        const Result<Scene> scene = load_sponge_schematic(write("a.schem", sponge_file(version)));
        EXPECT_EQ(cubes(valid_scene(scene)), sponge_cubes) << version;
        EXPECT_EQ(box_count(*scene), 1u);
    }
    const auto path = write("a.schem", sponge_file(1).replace(sponge_file(1).find("Version") + 10, 1, "\x07"));
    expect_refused(load_sponge_schematic(path), path, "version is 7");
}

TEST_F(Structures, mcedit_schematics) {
    using namespace nbt;
    const std::string file = document(sponge_box({{"Materials", nbt::text("Alpha")},
                                                  {"Blocks", bytes(std::string("\x23\x00\x01\x00\x00\x35", 6))},
                                                  {"Data", bytes(std::string("\x0b\x00\x00\x00\x00\x02", 6))}}));
    const Result<Scene> scene = load_mcedit_schematic(write("a.schematic", file));
    EXPECT_EQ(cubes(valid_scene(scene)), (std::map<Cell, std::string>{{{0, 0, 0}, "blue_wool"}, {{0, 0, 1}, "stone"}}));
    EXPECT_EQ(box_count(*scene), 2u);  // stairs
}

std::string litematic_file() {
    using namespace nbt;
    const auto palette =
        list(Type::compound, {state("minecraft:air"), state("minecraft:stone"), state("minecraft:dirt"),
                              state("minecraft:glass"), state("minecraft:bricks")});
    const auto vector = [](int x, int y, int z) {
        return compound({{"x", int32(x)}, {"y", int32(y)}, {"z", int32(z)}});
    };
    std::vector<unsigned> indices(2 * 3 * 4, 0);  // 3 bits each: index 21 spans two words
    indices[0] = 1;
    indices[21] = 4;  // x 1, z 1, y 3
    // From (10, 5, 7) two towards −x, four up, three towards −z: from (9, 5, 5) on.
    const auto turned = compound({{"Position", vector(10, 5, 7)},
                                  {"Size", vector(-2, 4, -3)},
                                  {"BlockStatePalette", palette},
                                  {"BlockStates", longs(packed(indices, 3, true))}});
    const auto straight = compound({{"Position", vector(0, 0, 0)},
                                    {"Size", vector(1, 1, 1)},
                                    {"BlockStatePalette", palette},
                                    {"BlockStates", longs({2})}});
    return document({{"Regions", compound({{"turned", turned}, {"straight", straight}})}});
}

TEST_F(Structures, litematics_of_several_regions_and_negative_sizes) {
    const Result<Scene> scene = load_litematic(write("a.litematic", litematic_file()));
    EXPECT_EQ(cubes(valid_scene(scene)),
              (std::map<Cell, std::string>{
                  {{9, 5, 5}, "minecraft:stone"}, {{10, 8, 6}, "minecraft:bricks"}, {{0, 0, 0}, "minecraft:dirt"}}));
}

std::string structure_file() {
    using namespace nbt;
    const auto block = [](int x, int y, int z, int index) {
        return compound({{"pos", ints({x, y, z})}, {"state", int32(index)}});
    };
    return document({{"size", ints({4, 5, 6})},
                     {"palette", list(Type::compound, {state("minecraft:stone"), state("minecraft:water"),
                                                       state("minecraft:glass_pane")})},
                     {"blocks", list(Type::compound, {block(1, 2, 3, 0), block(3, 4, 5, 1), block(2, 2, 3, 2)})}});
}

TEST_F(Structures, structures_of_the_game) {
    const Result<Scene> scene = load_structure(write("a.nbt", structure_file()));
    EXPECT_EQ(cubes(valid_scene(scene)),
              (std::map<Cell, std::string>{{{1, 2, 3}, "minecraft:stone"}, {{3, 4, 5}, "minecraft:water"}}));
    EXPECT_EQ(box_count(*scene), 2u);  // the pane's post, and its arm to the stone
    const auto path = write("b.nbt", nbt::document({{"Data", nbt::int8(1)}}));
    expect_refused(load_structure(path), path, "not a structure");
}

TEST_F(Structures, damaged_ones_are_refused_or_harmless) {
    expect_robust(*this, folder / "a.schem", sponge_file(2), [](const auto& p) { return load_sponge_schematic(p); });
    expect_robust(*this, folder / "a.litematic", litematic_file(), [](const auto& p) { return load_litematic(p); });
    expect_robust(*this, folder / "a.nbt", structure_file(), [](const auto& p) { return load_structure(p); });
}

TEST_F(Structures, schematics_of_luanti_turn_north_away_from_the_viewer) {
    // 2×1×2 nodes; z points north in the file, south here. One node is never placed.
    const std::string nodes =
        std::string("\0\1\0\0\0\1\0\2", 8) + std::string("\x7f\x7f\x00\x40", 4) + std::string(4, '\0');
    std::string packed(compressBound(nodes.size()), '\0');
    uLongf size = packed.size();
    ASSERT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(nodes.data()),
                       nodes.size()),
              Z_OK);
    packed.resize(size);
    std::string file = "MTSM" + std::string("\0\4\0\2\0\1\0\2\x7f\0\3", 11);
    for (const char* name : {"air", "default:tree", "default:cobble"}) file += nbt::counted(name);
    const Result<Scene> scene = load_mts(write("a.mts", file + packed));
    EXPECT_EQ(cubes(valid_scene(scene)),
              (std::map<Cell, std::string>{{{0, 0, 1}, "default:tree"}, {{1, 0, 0}, "default:cobble"}}));
    expect_robust(*this, folder / "a.mts", file + packed, [](const auto& p) { return load_mts(p); });
}

TEST_F(Terrain, heights_of_a_tile_are_true_to_scale) {
    // 3×3 posts half a degree apart: a peak of 1000 m in the middle of a plain of 100 m, and a void.
    std::string bytes;
    for (const int height : {100, 100, 100, 100, 1000, 100, 100, 100, -32768})
        bytes += nbt::big_endian(std::int16_t(height));
    const Result<Scene> scene = load_hgt(write("N00E006.hgt", bytes));
    const Scene& s = valid_scene(scene);
    ASSERT_EQ(s.objects.size(), 1u);
    const mat4x3& m = s.objects[0].transform;
    EXPECT_NEAR(m[2].z, 55660.0f, 1.0f);
    EXPECT_NEAR(m[0].x, 55660.0f * std::cos(glm::radians(0.5f)), 1.0f);
    EXPECT_EQ(m[3].y, 100.0f);
    ASSERT_EQ(s.notes.size(), 1u);
    EXPECT_NE(s.notes[0].find("1 of its heights"), std::string::npos);

    const Result<Scene> steep = load_hgt(folder / "N00E006.hgt", {.frame = {}, .heightmap = 90.0f});
    const auto& voxels = std::get<VoxelGeometry>(valid_scene(steep).geometries[0].data);
    EXPECT_EQ(voxels.tree->size(), ivec3(3, 90, 3));
    EXPECT_NE(voxels.tree->at({1, 89, 1}), 0);
    EXPECT_NE(voxels.tree->at({1, 1, 1}), 0);  // the slope is closed down to its neighbours
    EXPECT_EQ(voxels.tree->at({0, 1, 0}), 0);
    EXPECT_NE(voxels.tree->at({0, 0, 0}), 0);
    const auto odd = write("N00E007.hgt", "abc");
    expect_refused(load_hgt(odd), odd, "square");
}

TEST_F(Terrain, pictures_are_heightmaps_when_they_are_asked_to_be) {
    Image image{4, 2, 1, {0, 0.25f, 0.5f, 1, 0, 0, 0, 0}};
    const auto path = folder / "a.exr";
    ASSERT_TRUE(write_image(path, {{{"Y"}, image}}));
    expect_refused(load_model(path), path, "--heightmap");
    const Result<Scene> scene = load_model(path, {.frame = {}, .heightmap = 9.0f});
    const auto& tree = *std::get<VoxelGeometry>(valid_scene(scene).geometries[0].data).tree;
    EXPECT_EQ(tree.size(), ivec3(4, 9, 2));
    for (int x = 0; x < 4; ++x) {
        const int top = int(image.values[std::size_t(x)] * 8);
        EXPECT_NE(tree.at({x, top, 0}), 0) << x;  // row 0 is north
        EXPECT_EQ(tree.at({x, top + 1, 0}), 0) << x;
    }
    const Result<Scene> flat = load_model(path, {.frame = {}, .heightmap = 1.0f});
    EXPECT_EQ(std::get<VoxelGeometry>(valid_scene(flat).geometries[0].data).tree->size(), ivec3(4, 1, 2));
    const auto vox = write("a.mts", "");
    expect_refused(load_model(vox, {.frame = {}, .heightmap = 8.0f}), vox, "no heights");
    expect_refused(load_model(vox, {.frame = 1, .heightmap = {}}), vox, "no frames");
}

TEST_F(Worlds, real_files_hold_what_is_known_of_them) {
    struct Case {
        const char* file;
        std::uint64_t cubes;
        std::size_t boxes;
    };
    const Case cases[] = {{"world/anvil/mc1.8.9_r.-1.0.mca", 4944804, 7367},
                          {"world/anvil/mc1.12.2_r.0.-1.mca", 1750322, 2818},
                          {"world/anvil/mc1.18.2_r.0.0.mca", 1701174, 98},
                          {"world/anvil/mc1.21.1_r.0.0.mca", 1114466, 608},
                          {"world/schem/CreativeInABox.schematic", 0, 3},
                          {"world/schem/Station.schematic", 749720, 55692},
                          {"world/schem/SimpleHouse.litematic", 48, 48},
                          {"world/schem/test.litematic", 8782, 5115},
                          {"world/schem/smallhouse1.schem", 1830, 2408},
                          {"world/mts/apple_tree.mts", 81, 4},
                          {"world/mts/jungle_tree.mts", 125, 0},
                          {"world/mts/pine_tree.mts", 100, 0}};
    if (!std::filesystem::exists(data_folder / "world")) GTEST_SKIP() << "no " << data_folder / "world";
    for (const Case& c : cases) {
        const Result<Scene> scene = load_model(data_folder / c.file);
        const Scene& s = valid_scene(scene);
        EXPECT_TRUE(s.notes.empty()) << c.file << ": " << s.notes[0];
        std::uint64_t count = 0;
        for (const Geometry& geometry : s.geometries)
            if (const auto* voxels = std::get_if<VoxelGeometry>(&geometry.data)) count += voxels->tree->voxel_count();
        EXPECT_EQ(count, c.cubes) << c.file;
        EXPECT_EQ(box_count(s), c.boxes) << c.file;
    }
    const auto level = data_folder / "world/nbt/bigtest.nbt";
    expect_refused(load_model(level), level, "not a structure");
}

}  // namespace
}  // namespace spinel::worlds_test
