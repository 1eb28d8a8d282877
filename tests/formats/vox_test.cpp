#include "formats/vox.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "formats/vox_file.h"
#include "formats/vox_material.h"
#include "image/tone_map.h"
#include "kernels/materials.h"
#include "scene/validate.h"
#include "test_files.h"

namespace spinel {
namespace {

using Dictionary = std::map<std::string, std::string>;

// Writes the chunks of a .vox file.
std::string number(std::int32_t value) { return raw(value); }
std::string text(const std::string& s) { return number(int(s.size())) + s; }
std::string dictionary(const Dictionary& d) {
    std::string bytes = number(int(d.size()));
    for (const auto& [key, value] : d) bytes += text(key) + text(value);
    return bytes;
}
std::string chunk(const std::string& id, const std::string& content) {
    return id + number(int(content.size())) + number(0) + content;
}
std::string file_of(const std::string& chunks, int version = 150) {
    return "VOX " + number(version) + "MAIN" + number(0) + number(int(chunks.size())) + chunks;
}
struct Voxel {
    int x, y, z, index;
};
std::string model(ivec3 size, const std::vector<Voxel>& voxels) {
    std::string content = number(int(voxels.size()));
    for (const Voxel& v : voxels) content += {char(v.x), char(v.y), char(v.z), char(v.index)};
    return chunk("SIZE", number(size.x) + number(size.y) + number(size.z)) + chunk("XYZI", content);
}
std::string transform(int id, int child, const Dictionary& frame = {}, const Dictionary& attributes = {},
                      int layer = -1) {
    return chunk("nTRN", number(id) + dictionary(attributes) + number(child) + number(-1) + number(layer) + number(1) +
                             dictionary(frame));
}
std::string group(int id, const std::vector<int>& children) {
    std::string content = number(id) + dictionary({}) + number(int(children.size()));
    for (const int child : children) content += number(child);
    return chunk("nGRP", content);
}
std::string shape(int id, int model_index) {
    return chunk("nSHP", number(id) + dictionary({}) + number(1) + number(model_index) + dictionary({}));
}
std::string material(int index, const Dictionary& properties) {
    return chunk("MATL", number(index) + dictionary(properties));
}

class Vox : public FileTest {
  protected:
    Result<Scene> load(const std::string& chunks) { return load_vox(write("a.vox", file_of(chunks))); }
};

// World positions of the centres of an object's voxels, sorted; doubled, so that they are whole numbers.
std::vector<std::array<int, 3>> centers(const Scene& scene, const Object& object) {
    const auto& voxels = std::get<VoxelGeometry>(scene.geometries[std::size_t(object.geometry)].data);
    std::vector<std::array<int, 3>> result;
    voxels.tree->for_each([&](ivec3 cell, std::uint16_t) {
        const vec3 p = object.transform * vec4(vec3(cell) + 0.5f, 1.0f);
        result.push_back({int(std::round(2 * p.x)), int(std::round(2 * p.y)), int(std::round(2 * p.z))});
    });
    std::sort(result.begin(), result.end());
    return result;
}
using Centers = std::vector<std::array<int, 3>>;

TEST_F(Vox, a_single_model_stands_on_the_ground_with_z_up_turned_to_y_up) {
    // Corners of a 4×2×6 block: x stays, z becomes y, y becomes −z.
    const Result<Scene> scene = load(model({4, 2, 6}, {{0, 0, 0, 1}, {3, 1, 5, 2}}));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(validate(*scene)) << validate(*scene).error().message;
    ASSERT_EQ(scene->objects.size(), 1u);
    EXPECT_EQ(centers(*scene, scene->objects[0]), (Centers{{-3, 1, 1}, {3, 11, -1}}));
    EXPECT_GT(glm::determinant(mat3(scene->objects[0].transform)), 0.0f);  // a rotation, not a mirror
}

TEST_F(Vox, palette_indices_are_shifted_by_one_and_colors_are_decoded) {
    std::string palette(1024, '\0');
    palette[(5 - 1) * 4 + 0] = char(255);
    palette[(5 - 1) * 4 + 1] = char(188);
    const Result<Scene> scene = load(model({1, 1, 1}, {{0, 0, 0, 5}}) + chunk("RGBA", palette));
    ASSERT_TRUE(scene);
    ASSERT_EQ(scene->materials.size(), 1u);
    const vec3 color = scene->materials[0].values.color;
    EXPECT_FLOAT_EQ(color.x, 1.0f);
    EXPECT_NEAR(color.y, 0.5029f, 1e-4f);
    EXPECT_EQ(color.z, 0.0f);
    EXPECT_EQ(scene->objects[0].materials.size(), 5u);  // slot 4 belongs to index 5
    for (const int slot : scene->objects[0].materials) EXPECT_EQ(slot, 0);
}

TEST_F(Vox, the_default_palette_is_that_of_the_format) {
    const auto palette = vox::default_palette();
    const std::uint32_t known[][2] = {{1, 0xffffff},   {2, 0xffffcc},   {7, 0xffccff},   {37, 0xccffff},
                                      {215, 0x000033}, {216, 0xee0000}, {226, 0x00ee00}, {236, 0x0000ee},
                                      {246, 0xeeeeee}, {255, 0x111111}};
    for (const auto& [index, rgb] : known) {
        EXPECT_EQ(palette[index][0], rgb >> 16) << index;
        EXPECT_EQ(palette[index][1], rgb >> 8 & 255) << index;
        EXPECT_EQ(palette[index][2], rgb & 255) << index;
    }
}

TEST_F(Vox, entries_that_look_the_same_share_a_material) {
    std::string palette(1024, char(100));
    const Result<Scene> scene = load(model({3, 1, 1}, {{0, 0, 0, 5}, {1, 0, 0, 9}, {2, 0, 0, 200}}) +
                                     chunk("RGBA", palette) + material(200, {{"_type", "_metal"}, {"_metal", "1"}}));
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->materials.size(), 2u);
    EXPECT_EQ(scene->objects[0].materials[4], scene->objects[0].materials[8]);
    EXPECT_NE(scene->objects[0].materials[4], scene->objects[0].materials[199]);
}

TEST_F(Vox, the_scene_graph_places_models_about_their_pivots) {
    // An L of three voxels, 3×2×1, turned by a quarter about z: (x, y) → (−y, x); in a group that is moved.
    const Dictionary turn = {{"_t", "10 20 30"}, {"_r", "17"}};  // rows: −y, x, z
    const std::string chunks = model({3, 2, 1}, {{0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}}) + transform(0, 1) +
                               group(1, {2}) + transform(2, 3, {{"_t", "100 0 0"}}) + group(3, {4}) +
                               transform(4, 5, turn) + shape(5, 0);
    const Result<Scene> scene = load(chunks);
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ(scene->objects.size(), 1u);
    // Centres relative to the pivot (1, 1, 0): (−½, −½, ½), (½, −½, ½), (−½, ½, ½); turned: (½, −½), (½, ½),
    // (−½, −½). Moved by (110, 20, 30), then (x, y, z) → (x, z, −y); all doubled.
    Centers expected = {{221, 61, -39}, {221, 61, -41}, {219, 61, -39}};
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(centers(*scene, scene->objects[0]), expected);
}

TEST_F(Vox, a_mirrored_model_fills_the_same_cells) {
    const std::string base = model({2, 3, 1}, {{0, 0, 0, 1}, {1, 2, 0, 1}});
    const Result<Scene> scene = load(base + transform(0, 1) + group(1, {2}) +
                                     transform(2, 3, {{"_r", std::to_string(0 | 1 << 2 | 1 << 4)}}) + shape(3, 0));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(centers(*scene, scene->objects[0]), (Centers{{-1, 1, -3}, {1, 1, 1}}));
    EXPECT_LT(glm::determinant(mat3(scene->objects[0].transform)), 0.0f);
}

TEST_F(Vox, one_model_placed_twice_is_one_geometry) {
    const Result<Scene> scene = load(model({1, 1, 1}, {{0, 0, 0, 1}}) + transform(0, 1) + group(1, {2, 4}) +
                                     transform(2, 3, {{"_t", "5 0 0"}}, {{"_name", "left"}}) + shape(3, 0) +
                                     transform(4, 3, {{"_t", "-5 0 0"}}));
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->geometries.size(), 1u);
    ASSERT_EQ(scene->objects.size(), 2u);
    EXPECT_EQ(scene->objects[0].name, "left");
    EXPECT_EQ(scene->objects[0].transform[3].x - scene->objects[1].transform[3].x, 10.0f);
}

TEST_F(Vox, hidden_nodes_and_layers_are_left_out) {
    const std::string hidden_layer = chunk("LAYR", number(3) + dictionary({{"_hidden", "1"}}) + number(-1));
    const std::string chunks = model({1, 1, 1}, {{0, 0, 0, 1}}) + transform(0, 1) + group(1, {2, 4, 6}) +
                               transform(2, 3, {}, {{"_hidden", "1"}}) + shape(3, 0) + transform(4, 5, {}, {}, 3) +
                               shape(5, 0) + transform(6, 7, {}, {{"_name", "seen"}}, 2) + shape(7, 0) + hidden_layer;
    const Result<Scene> scene = load(chunks);
    ASSERT_TRUE(scene);
    ASSERT_EQ(scene->objects.size(), 1u);
    EXPECT_EQ(scene->objects[0].name, "seen");
}

TEST_F(Vox, frames_of_an_animation_are_not_piled_up) {
    const std::string pack = chunk("PACK", number(2));
    const Result<Scene> scene = load(pack + model({1, 1, 1}, {{0, 0, 0, 1}}) + model({2, 1, 1}, {{0, 0, 0, 1}}));
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->objects.size(), 1u);
    EXPECT_EQ(std::get<VoxelGeometry>(scene->geometries[0].data).tree->size().x, 1);
}

TEST_F(Vox, empty_models_are_skipped_and_a_file_of_nothing_is_refused) {
    const std::string graph =
        transform(0, 1) + group(1, {2, 4}) + transform(2, 3) + shape(3, 0) + transform(4, 5) + shape(5, 1);
    const Result<Scene> scene = load(model({4, 4, 4}, {}) + model({1, 1, 1}, {{0, 0, 0, 1}}) + graph);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->geometries.size(), 1u);
    EXPECT_TRUE(validate(*scene));
    expect_refused(load(model({4, 4, 4}, {})), folder / "a.vox", "no visible voxel");
}

TEST_F(Vox, materials_become_what_they_look_like) {
    const std::array<std::uint8_t, 4> red = {255, 50, 50, 255};
    const auto kind = [&](const Dictionary& properties) { return vox::appearance(red, properties).material.kind; };
    EXPECT_EQ(kind({}), kernels::MATERIAL_DIFFUSE);
    EXPECT_EQ(kind({{"_type", "_diffuse"}}), kernels::MATERIAL_DIFFUSE);
    EXPECT_EQ(kind({{"_type", "_metal"}, {"_metal", "1"}}), kernels::MATERIAL_METAL);
    EXPECT_EQ(kind({{"_type", "_metal"}, {"_metal", "0.3"}}), kernels::MATERIAL_PRINCIPLED);
    EXPECT_EQ(kind({{"_type", "_metal"}, {"_weight", "0.7"}, {"_plastic", "1"}}), kernels::MATERIAL_PLASTIC);
    EXPECT_EQ(kind({{"_type", "_glass"}, {"_alpha", "0.5"}}), kernels::MATERIAL_DIELECTRIC);
    EXPECT_EQ(kind({{"_type", "_blend"}, {"_trans", "0.9"}}), kernels::MATERIAL_DIELECTRIC);
    EXPECT_EQ(kind({{"_type", "_blend"}, {"_metal", "0.9"}}), kernels::MATERIAL_PRINCIPLED);

    const auto glow = vox::appearance(red, {{"_type", "_emit"}, {"_emit", "0.5"}, {"_flux", "2"}});
    EXPECT_FLOAT_EQ(glow.material.emission.x, 50.0f);
    EXPECT_NEAR(glow.material.emission.y, 50.0f * srgb_decoded(50 / 255.0f), 1e-3f);

    const auto glass =
        vox::appearance(red, {{"_type", "_glass"}, {"_alpha", "0.5"}, {"_ior", "0.5"}, {"_rough", "0.1"}});
    EXPECT_FLOAT_EQ(glass.material.ior, 1.5f);
    EXPECT_FLOAT_EQ(vox::appearance(red, {{"_type", "_glass"}, {"_ri", "1.7"}, {"_ior", "0.3"}}).material.ior, 1.7f);
    // White light through four voxels of it has the colour of the palette.
    EXPECT_NEAR(std::exp(-4 * glass.material.absorption.y), srgb_decoded(50 / 255.0f), 1e-4f);
    EXPECT_EQ(glass.material.absorption.x, 0.0f);
}

TEST_F(Vox, properties_that_are_no_numbers_do_no_harm) {
    for (const std::string odd : {"", "nan", "inf", "-1e30", "1e30", "abc", "0x10"}) {
        for (const std::string type : {"_diffuse", "_metal", "_glass", "_emit", "_plastic", "_media", "_blend"}) {
            Dictionary properties = {{"_type", type}};
            for (const char* key :
                 {"_rough", "_ior", "_ri", "_d", "_g", "_alpha", "_metal", "_emit", "_flux", "_weight"})
                properties[key] = odd;
            Scene scene;
            const vox::Appearance look = vox::appearance({0, 0, 0, 0}, properties);
            if (look.medium) scene.media.push_back(*look.medium);
            if (!look.cloud) scene.materials.push_back({"m", look.material});
            const Result<void> valid = validate(scene);
            EXPECT_TRUE(valid) << type << " " << odd << ": " << valid.error().message;
        }
    }
}

TEST_F(Vox, cells_of_a_cloud_are_a_volume_without_a_surface) {
    const Result<Scene> scene = load(model({2, 1, 1}, {{0, 0, 0, 1}, {1, 0, 0, 2}}) +
                                     material(2, {{"_type", "_media"}, {"_d", "0.2"}, {"_g", "0.4"}}));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(validate(*scene)) << validate(*scene).error().message;
    ASSERT_EQ(scene->objects.size(), 2u);
    EXPECT_EQ(scene->objects[0].interior, -1);
    EXPECT_EQ(scene->objects[1].materials, std::vector<int>{-1});
    ASSERT_EQ(scene->objects[1].interior, 0);
    EXPECT_FLOAT_EQ(scene->media[0].scattering.x + scene->media[0].absorption.x, 0.2f);
    EXPECT_FLOAT_EQ(scene->media[0].g, 0.4f);
}

TEST_F(Vox, legacy_materials_are_read) {
    // Glass of weight 0.9 with roughness and index: bits 1 and 3.
    const std::string matt = chunk("MATT", number(1) + number(2) + raw(0.9f) + number(2 | 8) + raw(0.25f) + raw(0.4f));
    const Result<Scene> scene = load(model({1, 1, 1}, {{0, 0, 0, 1}}) + matt);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->materials[0].values.kind, kernels::MATERIAL_DIELECTRIC);
    EXPECT_FLOAT_EQ(scene->materials[0].values.roughness, 0.25f);
    EXPECT_FLOAT_EQ(scene->materials[0].values.ior, 1.4f);
}

std::string rich_file() {
    return model({3, 2, 1}, {{0, 0, 0, 1}, {1, 0, 0, 7}, {0, 1, 0, 9}}) + transform(0, 1) + group(1, {2}) +
           transform(2, 3, {{"_t", "1 2 3"}, {"_r", "17"}}) + shape(3, 0) + chunk("RGBA", std::string(1024, 'x')) +
           material(7, {{"_type", "_glass"}, {"_alpha", "0.5"}}) +
           chunk("LAYR", number(0) + dictionary({{"_name", "l"}}) + number(-1)) +
           chunk("MATT", number(1) + number(0) + raw(1.0f) + number(0));
}

TEST_F(Vox, a_file_cut_anywhere_is_refused) {
    const std::string whole = file_of(rich_file());
    ASSERT_TRUE(load_vox(write("a.vox", whole)));
    const std::size_t palette = whole.find("RGBA") + 12;
    for (std::size_t size = 0; size < whole.size(); ++size) {
        if (size > palette && size < palette + 1024 && size % 101) continue;  // one colour is like the other
        const auto path = write("a.vox", whole.substr(0, size));
        expect_refused(load_vox(path), path);
    }
}

TEST_F(Vox, any_length_that_lies_is_refused_or_harmless) {
    const std::string whole = file_of(rich_file());
    for (std::size_t at = 8; at + 4 <= whole.size() && at < 400; at += 2) {
        for (const std::int32_t lie : {-1, 0x7fffffff, 1 << 20, 0}) {
            std::string bytes = whole;
            bytes.replace(at, 4, raw(lie));
            const Result<Scene> scene = load_vox(write("a.vox", bytes));
            if (scene) EXPECT_TRUE(validate(*scene)) << "at " << at;
            else EXPECT_EQ(scene.error().message.find('\n'), std::string::npos);
        }
    }
}

TEST_F(Vox, what_is_out_of_bounds_is_named) {
    const auto refused = [&](const std::string& chunks, const std::string& why) {
        expect_refused(load(chunks), folder / "a.vox", why);
    };
    const std::string one = model({1, 1, 1}, {{0, 0, 0, 1}});
    refused(model({2, 2, 2}, {{0, 2, 0, 1}}), "voxel (0, 2, 0) lies outside");
    refused(model({100000, 2, 2}, {}), "edge");
    refused(model({-1, 2, 2}, {}), "edge");
    refused(chunk("XYZI", number(0)), "without a SIZE");
    refused(chunk("SIZE", number(1) + number(1) + number(1)), "SIZE");
    refused("", "no model");
    refused(one + transform(0, 1) + shape(1, 4), "model 4 of 1");
    refused(one + transform(0, 9), "node 9");
    refused(one + group(3, {}), "no root");
    refused(one + transform(0, 1) + group(1, {0}), "its own ancestor");
    refused(one + transform(0, 1, {{"_r", "3"}}) + shape(1, 0), "rotation");
    refused(one + transform(0, 1, {{"_t", "1 2"}}) + shape(1, 0), "translation");
    refused(one + transform(0, 1) + transform(0, 1) + shape(1, 0), "two nodes");
    refused(model({2048, 2048, 2048}, {{0, 0, 0, 1}}), "cells");
    expect_refused(load_vox(write("b.vox", file_of(one, 42))), folder / "b.vox", "version is 42");
    expect_refused(load_vox(folder / "absent.vox"), folder / "absent.vox", "no such file");
}

TEST_F(Vox, a_graph_that_multiplies_without_end_is_refused) {
    // Each group holds the next one twice: 2^30 placements in 31 nodes.
    std::string chunks = model({1, 1, 1}, {{0, 0, 0, 1}}) + transform(0, 1);
    for (int i = 1; i <= 30; ++i) chunks += group(i, {i + 1, i + 1});
    expect_refused(load(chunks + shape(31, 0)), folder / "a.vox", "more than");
    std::string deep = model({1, 1, 1}, {{0, 0, 0, 1}}) + transform(0, 1);
    for (int i = 1; i < 5000; ++i) deep += group(i, {i + 1});
    expect_refused(load(deep + shape(5000, 0)), folder / "a.vox", "deeper");
}

TEST_F(Vox, reads_real_files) {
    struct Case {
        const char* file;
        std::size_t objects, geometries, voxels;  // voxels: of all geometries, once each
    };
    const Case cases[] = {{"vox/ephtracy/monu3.vox", 1, 1, 848469},
                          {"vox/ephtracy/chr_knight.vox", 1, 1, 398},
                          {"vox/ephtracy/deer.vox", 1, 1, 355},
                          {"vox/scene/test_groups.vox", 19, 15, 1682},
                          {"vox/scene/test_multiple_model_scene.vox", 104, 41, 6053},
                          {"vox/vengi/test_material.vox", 12, 12, 768000},
                          {"vox/wrldtmpl8/rock.vox", 1, 1, 2802},
                          {"vox/bevy/cloud.vox", 6, 6, 49211}};
    if (!std::filesystem::exists(data_folder / "vox")) GTEST_SKIP() << "no " << data_folder / "vox";
    for (const Case& c : cases) {
        const Result<Scene> scene = load_vox(data_folder / c.file);
        ASSERT_TRUE(scene) << scene.error().message;
        const Result<void> valid = validate(*scene);
        EXPECT_TRUE(valid) << c.file << ": " << valid.error().message;
        EXPECT_EQ(scene->objects.size(), c.objects) << c.file;
        EXPECT_EQ(scene->geometries.size(), c.geometries) << c.file;
        std::size_t voxels = 0;
        for (const Geometry& geometry : scene->geometries)
            voxels += std::get<VoxelGeometry>(geometry.data).tree->voxel_count();
        EXPECT_EQ(voxels, c.voxels) << c.file;
    }
}

TEST_F(Vox, models_of_a_real_scene_do_not_overlap) {
    // The file is a row of small test models on a plane, apart from each other.
    const auto path = data_folder / "vox/scene/test_groups.vox";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
    const Result<Scene> scene = load_vox(path);
    ASSERT_TRUE(scene);
    std::set<std::array<int, 3>> taken;
    std::size_t voxels = 0;
    for (const Object& object : scene->objects) {
        const Centers own = centers(*scene, object);
        taken.insert(own.begin(), own.end());
        voxels += own.size();
        for (const auto& center : own)
            for (const int coordinate : center) ASSERT_EQ(std::abs(coordinate) % 2, 1);  // on the lattice
    }
    EXPECT_GT(taken.size(), voxels * 9 / 10);
}

}  // namespace
}  // namespace spinel
