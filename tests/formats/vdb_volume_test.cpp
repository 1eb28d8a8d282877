// Volumes as OpenVDB itself writes them. Its trees take seconds each to compile, so that here all are of floats;
// wind_and_count.vdb holds what else is needed: grids of vectors and of integers, one voxel each.

#include "formats/vdb_volume.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include "formats/sparse_samples.h"
#include "formats/vdb.h"
#include "scene/validate.h"
#include "spinel/formats.h"
#include "test_files.h"

namespace spinel::vdb_volume_test {
namespace {

using VdbVolume = FileTest;
using openvdb::Coord;

void write_vdb(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids) {
    openvdb::io::File file(path.string());
    file.write(grids);
    file.close();
}

TEST_F(VdbVolume, samples_stand_where_openvdb_has_them) {
    openvdb::initialize();
    // Turned, sheared and moved.
    const openvdb::math::Mat4d m(0.0, 0.5, 0.0, 0.0, -0.25, 0.0, 0.1, 0.0, 0.0, 0.0, 2.0, 0.0, 7.0, 8.0, 9.0, 1.0);
    for (const bool half : {false, true}) {
        auto grid = openvdb::FloatGrid::create(0.25f);
        grid->setName("density");
        grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
        grid->setSaveFloatAsHalf(half);
        std::vector<Coord> places;
        for (int i = 0; i < 30; ++i) {
            places.emplace_back(3 * i - 40, 17 - i, i * i % 23);
            grid->tree().setValueOn(places.back(), float(i) / 8 - 1);
        }
        const auto path = folder / "a.vdb";
        write_vdb(path, {grid});
        const Result<Scene> scene = load_vdb(path, {});
        ASSERT_TRUE(scene) << scene.error().message;
        EXPECT_TRUE(validate(*scene));
        const Grid& read = scene->grids.at(0);
        EXPECT_EQ(read.background, 0.25f);
        const glm::dmat4 to_index = glm::inverse(glm::dmat4(glm::mat4(read.index_to_local)));
        for (const Coord& place : places) {
            const openvdb::Vec3d world = grid->indexToWorld(place);
            const vec3 p = vec3(to_index * glm::dvec4(world[0], world[1], world[2], 1));
            const ivec3 sample(glm::floor(p));
            EXPECT_NEAR(glm::length(p - vec3(sample) - 0.5f), 0, 1e-3f);
            EXPECT_EQ(read.samples->at(sample), grid->tree().getValue(place));
            EXPECT_EQ(read.samples->at(sample - 1), grid->tree().getValue(place.offsetBy(-1)));
        }
    }
}

TEST_F(VdbVolume, several_grids_vectors_tiles_and_level_sets) {
    openvdb::initialize();
    auto tiles = openvdb::FloatGrid::create(0);
    tiles->setName("density");
    tiles->fill(openvdb::CoordBBox(Coord(0), Coord(511)), 0.5f);
    openvdb::io::File others(SPINEL_SOURCE_DIR "/tests/formats/wind_and_count.vdb");
    others.open();
    const auto wind = others.readGrid("wind"), count = others.readGrid("count");
    // A sphere of radius 5, in a band of three voxels.
    auto sphere = openvdb::FloatGrid::create(1.5f);
    sphere->setName("density");
    sphere->setGridClass(openvdb::GRID_LEVEL_SET);
    sphere->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    for (int z = -14; z <= 14; ++z)
        for (int y = -14; y <= 14; ++y)
            for (int x = -14; x <= 14; ++x) {
                const float distance = 0.5f * glm::length(vec3(ivec3(x, y, z))) - 5;
                if (std::abs(distance) < 1.5f) sphere->tree().setValueOn(Coord(x, y, z), distance);
                else if (distance < 0) sphere->tree().setValueOff(Coord(x, y, z), -1.5f);
            }
    const auto path = folder / "a.vdb";
    write_vdb(path, {tiles, wind, sphere, count});
    const Result<Scene> scene = load_vdb(path, {});
    ASSERT_TRUE(scene) << scene.error().message;
    const Result<void> valid = validate(*scene);
    EXPECT_TRUE(valid) << valid.error().message;
    ASSERT_EQ(scene->grids.size(), 3u);
    EXPECT_LT(scene->grids[0].samples->stored_count(), 10u) << "tiles take no room";
    EXPECT_EQ(scene->grids[1].name, "wind");
    EXPECT_EQ(scene->grids[1].samples->channels(), 3);
    EXPECT_EQ(scene->grids[2].name, "density[1]");
    EXPECT_EQ(scene->grids[2].samples->minimum(), -1.5f);
    EXPECT_EQ(scene->grids[2].samples->maximum(), 1.5f);
    EXPECT_TRUE(scene->grids[2].level_set);
    EXPECT_FALSE(scene->grids[0].level_set);
    EXPECT_TRUE(std::get<VolumeGeometry>(scene->geometries[2].data).surface) << "a level set is a surface";
    ASSERT_EQ(scene->objects[2].materials.size(), 1u);
    EXPECT_GE(scene->objects[2].materials[0], 0);
    EXPECT_EQ(scene->objects[2].interior, -1);
    ASSERT_EQ(scene->notes.size(), 1u);
    EXPECT_NE(scene->notes[0].find("'count'"), std::string::npos);
    LoadOptions one;
    one.grid = "wind";
    const Result<Scene> chosen = load_vdb(path, one);
    ASSERT_TRUE(chosen) << chosen.error().message;
    EXPECT_EQ(chosen->grids.size(), 1u);
    one.grid = "fire";
    expect_refused(load_vdb(path, one), path, "it has 'density', 'wind', 'density[1]'");
}

// Tiles of every depth, a box that is mostly background, and a corner that is no multiple of a tile.
TEST_F(VdbVolume, sparse_grids_of_large_boxes_are_what_openvdb_has) {
    openvdb::initialize();
    auto grid = openvdb::FloatGrid::create(0.125f);
    grid->setName("density");
    grid->tree().setValueOn(Coord(-77, -90, -103), 1);
    grid->tree().setValueOn(Coord(1900, 2000, 1700), 2);
    grid->sparseFill(openvdb::CoordBBox(Coord(0), Coord(300, 200, 150)), 3.0f);
    grid->sparseFill(openvdb::CoordBBox(Coord(1024, 5, 5), Coord(1031, 12, 12)), 4.0f);
    const auto path = folder / "a.vdb";
    write_vdb(path, {grid});
    const Result<Scene> scene = load_vdb(path, {});
    ASSERT_TRUE(scene) << scene.error().message;
    const Grid& read = scene->grids.at(0);
    EXPECT_LT(read.samples->stored_count(), 4000u);
    const int different = test::expect_sparse_samples(
        read, 0.125f, [&](ivec3 place) { return grid->tree().getValue(Coord(place.x, place.y, place.z)); });
    EXPECT_GT(different, 10000);
}

openvdb::FloatGrid::Ptr level_set_of(float offset) {
    auto grid = openvdb::FloatGrid::create(2);
    grid->setName("surface");
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    for (int z = -6; z <= 6; ++z)
        for (int y = -6; y <= 6; ++y)
            for (int x = -6; x <= 6; ++x) {
                const float distance = glm::length(vec3(ivec3(x, y, z))) - 4;
                grid->tree().setValueOn(Coord(x, y, z), std::clamp(distance, -2.0f, 2.0f) + offset);
            }
    return grid;
}

TEST_F(VdbVolume, a_level_set_that_is_nowhere_inside_stays_fog) {
    openvdb::initialize();
    for (const bool inside : {true, false}) {
        const auto path = folder / "a.vdb";
        write_vdb(path, {level_set_of(inside ? 0.0f : 2.0f)});
        const Result<Scene> scene = load_vdb(path, {});
        ASSERT_TRUE(scene) << scene.error().message;
        EXPECT_TRUE(validate(*scene));
        EXPECT_EQ(std::get<VolumeGeometry>(scene->geometries.at(0).data).surface, inside);
        EXPECT_EQ(scene->objects.at(0).interior >= 0, !inside);
        if (!inside) { EXPECT_EQ(scene->grids.at(0).samples->minimum(), 0); }
    }
}

TEST_F(VdbVolume, the_distances_of_a_level_set_are_no_densities) {
    openvdb::initialize();
    write_vdb(folder / "a.vdb", {level_set_of(0)});
    const auto scene_with = [&](const std::string& as) {
        write("a.json", R"({"version": 1, "geometries": {"ball": {"type": "volume", "file": "a.vdb")" + as + R"(}},
"media": {"mist": {"scattering": [1, 1, 1], "density": "ball"}},
"objects": [{"geometry": "ball", "material": null, "interior": "mist"}]})");
        return load_scene(folder / "a.json");
    };
    const Result<Scene> distances = scene_with("");
    ASSERT_FALSE(distances);
    EXPECT_EQ(distances.error().message, (folder / "a.json").string() +
                                             ":2:56: \"density\" of medium \"mist\": geometry \"ball\" holds "
                                             "distances; \"as\": \"fog\" makes them densities");
    const Result<Scene> fog = scene_with(R"(, "as": "fog")");
    EXPECT_TRUE(fog) << fog.error().message;
}

TEST_F(VdbVolume, what_is_too_large_is_refused_before_it_is_allocated) {
    openvdb::initialize();
    auto grid = openvdb::FloatGrid::create(0);
    grid->tree().setValueOn(Coord(0), 1);
    grid->tree().setValueOn(Coord(1 << 20, 1 << 20, 1 << 18), 1);
    const auto path = folder / "a.vdb";
    write_vdb(path, {grid});
    expect_refused(load_vdb(path, {}), path, "allowed");
}

}  // namespace
}  // namespace spinel::vdb_volume_test
