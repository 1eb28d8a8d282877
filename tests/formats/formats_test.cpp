#include "spinel/formats.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "kernels/materials.h"
#include "scene/material_registry.h"
#include "scene/validate.h"
#include "test_files.h"

namespace spinel::formats_test {
namespace {

using Formats = FileTest;

TEST_F(Formats, every_row_is_complete_and_no_extension_stands_twice) {
    std::set<std::string_view> names, extensions;
    for (const Format& format : formats()) {
        EXPECT_TRUE(names.insert(format.name).second) << format.name;
        EXPECT_FALSE(format.description.empty());
        EXPECT_TRUE(format.load);
        ASSERT_FALSE(format.extensions.empty());
        for (const std::string_view extension : format.extensions) {
            EXPECT_EQ(extension[0], '.');
            EXPECT_TRUE(extensions.insert(extension).second) << extension;
        }
    }
}

TEST_F(Formats, an_unknown_extension_is_an_error_that_lists_what_there_is) {
    const Result<Scene> scene = load_model("x.foo");
    ASSERT_FALSE(scene);
    EXPECT_EQ(
        scene.error().message.find("cannot read 'x.foo': unknown extension '.foo'; readable: .vox, .mca, .schem, "), 0u)
        << scene.error().message;
    const Result<Notes> saved = save_model({}, "x.stl");
    ASSERT_FALSE(saved);
    std::string writable;
    for (const Format& format : formats())
        if (format.save)
            for (const std::string_view extension : format.extensions)
                writable += (writable.empty() ? "" : ", ") + std::string(extension);
    EXPECT_EQ(saved.error().message, "cannot write 'x.stl': unknown extension '.stl'; writable: " + writable);
}

TEST_F(Formats, extensions_are_known_in_upper_and_lower_case) {
    ASSERT_TRUE(format_of("A.VOX"));
    EXPECT_EQ(format_of("A.VOX")->name, "vox");
    EXPECT_EQ(format_of("vox"), nullptr);
    ASSERT_TRUE(format_of("N44W072.HGT.gz"));
    EXPECT_EQ(format_of("N44W072.HGT.gz")->name, "hgt");
    EXPECT_EQ(format_of("a.gz"), nullptr);
}

TEST_F(Formats, every_format_refuses_what_is_not_there_empty_or_nonsense) {
    std::string nonsense;
    for (int i = 0; i < 2000; ++i) nonsense += char(i * 7919 >> 3);
    for (const Format& format : formats()) {
        for (const std::string_view extension : format.extensions) {
            const std::filesystem::path absent = folder / ("absent" + std::string(extension));
            expect_refused(load_model(absent), absent);
            const auto empty = write("empty" + std::string(extension), "");
            expect_refused(load_model(empty), empty);
            const auto odd = write("odd" + std::string(extension), nonsense);
            expect_refused(load_model(odd), odd);
            const auto dir = folder / ("folder" + std::string(extension));
            std::filesystem::create_directory(dir);
            expect_refused(load_model(dir), dir);
        }
    }
}

// A small scene of what a format holds.
Scene scene_of(Representation what) {
    if (what == Representation::any) {
        const Result<Scene> bunny = load_model(std::filesystem::path(SPINEL_SOURCE_DIR) / "examples/bunny32.bits");
        EXPECT_TRUE(bunny) << bunny.error().message;
        return bunny ? *bunny : Scene();
    }
    Scene scene;
    for (const vec3 color : {vec3(0.8f, 0.1f, 0.1f), vec3(0.1f, 0.6f, 0.2f)}) {
        kernels::Material material = default_material(kernels::MATERIAL_DIFFUSE);
        material.color = color;
        scene.materials.push_back({"m" + std::to_string(scene.materials.size()), material});
    }
    if (what == Representation::voxels) {
        const auto tree =
            build_voxel_tree({5, 6, 7}, {[](ivec3 c) { return std::uint16_t((c.x + 2 * c.y + c.z) % 3); }, {}});
        scene.geometries.push_back({"set", VoxelGeometry{*tree}});
    } else {
        MeshGeometry mesh;
        mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 4}};
        mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
        mesh.slots = {0, 0, 1, 1};
        scene.geometries.push_back({"tetrahedron", mesh});
    }
    Object object;
    object.name = "thing";
    object.geometry = 0;
    object.transform[3] = {10, 0, -20};
    object.materials = {0, 1};
    scene.objects.push_back(object);
    return scene;
}

// What a scene holds, however it is divided into objects: voxels or triangles by their middle in space, and grids.
struct Contents {
    std::multiset<std::array<int, 3>> places;  // in hundredths
    std::vector<std::vector<float>> grids;
    bool operator==(const Contents&) const = default;
};
Contents contents_of(const Scene& scene) {
    Contents contents;
    for (const Object& object : scene.objects) {
        const auto add = [&](vec3 local) {
            const vec3 p = 100.0f * (object.transform * glm::vec4(local, 1));
            contents.places.insert({int(std::lround(p.x)), int(std::lround(p.y)), int(std::lround(p.z))});
        };
        const auto& data = scene.geometries[std::size_t(object.geometry)].data;
        if (const auto* voxels = std::get_if<VoxelGeometry>(&data))
            voxels->tree->for_each([&](ivec3 cell, std::uint16_t) { add(vec3(cell) + 0.5f); });
        if (const auto* mesh = std::get_if<MeshGeometry>(&data))
            for (const uvec3& t : mesh->triangles)
                add((mesh->positions[t.x] + mesh->positions[t.y] + mesh->positions[t.z]) / 3.0f);
    }
    for (const Grid& grid : scene.grids) contents.grids.push_back(grid.samples->dense());
    return contents;
}

TEST_F(Formats, a_saved_model_is_read_back_as_it_was) {
    std::size_t count = 0;
    for (const Format& format : formats()) {
        if (!format.save) continue;
        SCOPED_TRACE(format.name);
        ++count;
        const Scene scene = scene_of(format.saves);
        ASSERT_TRUE(validate(scene)) << validate(scene).error().message;
        const auto path = folder / ("a" + std::string(format.extensions[0]));
        const Result<Notes> saved = save_model(scene, path);
        ASSERT_TRUE(saved) << saved.error().message;
        EXPECT_TRUE(saved->empty()) << saved->front();
        const Result<Scene> back = load_model(path);
        ASSERT_TRUE(back) << back.error().message;
        ASSERT_TRUE(validate(*back)) << validate(*back).error().message;
        EXPECT_EQ(contents_of(*back), contents_of(scene));
        EXPECT_FALSE(contents_of(scene) == Contents());
    }
    EXPECT_GE(count, 5u);
}

TEST_F(Formats, what_a_saved_file_has_no_words_for_is_told_in_one_line) {
    for (const Format& format : formats()) {
        if (!format.save) continue;
        Scene scene = scene_of(format.saves);
        scene.lights.push_back({"lamp", PointLight{}});
        scene.cameras.push_back({});
        const Result<Notes> saved = save_model(scene, folder / ("a" + std::string(format.extensions[0])));
        ASSERT_TRUE(saved) << saved.error().message;
        EXPECT_EQ(*saved, Notes{"what the format has no words for is left out or changed: lights, cameras"})
            << format.name;
    }
}

TEST_F(Formats, damaged_and_unsupported_real_files_are_refused_with_one_line) {
    if (!std::filesystem::exists(data_folder)) GTEST_SKIP() << "no " << data_folder;
    for (const char* file : {"vox/dot_vox/not_a.vox", "vox/otherformats/slab6_vox_test.vox", "world/nbt/bigtest.nbt",
                             "mesh/gltf/heart_draco.glb"}) {
        ASSERT_TRUE(std::filesystem::exists(data_folder / file)) << file;
        expect_refused(load_model(data_folder / file), data_folder / file);
    }
}

}  // namespace
}  // namespace spinel::formats_test
