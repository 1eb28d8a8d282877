#include "formats/raw_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "scene/validate.h"
#include "test_files.h"

namespace spinel::raw_volume_test {
namespace {

using RawVolume = FileTest;

TEST_F(RawVolume, a_bit_volume_fills_the_unit_cube_with_y_in_the_bits) {
    std::string bytes(4096, '\0');
    bytes.replace(4 * (3 + 32 * 7), 4, raw(std::uint32_t(1) << 20));  // voxel (3, 20, 7)
    const Result<Scene> scene = load_bits(write("a.bits", bytes));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(validate(*scene)) << validate(*scene).error().message;
    const Grid& grid = scene->grids[0];
    EXPECT_EQ(grid.samples->size(), ivec3(32));
    const std::vector<float> values = grid.samples->dense();
    EXPECT_EQ(std::accumulate(values.begin(), values.end(), 0.0f), 1.0f);
    EXPECT_EQ(values[3 + 32 * (20 + 32 * 7)], 1.0f);
    EXPECT_EQ(grid.index_to_local * vec4(32, 32, 32, 1), vec3(1.0f));
    EXPECT_EQ(grid.filter, Filter::linear);
    EXPECT_FLOAT_EQ(scene->media[0].scattering.x, 10.0f);
    for (const std::size_t size : {0, 4095, 4097}) {
        const auto path = write("b.bits", std::string(size, '\0'));
        expect_refused(load_bits(path), path, "4096 bytes");
    }
}

TEST_F(RawVolume, the_bunny_is_a_bunny) {
    const auto path = std::filesystem::path(SPINEL_SOURCE_DIR) / "examples/bunny32.bits";
    const Result<Scene> scene = load_bits(path);
    ASSERT_TRUE(scene) << scene.error().message;
    const std::vector<float> values = scene->grids[0].samples->dense();
    const float solid = std::accumulate(values.begin(), values.end(), 0.0f) / float(values.size());
    EXPECT_GT(solid, 0.1f);
    EXPECT_LT(solid, 0.4f);
    float low = 0, high = 0;  // it stands on its feet: more below than above
    for (std::size_t i = 0; i < values.size(); ++i) ((i / 32 % 32 < 16) ? low : high) += values[i];
    EXPECT_GT(low, 1.5f * high);
}

TEST_F(RawVolume, a_saved_volume_comes_back_to_the_bit) {
    Scene scene;
    Grid grid;
    std::vector<float> values;
    for (int i = 0; i < 12; ++i) values.push_back(std::exp(float(i)) / 3);
    grid.samples = *build_grid({3, 2, 2}, values);
    grid.index_to_local = mat4x3(0.1f, 0, 0, 0, 0.3f, 0, 0, 0, 7, -1, 1e-3f, 5);
    grid.filter = Filter::nearest;
    scene.grids.push_back(grid);
    const auto path = folder / "a.svol";
    const Result<Notes> saved = save_svol(scene, path);
    ASSERT_TRUE(saved) << saved.error().message;
    const Result<Scene> back = load_svol(path);
    ASSERT_TRUE(back) << back.error().message;
    ASSERT_TRUE(validate(*back)) << validate(*back).error().message;
    EXPECT_EQ(back->grids[0].samples->size(), ivec3(3, 2, 2));
    EXPECT_EQ(back->grids[0].samples->dense(), values);
    EXPECT_EQ(back->grids[0].index_to_local, grid.index_to_local);
    EXPECT_EQ(back->grids[0].filter, Filter::nearest);
    EXPECT_FLOAT_EQ(back->media[0].scattering.x * 14, 10.0f);  // along the longest edge, 2 · 7

    scene.grids[0].index_to_local[0].y = 0.1f;
    expect_refused(save_svol(scene, folder / "b.svol"), folder / "b.svol", "not aligned");
    EXPECT_FALSE(std::filesystem::exists(folder / "b.svol"));
    expect_refused(save_svol(Scene{}, folder / "b.svol"), folder / "b.svol", "0 grids");
}

TEST_F(RawVolume, integers_become_0_to_1) {
    const std::string head = "spinel volume 1\nsize 2 1 1\ntype ";
    const Result<Scene> u8 = load_svol(write("a.svol", head + "u8\n\n" + std::string("\x00\xff", 2)));
    ASSERT_TRUE(u8) << u8.error().message;
    EXPECT_EQ(u8->grids[0].samples->dense(), (std::vector<float>{0, 1}));
    const Result<Scene> u16 =
        load_svol(write("b.svol", head + "u16\r\n\r\n" + raw(std::uint16_t(0x8000)) + raw(std::uint16_t(0xffff))));
    ASSERT_TRUE(u16) << u16.error().message;
    EXPECT_NEAR(u16->grids[0].samples->at({0, 0, 0}), 0.5f, 1e-4f);
    EXPECT_EQ(u16->grids[0].samples->at({1, 0, 0}), 1.0f);
}

TEST_F(RawVolume, errors_name_the_line_and_what_is_allowed) {
    const auto refused = [&](const std::string& bytes, const std::string& why) {
        const auto path = write("a.svol", bytes);
        expect_refused(load_svol(path), path, why);
    };
    const std::string head = "spinel volume 1\n";
    refused("", "spinel volume 1");
    refused("hello\n\n", "spinel volume 1");
    refused(head + "size 2 2\n\n", "line 2: size needs three whole numbers");
    refused(head + "size 2 2 x\n\n", "line 2");
    refused(head + "size 2 2 0\n\n", "an edge must be");
    refused(head + "size 2 2 99999999999999\n\n", "line 2");
    refused(head + "size 8192 8192 8192\ntype f32\n\n", "more than");
    refused(head + "size 1 1 1\n\n", "no type");
    refused(head + "type u8\n\n", "no size");
    refused(head + "type i8\n\n", "u8, u16 or f32");
    refused(head + "type u8\ntype u8\n\n", "twice");
    refused(head + "spacing 1 0 1\n\n", "positive");
    refused(head + "spacing 1 nan 1\n\n", "positive");
    refused(head + "origin inf 0 0\n\n", "origin needs three numbers");
    refused(head + "filter cubic\n\n", "linear or nearest");
    refused(head + "colour red\n\n", "unknown key 'colour'");
    refused(head + "size 2 1 1\ntype u8\n", "header has no end");
    refused(head + "size 2 1 1\ntype u8\n\nx", "needs 2 bytes");
    refused(head + "size 2 1 1\ntype u8\n\nxyz", "needs 2 bytes");
    refused(head + "size 2 1 1\ntype f32\n\n" + raw(1.0f) + raw(NAN), "not finite");
    refused(head + "# " + std::string(5000, 'x') + "\n\n", "header has no end");
    expect_refused(load_svol(folder / "absent.svol"), folder / "absent.svol", "no such file");
}

}  // namespace
}  // namespace spinel::raw_volume_test
