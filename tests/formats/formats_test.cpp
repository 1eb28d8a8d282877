#include "spinel/formats.h"

#include <gtest/gtest.h>

#include <set>

#include "scene/validate.h"
#include "test_files.h"

namespace spinel {
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
    const Result<void> saved = save_model({}, "x.stl");
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

TEST_F(Formats, a_saved_model_is_read_back_valid) {
    const auto bunny = std::filesystem::path(SPINEL_SOURCE_DIR) / "examples/bunny32.bits";
    const Result<Scene> scene = load_model(bunny);
    ASSERT_TRUE(scene) << scene.error().message;
    for (const Format& format : formats()) {
        if (!format.save || format.saves != Representation::any) continue;  // those have tests of their own
        const auto path = folder / ("a" + std::string(format.extensions[0]));
        ASSERT_TRUE(save_model(*scene, path));
        const Result<Scene> back = load_model(path);
        ASSERT_TRUE(back) << back.error().message;
        EXPECT_TRUE(validate(*back));
        EXPECT_EQ(back->grids[0].values, scene->grids[0].values);
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
}  // namespace spinel
