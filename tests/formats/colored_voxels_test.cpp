#include "formats/colored_voxels.h"

#include <gtest/gtest.h>

#include <map>

#include "scene/validate.h"
#include "test_files.h"

namespace spinel::colored_voxels_test {
namespace {

using ColoredVoxels = FileTest;
using Cell = std::array<int, 3>;

// Red of each voxel's colour, in hundredths, by its place in world space.
std::map<Cell, int> reds(const Result<Scene>& scene) {
    EXPECT_TRUE(scene) << scene.error().message;
    std::map<Cell, int> result;
    if (!scene) return result;
    EXPECT_TRUE(validate(*scene)) << validate(*scene).error().message;
    for (const Object& object : scene->objects)
        std::get<VoxelGeometry>(scene->geometries[std::size_t(object.geometry)].data)
            .tree->for_each([&](ivec3 cell, std::uint16_t palette) {
                const vec3 at = object.transform * vec4(vec3(cell), 1);
                result[{int(at.x), int(at.y), int(at.z)}] =
                    int(std::lround(100 * scene->materials[palette - 1u].values.color.x));
            });
    return result;
}

void expect_every_cut_refused(const FileTest&, const std::filesystem::path& path, const std::string& whole,
                              std::size_t from = 0) {
    for (std::size_t size = from; size < whole.size(); ++size) {
        std::ofstream(path, std::ios::binary) << whole.substr(0, size);
        expect_refused(load_model(path), path);
    }
}

// One matrix of 2×1×2 at (5, 6, 7); its first voxel red, its last green.
std::string qubicle(std::uint32_t right_handed, bool packed) {
    std::string file = raw(0x101u) + raw(0u) + raw(right_handed) + raw(std::uint32_t(packed)) + raw(0u) + raw(1u);
    file += std::string("\3abc");
    for (const int v : {2, 1, 2, 5, 6, 7}) file += raw(v);
    const std::uint32_t red = 0xff0000ff, green = 0xff00ff00, none = 0x00123456;
    if (packed) return file + raw(red) + raw(6u) + raw(2u) + raw(1u) + raw(none) + raw(green) + raw(6u);
    return file + raw(red) + raw(none) + raw(none) + raw(green);
}

TEST_F(ColoredVoxels, qubicle_files_are_read_packed_or_not_and_of_either_hand) {
    for (const bool packed : {false, true}) {
        const Result<Scene> right = load_qubicle(write("a.qb", qubicle(1, packed)));
        EXPECT_EQ(reds(right), (std::map<Cell, int>{{{5, 6, 7}, 100}, {{6, 6, 8}, 0}}));
        EXPECT_EQ(right->objects[0].name, "abc");
        // Away is −z here.
        EXPECT_EQ(reds(load_qubicle(write("a.qb", qubicle(0, packed)))),
                  (std::map<Cell, int>{{{5, 6, -8}, 100}, {{6, 6, -9}, 0}}));
        expect_every_cut_refused(*this, folder / "a.qb", qubicle(1, packed));
    }
}

TEST_F(ColoredVoxels, kv6_files_stand_upright) {
    // 1×2×3, one voxel on top at y = 1 (z grows downwards), red.
    std::string file = "Kvxl" + raw(1) + raw(2) + raw(3) + raw(0.0f) + raw(0.0f) + raw(0.0f) + raw(1u);
    file += std::string("\x00\x00\xff\x80\x00\x00\x00\x00", 8);
    file += raw(1u) + raw(std::uint16_t(0)) + raw(std::uint16_t(1));
    EXPECT_EQ(reds(load_kv6(write("a.kv6", file))), (std::map<Cell, int>{{{0, 2, 1}, 100}}));
    expect_every_cut_refused(*this, folder / "a.kv6", file);
}

TEST_F(ColoredVoxels, binvox_files_run_along_y_first) {
    // 2×2×2: three empty cells, then two full, then three empty: (0, y 1, z 1) and (1, 0, 0).
    const std::string head = "#binvox 1\ndim 2 2 2\ntranslate 0 0 0\nscale 1\ndata\n";
    const std::string file = head + std::string("\0\3\1\2\0\3", 6);
    const auto voxels = reds(load_binvox(write("a.binvox", file)));
    ASSERT_EQ(voxels.size(), 2u);
    EXPECT_TRUE(voxels.count({0, 1, 1}) && voxels.count({1, 0, 0}));
    expect_every_cut_refused(*this, folder / "a.binvox", file);
    const auto path = write("a.binvox", head + std::string("\1\x09", 2));
    expect_refused(load_binvox(path), path, "more voxels");
}

TEST_F(ColoredVoxels, real_files_are_read) {
    struct Case {
        const char* file;
        std::size_t objects, voxels;
    };
    if (!std::filesystem::exists(data_folder / "vox")) GTEST_SKIP() << "no " << data_folder / "vox";
    for (const Case& c :
         {Case{"vox/otherformats/chr_knight.qb", 17, 2612}, Case{"vox/otherformats/voxlap5.kv6", 1, 2480},
          Case{"vox/otherformats/test.binvox", 1, 78075}}) {
        const Result<Scene> scene = load_model(data_folder / c.file);
        EXPECT_EQ(reds(scene).size(), c.voxels) << c.file;
        EXPECT_EQ(scene->objects.size(), c.objects) << c.file;
    }
}

}  // namespace
}  // namespace spinel::colored_voxels_test
