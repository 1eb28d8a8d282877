// NanoVDB files as NanoVDB itself writes them.

#define NANOVDB_USE_BLOSC
#define NANOVDB_USE_ZIP
#include "formats/nvdb.h"

#include <gtest/gtest.h>
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>

#include "formats/sparse_samples.h"
#include "scene/validate.h"
#include "test_files.h"

namespace spinel::nvdb_test {
namespace {

using Nvdb = FileTest;
using nanovdb::Coord;
using nanovdb::io::Codec;

// A diagonal of 40 voxels, far enough to leave a leaf and a node.
template <class BuildT>
nanovdb::GridHandle<> diagonal(const std::string& name) {
    nanovdb::GridBuilder<float, BuildT> builder(0.0f);
    auto accessor = builder.getAccessor();
    for (int i = 0; i < 40; ++i) accessor.setValue(Coord(5 * i - 20, i, -2 * i), float(i + 1) / 4);
    return builder.template getHandle<>(0.5, nanovdb::Vec3d(10, 20, 30), name);
}

void expect_diagonal(const Grid& grid, float tolerance) {
    const glm::mat4 to_index = glm::inverse(glm::mat4(grid.index_to_local));
    for (int i = 0; i < 40; ++i) {
        const vec3 world = vec3(10, 20, 30) + 0.5f * vec3(5 * i - 20, i, -2 * i);
        const vec3 p = vec3(to_index * vec4(world, 1));
        const ivec3 sample(glm::floor(p));
        EXPECT_NEAR(glm::length(p - vec3(sample) - 0.5f), 0, 1e-3f) << "sample i sits at i + 1/2";
        EXPECT_NEAR(grid.samples->at(sample), float(i + 1) / 4, tolerance);
        EXPECT_NEAR(grid.samples->at(sample + ivec3(0, 1, 0)), 0, tolerance);
    }
    EXPECT_LT(grid.samples->stored_count(), grid.samples->table().size() / 4);
}

TEST_F(Nvdb, every_codec) {
    for (const Codec codec : {Codec::NONE, Codec::ZIP, Codec::BLOSC}) {
        const auto path = folder / "a.nvdb";
        nanovdb::io::writeGrid(path.string(), diagonal<float>("density"), codec);
        const Result<Scene> scene = load_nvdb(path);
        ASSERT_TRUE(scene) << scene.error().message;
        EXPECT_TRUE(validate(*scene));
        ASSERT_EQ(scene->grids.size(), 1u);
        EXPECT_EQ(scene->grids[0].name, "density");
        expect_diagonal(scene->grids[0], 0);
    }
}

TEST_F(Nvdb, quantised_grids_and_several_in_a_file) {
    std::vector<nanovdb::GridHandle<>> handles;
    handles.push_back(diagonal<nanovdb::Fp4>("a"));
    handles.push_back(diagonal<nanovdb::Fp8>("a"));
    handles.push_back(diagonal<nanovdb::Fp16>("b"));
    handles.push_back(diagonal<nanovdb::FpN>("b"));
    const auto path = folder / "a.nvdb";
    nanovdb::io::writeGrids(path.string(), handles, Codec::ZIP);
    const Result<Scene> scene = load_nvdb(path);
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ(scene->grids.size(), 4u);
    const float tolerances[] = {0.7f, 0.05f, 2e-4f, 0.7f};
    for (std::size_t i = 0; i < 4; ++i) expect_diagonal(scene->grids[i], tolerances[i]);
    EXPECT_EQ(scene->grids[1].name, "a[1]");
    LoadOptions one;
    one.grid = "b";
    const Result<Scene> chosen = load_nvdb(path, one);
    ASSERT_TRUE(chosen) << chosen.error().message;
    EXPECT_EQ(chosen->grids.size(), 1u);
    one.grid = "c";
    expect_refused(load_nvdb(path, one), path, "it has 'a', 'a[1]', 'b', 'b[1]'");
}

TEST_F(Nvdb, sparse_grids_of_large_boxes_are_what_nanovdb_has) {
    nanovdb::GridBuilder<float> builder(0.125f);
    auto accessor = builder.getAccessor();
    accessor.setValue(Coord(-77, -90, -103), 1);
    accessor.setValue(Coord(1900, 2000, 1700), 2);
    for (int z = 0; z <= 40; ++z)
        for (int y = 0; y <= 140; ++y)
            for (int x = 0; x <= 300; ++x) accessor.setValue(Coord(x, y, z), 3);
    const auto handle = builder.getHandle<>(1, nanovdb::Vec3d(0), "density");
    const auto path = folder / "a.nvdb";
    nanovdb::io::writeGrid(path.string(), handle, Codec::ZIP);
    const Result<Scene> scene = load_nvdb(path);
    ASSERT_TRUE(scene) << scene.error().message;
    const auto* grid = handle.grid<float>();
    const int different = test::expect_sparse_samples(scene->grids.at(0), 0.125f, [&](ivec3 place) {
        return grid->tree().getValue(Coord(place.x, place.y, place.z));
    });
    EXPECT_GT(different, 2000);
}

// Every word that leads somewhere is made to lead nowhere, one at a time: those that are 0 are tiles of empty space, of
// which the tables are full.
TEST_F(Nvdb, damage_is_refused_or_harmless) {
    const auto path = folder / "a.nvdb";
    nanovdb::GridBuilder<float> builder(0.0f);
    auto accessor = builder.getAccessor();
    for (int i = 0; i < 3; ++i) accessor.setValue(Coord(70 * i + 1, 9 * i, 2), 1.0f);  // two nodes, three leaves
    nanovdb::io::writeGrid(path.string(), builder.getHandle<>(0.5, nanovdb::Vec3d(10, 20, 30), "density"), Codec::NONE);
    const std::string bytes = bytes_of(path);
    for (const std::size_t size :
         {std::size_t(0), std::size_t(10), std::size_t(100), bytes.size() / 2, bytes.size() - 1})
        expect_refused(load_nvdb(write("b.nvdb", bytes.substr(0, size))), folder / "b.nvdb");
    std::string lies = bytes;
    lies.replace(16, 8, raw(std::uint64_t(1) << 33));  // the grid's size in memory
    expect_refused(load_nvdb(write("b.nvdb", lies)), folder / "b.nvdb", "is not in the file's");
    // The grid stands at the file's end, its size a multiple of the words'.
    int damaged = 0, refused = 0;
    for (std::size_t at = bytes.size() % 8; at + 8 <= bytes.size(); at += 8) {
        std::uint64_t word;
        std::memcpy(&word, bytes.data() + at, 8);
        if (word == 0) continue;
        std::string wrong = bytes;
        wrong.replace(at, 8, raw(std::uint64_t(0x123456789abcull) * (at + 1)));
        const Result<Scene> scene = load_nvdb(write("b.nvdb", wrong));
        if (scene) {
            EXPECT_TRUE(validate(*scene)) << at;
        } else expect_refused(scene, folder / "b.nvdb");
        ++damaged;
        refused += !scene;
    }
    EXPECT_GT(damaged, 60);
    EXPECT_GT(refused, 10);
}

}  // namespace
}  // namespace spinel::nvdb_test
