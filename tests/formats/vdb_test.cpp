#include "formats/vdb.h"

#include <gtest/gtest.h>

#include "kernels/materials.h"
#include "scene/material_registry.h"
#include "scene/validate.h"
#include "test_files.h"

namespace spinel::vdb_test {
namespace {

using Vdb = FileTest;

Scene scene_of(VoxelTreePointer tree, int material_count) {
    Scene scene;
    for (int i = 0; i < material_count; ++i) {
        Material m{"m" + std::to_string(i), default_material(i % 3 == 1   ? kernels::MATERIAL_METAL
                                                             : i % 3 == 2 ? kernels::MATERIAL_DIELECTRIC
                                                                          : kernels::MATERIAL_DIFFUSE)};
        m.values.color = vec3(0.1f, float(i) / float(material_count), 0.3f);
        if (i % 3 == 0) m.values.emission = vec3(0, 0, float(i));
        scene.materials.push_back(m);
    }
    scene.geometries.push_back({"set", VoxelGeometry{tree}});
    Object object;
    object.name = "set";
    object.geometry = 0;
    // Turned, moved and half as large.
    object.transform = mat4x3(vec3(0, 0, -0.5f), vec3(0, 0.5f, 0), vec3(0.5f, 0, 0), vec3(3, -7.25f, 100));
    for (int i = 0; i < material_count; ++i) object.materials.push_back(i);
    scene.objects.push_back(object);
    return scene;
}

TEST_F(Vdb, voxels_come_back_as_they_were) {
    for (const std::uint32_t colors : {1u, 9u, 700u}) {
        const ivec3 size(150, 70, 90);
        // Solid parts of several sizes, noise, and empty margins.
        const auto tree = build_voxel_tree(
            size, {[&](ivec3 c) {
                       if (c.x < 20 || c.y > 60) return std::uint16_t(0);
                       const ivec3 b = c / 32;
                       if ((b.x + b.y + b.z) % 2 == 0) return std::uint16_t(1 + (b.x + b.z) % int(colors));
                       const std::uint32_t h = std::uint32_t(c.x * 7919 + c.y * 104729 + c.z * 1299709) * 2654435761u;
                       return std::uint16_t(h >> 30 ? 0 : 1 + (h >> 8) % colors);
                   },
                   {}});
        ASSERT_TRUE(tree);
        const Scene scene = scene_of(*tree, (*tree)->palette_maximum());
        const auto path = folder / "set.vdb";
        const auto saved = save_vdb(scene, path);
        ASSERT_TRUE(saved) << saved.error().message;
        const Result<Scene> back = load_vdb(path, {});
        ASSERT_TRUE(back) << back.error().message;
        EXPECT_TRUE(validate(*back));
        ASSERT_EQ(back->objects.size(), 1u);
        EXPECT_EQ(back->objects[0].name, "set");
        const VoxelTree& read = *std::get<VoxelGeometry>(back->geometries[0].data).tree;
        EXPECT_EQ(read.size(), size);
        EXPECT_EQ(read.voxel_count(), (*tree)->voxel_count());
        EXPECT_EQ(read.memory().node_bytes, (*tree)->memory().node_bytes);
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) ASSERT_EQ(read.at({x, y, z}), (*tree)->at({x, y, z}));
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 3; ++row)
                EXPECT_NEAR(back->objects[0].transform[column][row], scene.objects[0].transform[column][row], 1e-5f);
        ASSERT_EQ(back->objects[0].materials.size(), scene.materials.size());
        for (std::size_t i = 0; i < scene.materials.size(); ++i) {
            const kernels::Material& a = scene.materials[i].values;
            const kernels::Material& b = back->materials[std::size_t(back->objects[0].materials[i])].values;
            EXPECT_EQ(a.kind, b.kind);
            EXPECT_EQ(a.color, b.color);
            EXPECT_EQ(a.emission, b.emission);
        }
    }
}

TEST_F(Vdb, a_solid_of_a_billion_voxels_is_tiles) {
    const auto tree = build_voxel_tree({1024, 1024, 1024},
                                       {[](ivec3) { return std::uint16_t(3); },
                                        [](ivec3, ivec3) { return std::optional<std::uint16_t>(std::uint16_t(3)); }});
    ASSERT_TRUE(tree);
    const auto path = folder / "solid.vdb";
    ASSERT_TRUE(save_vdb(scene_of(*tree, 3), path));
    EXPECT_LT(std::filesystem::file_size(path), 1u << 20);
    const Result<Scene> back = load_vdb(path, {});
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(std::get<VoxelGeometry>(back->geometries[0].data).tree->voxel_count(), std::uint64_t(1) << 30);
}

TEST_F(Vdb, a_layer_as_thick_as_a_leaf_is_tiles) {
    const ivec3 size(1500, 11, 1500);  // more cells than are written between two prunings
    const auto tree = build_voxel_tree(size, {[](ivec3 c) { return std::uint16_t(c.y < 8 ? 2 : 0); }, {}});
    ASSERT_TRUE(tree);
    const auto path = folder / "layer.vdb";
    ASSERT_TRUE(save_vdb(scene_of(*tree, 2), path));
    EXPECT_LT(std::filesystem::file_size(path), 1u << 18);
    const Result<Scene> back = load_vdb(path, {});
    ASSERT_TRUE(back) << back.error().message;
    const VoxelTree& read = *std::get<VoxelGeometry>(back->geometries[0].data).tree;
    EXPECT_EQ(read.voxel_count(), (*tree)->voxel_count());
    EXPECT_EQ(read.at({1499, 7, 1499}), 2);
    EXPECT_EQ(read.at({1499, 8, 1499}), 0);
}

TEST_F(Vdb, a_volume_is_voxels_only_if_asked_for) {
    const auto files = data_folder / "volume/vdb";
    if (!std::filesystem::exists(files)) GTEST_SKIP() << files << " is not there";
    LoadOptions as_voxels;
    as_voxels.voxels = true;
    for (const char* name : {"torus01.vdb", "sphere_levelset.vdb", "dragon_fog.vdb"}) {
        const auto path = files / name;
        const Result<Scene> volume = load_vdb(path, {});
        ASSERT_TRUE(volume) << volume.error().message;
        EXPECT_TRUE(std::holds_alternative<VolumeGeometry>(volume->geometries[0].data));
        const Result<Scene> scene = load_vdb(path, as_voxels);
        ASSERT_TRUE(scene) << scene.error().message;
        EXPECT_TRUE(validate(*scene));
        EXPECT_GT(std::get<VoxelGeometry>(scene->geometries[0].data).tree->voxel_count(), 1000u);
    }
    expect_refused(load_vdb(files / "pointgrid.vdb", as_voxels), files / "pointgrid.vdb", "holds points");
    expect_refused(load_vdb(files / "velocity_vec3s.vdb", as_voxels), files / "velocity_vec3s.vdb", "is of type");
    const Result<Scene> three = load_vdb(files / "grids_3samename.vdb", as_voxels);
    ASSERT_TRUE(three) << three.error().message;
    EXPECT_EQ(three->objects.size(), 3u);
}

TEST_F(Vdb, what_it_cannot_hold_is_refused_and_leaves_no_file) {
    const auto tree = build_voxel_tree({2, 2, 2}, {[](ivec3) { return std::uint16_t(1); }, {}});
    const auto path = folder / "a.vdb";
    expect_refused(save_vdb({}, path), path, "empty");
    Scene scene = scene_of(*tree, 1);
    scene.objects[0].materials = {-1};
    expect_refused(save_vdb(scene, path), path, "no surface");
    scene.geometries[0].data = SphereGeometry{};
    expect_refused(save_vdb(scene, path), path, "not made of voxels");
    EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST_F(Vdb, damaged_files_are_refused) {
    const auto tree = build_voxel_tree({40, 40, 40}, {[](ivec3 c) { return std::uint16_t(c.x % 3); }, {}});
    const auto path = folder / "good.vdb";
    ASSERT_TRUE(save_vdb(scene_of(*tree, 2), path));
    const std::string good = bytes_of(path);
    for (std::size_t sixteenth = 0; sixteenth < 16; ++sixteenth)
        expect_refused(load_vdb(write("cut.vdb", good.substr(0, good.size() * sixteenth / 16)), {}),
                       folder / "cut.vdb");
    for (const std::size_t missing : {1u, 2u, 3u, 8u, 100u})
        expect_refused(load_vdb(write("cut.vdb", good.substr(0, good.size() - missing)), {}), folder / "cut.vdb",
                       "cut off");
}

// Such a file does not tell where its grids end; it is read all the same, and found out all the same if it is cut off.
TEST_F(Vdb, files_written_as_streams_are_read) {
    const auto tree = build_voxel_tree({40, 40, 40}, {[](ivec3 c) { return std::uint16_t(c.x % 3); }, {}});
    const auto path = folder / "good.vdb";
    ASSERT_TRUE(save_vdb(scene_of(*tree, 2), path));
    std::string bytes = bytes_of(path);
    ASSERT_EQ(bytes[20], 1);
    bytes[20] = 0;
    const Result<Scene> scene = load_vdb(write("stream.vdb", bytes), {});
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(std::get<VoxelGeometry>(scene->geometries[0].data).tree->voxel_count(), (*tree)->voxel_count());
    for (const std::size_t missing : {1u, 8u, 100u, 1000u})
        expect_refused(load_vdb(write("cut.vdb", bytes.substr(0, bytes.size() - missing)), {}), folder / "cut.vdb",
                       "cut off");
}

TEST_F(Vdb, lies_in_what_a_file_lists_are_refused_or_harmless) {
    const auto tree = build_voxel_tree({9, 9, 9}, {[](ivec3 c) { return std::uint16_t(c.x % 3); }, {}});
    const auto path = folder / "good.vdb";
    ASSERT_TRUE(save_vdb(scene_of(*tree, 2), path));
    const std::string good = bytes_of(path);
    const std::size_t end = good.find("AffineMap");  // behind the metadata
    ASSERT_LT(end, good.size());
    for (std::size_t at = 0; at < end; at += at < 200 ? 5 : 41)
        for (const std::uint32_t lie : {0xffffffffu, 0x7fffffffu, 0x00ffffffu, 0u}) {
            std::string bytes = good;
            bytes.replace(at, 4, raw(lie));
            const Result<Scene> scene = load_vdb(write("lie.vdb", bytes), {});
            if (!scene) expect_refused(scene, folder / "lie.vdb");
            else EXPECT_TRUE(validate(*scene)) << at;
        }
}

}  // namespace
}  // namespace spinel::vdb_test
