#include "formats/vox.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "formats/vox_file.h"
#include "formats/vox_material.h"
#include "image/palette.h"
#include "image/tone_map.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"
#include "scene/validate.h"
#include "vox_chunks.h"

namespace spinel::vox_test {
namespace {

class Vox : public FileTest {
  protected:
    Result<Scene> load(const std::string& chunks) { return load_vox(write("a.vox", file_of(chunks))); }
};

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

// A transform with keys at frames, each a translation along x.
std::string moving(int id, int child, const std::vector<std::pair<int, int>>& keys) {
    std::string content =
        number(id) + dictionary({}) + number(child) + number(-1) + number(-1) + number(int(keys.size()));
    for (const auto& [frame, x] : keys)
        content += dictionary({{"_f", std::to_string(frame)}, {"_t", std::to_string(x) + " 0 0"}});
    return chunk("nTRN", content);
}

TEST_F(Vox, a_frame_of_an_animation_can_be_chosen) {
    const std::string pack = chunk("PACK", number(2));
    auto path = write("a.vox", file_of(pack + model({1, 1, 1}, {{0, 0, 0, 1}}) + model({2, 1, 1}, {{0, 0, 0, 1}})));
    const auto width = [](const Result<Scene>& scene) {
        return std::get<VoxelGeometry>(scene->geometries[0].data).tree->size().x;
    };
    EXPECT_EQ(width(load_vox(path, {.frame = 0, .heightmap = {}})), 1);
    EXPECT_EQ(width(load_vox(path, {.frame = 1, .heightmap = {}})), 2);
    expect_refused(load_vox(path, {.frame = 2, .heightmap = {}}), path, "its frames are 0 … 1");

    // In a scene graph keys hold until the next: of the place, and of the shape's model.
    const std::string shapes = chunk("nSHP", number(3) + dictionary({}) + number(2) + number(0) +
                                                 dictionary({{"_f", "0"}}) + number(1) + dictionary({{"_f", "4"}}));
    path =
        write("b.vox", file_of(model({1, 1, 1}, {{0, 0, 0, 1}}) + model({2, 1, 1}, {{0, 0, 0, 1}}) + transform(0, 1) +
                               group(1, {2}) + moving(2, 3, {{0, 10}, {2, 20}, {7, 30}}) + shapes));
    const int places[] = {10, 10, 20, 20, 20, 20, 20, 30};
    for (int frame = 0; frame < 8; ++frame) {
        const Result<Scene> scene = load_vox(path, {.frame = frame, .heightmap = {}});
        ASSERT_TRUE(scene) << scene.error().message;
        const int w = width(scene);
        EXPECT_EQ(w, frame < 4 ? 1 : 2) << frame;
        EXPECT_EQ(scene->objects[0].transform[3].x, float(places[frame] - w / 2)) << frame;
    }
    expect_refused(load_vox(path, {.frame = 8, .heightmap = {}}), path, "0 … 7");
}

std::string setting(const Dictionary& d) { return chunk("rOBJ", dictionary(d)); }

TEST_F(Vox, render_settings_become_light_ground_and_film) {
    const std::string one = model({1, 1, 1}, {{0, 0, 0, 1}});
    const std::string sun =
        setting({{"_type", "_inf"}, {"_i", "0.5"}, {"_k", "255 255 255"}, {"_angle", "90 0"}, {"_area", "0.1"}});
    const std::string sky = setting({{"_type", "_uni"}, {"_i", "0.25"}, {"_k", "255 0 255"}});
    const std::string rest = setting({{"_type", "_ground"}, {"_color", "255 0 0"}}) +
                             setting({{"_type", "_setting"}, {"_ground", "0"}}) +
                             setting({{"_type", "_film"}, {"_expo", "4"}, {"_aces", "1"}}) +
                             setting({{"_type", "_fog_uni"}, {"_d", "0.5"}, {"_k", "0 255 0"}, {"_g", "0.5"}});
    const Result<Scene> scene = load(one + sun + sky + rest);
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(validate(*scene)) << validate(*scene).error().message;
    EXPECT_EQ(std::get<ConstantEnvironment>(scene->environment).radiance, vec3(0.25f, 0, 0.25f));
    ASSERT_EQ(scene->lights.size(), 1u);
    const auto& light = std::get<DirectionalLight>(scene->lights[0].data);
    EXPECT_NEAR(light.direction.y, -1.0f, 1e-6f);  // from straight above
    EXPECT_NEAR(light.irradiance.x, 0.5f * 3.14159265f, 1e-5f);
    EXPECT_NEAR(light.angular_radius, 5.7296f, 1e-3f);
    EXPECT_EQ(scene->surroundings.ground_color, vec3(1, 0, 0));
    EXPECT_FALSE(scene->surroundings.ground);
    EXPECT_FLOAT_EQ(scene->surroundings.fog_density, 0.005f);
    EXPECT_FLOAT_EQ(scene->film.exposure, 2.0f);
    EXPECT_EQ(scene->film.tone_map, ToneMap::aces);

    const std::string air =
        setting({{"_type", "_env"}, {"_mode", "2"}}) + setting({{"_type", "_atm"}, {"_mie_d", "0.8"}});
    const Result<Scene> clear = load(one + sun + sky + air);
    ASSERT_TRUE(clear && validate(*clear));
    EXPECT_FLOAT_EQ(std::get<SkyEnvironment>(clear->environment).haze, 2.0f);
    EXPECT_FALSE(std::get<SkyEnvironment>(clear->environment).sun);

    const Result<Scene> picture = load(one + sun + sky + setting({{"_type", "_env"}, {"_mode", "1"}}) +
                                       setting({{"_type", "_ibl"}, {"_path", "night.hdr"}}));
    ASSERT_EQ(picture->notes.size(), 1u);
    EXPECT_NE(picture->notes[0].find("night.hdr"), std::string::npos);

    const Result<Scene> plain = load(one);
    EXPECT_TRUE(std::holds_alternative<std::monostate>(plain->environment));
    EXPECT_TRUE(plain->lights.empty() && plain->surroundings.ground);
}

TEST_F(Vox, odd_settings_do_no_harm) {
    for (const std::string odd : {"", "nan", "1e38 1e38 1e38", "-1e38 2", "x y z"}) {
        std::string chunks = model({1, 1, 1}, {{0, 0, 0, 1}});
        for (const char* type : {"_inf", "_uni", "_env", "_atm", "_fog_uni", "_ground", "_setting", "_film"}) {
            Dictionary d = {{"_type", type}};
            for (const char* key :
                 {"_i", "_k", "_angle", "_area", "_mode", "_mie_d", "_d", "_g", "_color", "_ground", "_expo", "_aces"})
                d[key] = odd;
            chunks += setting(d);
        }
        Dictionary camera;
        for (const char* key : {"_mode", "_focus", "_angle", "_radius", "_frustum", "_fov"}) camera[key] = odd;
        const Result<Scene> scene = load(chunks + chunk("rCAM", number(0) + dictionary(camera)));
        ASSERT_TRUE(scene) << scene.error().message;
        const Result<void> valid = validate(*scene);
        EXPECT_TRUE(valid) << odd << ": " << valid.error().message;
    }
}

TEST_F(Vox, cameras_that_were_set_are_read) {
    const auto camera = [](const Dictionary& d) { return chunk("rCAM", number(0) + dictionary(d)); };
    const Result<Scene> scene = load(
        model({1, 1, 1}, {{0, 0, 0, 1}}) +
        camera({{"_mode", "pers"}, {"_focus", "0 0 0"}, {"_angle", "0 0 0"}, {"_radius", "1"}, {"_fov", "45"}}) +
        camera({{"_mode", "pers"}, {"_focus", "1 2 3"}, {"_angle", "0 0 0"}, {"_radius", "50"}, {"_fov", "60"}}) +
        camera({{"_mode", "orth"}, {"_focus", "0 0 0"}, {"_angle", "90 0 0"}, {"_radius", "10"}, {"_frustum", "0.5"}}));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(validate(*scene)) << validate(*scene).error().message;
    ASSERT_EQ(scene->cameras.size(), 2u);
    EXPECT_EQ(scene->cameras[0].name, "camera 1");
    EXPECT_EQ(scene->cameras[0].at, vec3(1, 3, -2));
    EXPECT_NEAR(glm::distance(scene->cameras[0].from, vec3(1, 3, 48)), 0.0f, 1e-4f);  // looks along the file's +y
    EXPECT_EQ(scene->cameras[0].fov, 60.0f);
    EXPECT_EQ(scene->cameras[1].kind, Camera::Kind::orthographic);
    EXPECT_EQ(scene->cameras[1].height, 10.0f);
    EXPECT_NEAR(scene->cameras[1].from.y, 10.0f, 1e-4f);  // from above
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

    // Two stops for a step of the power.
    const auto glow = vox::appearance(red, {{"_type", "_emit"}, {"_emit", "0.5"}, {"_flux", "2"}});
    EXPECT_FLOAT_EQ(glow.material.emission.x, 8.0f);
    EXPECT_NEAR(glow.material.emission.y, 8.0f * srgb_decoded(50 / 255.0f), 1e-3f);
    EXPECT_FLOAT_EQ(vox::appearance(red, {{"_type", "_emit"}, {"_emit", "1"}, {"_flux", "9"}}).material.emission.x,
                    256.0f);

    // F0 of index 1.5 is 0.04; half of it is that of index 1.33.
    const auto dull = vox::appearance(red, {{"_type", "_metal"}, {"_metal", "0.2"}, {"_sp", "0.5"}});
    EXPECT_NEAR(dull.material.ior, 1.3294f, 1e-3f);

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
        for (const std::string type :
             {"_diffuse", "_metal", "_glass", "_emit", "_plastic", "_media", "_cloud", "_blend"}) {
            Dictionary properties = {{"_type", type}};
            for (const char* key : {"_rough", "_ior", "_ri", "_d", "_att", "_sp", "_g", "_alpha", "_trans", "_metal",
                                    "_emit", "_flux", "_weight", "_media"})
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
}  // namespace spinel::vox_test
