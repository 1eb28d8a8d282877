#include "formats/vox_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "formats/vox.h"
#include "formats/vox_material.h"
#include "image/palette.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"
#include "scene/validate.h"
#include "vox_chunks.h"

namespace spinel::vox_writer_test {
namespace {

class VoxWriter : public FileTest {};

TEST_F(VoxWriter, what_is_written_is_read_back_the_same) {
    // Turned, mirrored and moved models, one larger than a model may be, in every kind of material.
    Scene scene;
    const std::array<std::uint8_t, 4> red = {255, 50, 50, 255};
    const std::vector<Dictionary> looks = {{{"_type", "_diffuse"}},
                                           {{"_type", "_metal"}, {"_metal", "1"}, {"_rough", "0.25"}},
                                           {{"_type", "_metal"}, {"_metal", "0.5"}, {"_rough", "0.5"}},
                                           {{"_type", "_metal"}, {"_plastic", "1"}, {"_ri", "1.75"}},
                                           {{"_type", "_glass"}, {"_trans", "0.5"}, {"_ri", "1.5"}, {"_rough", "0"}},
                                           {{"_type", "_emit"}, {"_emit", "0.5"}, {"_flux", "3"}}};
    std::vector<int> slots;
    for (const Dictionary& look : looks) {
        slots.push_back(int(scene.materials.size()));
        scene.materials.push_back({"m", vox::appearance(red, look).material});
    }
    scene.media.push_back(*vox::appearance(red, {{"_type", "_media"}, {"_d", "0.25"}, {"_g", "0.5"}}).medium);
    std::vector<VoxelPoint> points;
    for (int i = 0; i < 600; ++i) points.push_back({{i, i % 3, i % 7}, std::uint16_t(1 + i % 6)});
    scene.geometries.push_back({"line", VoxelGeometry{*build_voxel_tree({600, 3, 7}, points)}});
    scene.geometries.push_back(
        {"cloud", VoxelGeometry{*build_voxel_tree({3, 1, 2}, {{{2, 0, 1}, 1}, {{0, 0, 0}, 1}})}});
    const auto add = [&](int geometry, const mat4x3& transform, std::vector<int> materials, int interior) {
        Object object;
        object.name = "object";
        object.geometry = geometry;
        object.transform = transform;
        object.materials = std::move(materials);
        object.interior = interior;
        scene.objects.push_back(object);
    };
    add(0, mat4x3(1), slots, -1);
    add(0, mat4x3(vec3(0, 0, 1), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(-7, 1000, 11)), slots, -1);  // mirrored
    add(1, mat4x3(vec3(0, 1, 0), vec3(0, 0, 1), vec3(1, 0, 0), vec3(50, 60, -70)), {-1}, 0);
    ASSERT_TRUE(validate(scene)) << validate(scene).error().message;

    const auto path = folder / "a.vox";
    const Result<Notes> saved = save_vox(scene, path);
    ASSERT_TRUE(saved) << saved.error().message;
    const Result<Scene> back = load_vox(path);
    ASSERT_TRUE(back) << back.error().message;
    ASSERT_TRUE(validate(*back)) << validate(*back).error().message;
    // What stands where, with the kind and the look of its material.
    using Look = std::array<int, 6>;
    const auto contents = [&](const Scene& s) {
        std::map<std::array<int, 3>, Look> result;
        for (const Object& object : s.objects)
            std::get<VoxelGeometry>(s.geometries[std::size_t(object.geometry)].data)
                .tree->for_each([&](ivec3 cell, std::uint16_t palette) {
                    const vec3 p = 2.0f * (object.transform * vec4(vec3(cell) + 0.5f, 1.0f));
                    const int material = object.materials[object.materials.size() == 1 ? 0 : palette - 1u];
                    Look look = {-1, 0, 0, 0, 0, 0};
                    const auto hundredths = [](float x) { return int(std::lround(100 * x)); };
                    if (material >= 0) {
                        const kernels::Material& m = s.materials[std::size_t(material)].values;
                        look = {int(m.kind),
                                hundredths(m.color.y),
                                hundredths(m.roughness),
                                hundredths(m.absorption.y),
                                hundredths(m.emission.x),
                                hundredths(m.ior)};
                    } else {
                        const Medium& m = s.media[std::size_t(object.interior)];
                        look = {-1, hundredths(m.scattering.x), hundredths(m.absorption.y), hundredths(m.g), 0, 0};
                    }
                    result[{int(std::lround(p.x)), int(std::lround(p.y)), int(std::lround(p.z))}] = look;
                });
        return result;
    };
    const auto before = contents(scene), after = contents(*back);
    ASSERT_EQ(before.size(), 1202u);
    EXPECT_EQ(before.size(), after.size());
    int differences = 0;
    for (const auto& [at, look] : before) {
        const auto found = after.find(at);
        ASSERT_NE(found, after.end()) << at[0] << " " << at[1] << " " << at[2];
        for (std::size_t i = 0; i < look.size(); ++i) {
            // A glass's own colour counts for nothing; its absorption is an 8-bit colour in the file.
            if (look[0] == int(kernels::MATERIAL_DIELECTRIC) && i == 1) continue;
            if (look[0] != -1 && look[0] == int(kernels::MATERIAL_DIFFUSE) && look[4] == 0 && i == 2) continue;
            differences += std::abs(look[i] - found->second[i]) > std::max(1, std::abs(look[i]) / 50);
        }
    }
    EXPECT_EQ(differences, 0);
}

// A row of voxels, each with a diffuse material of its own that `change` may alter.
template <class Change>
Scene many_materials(int count, const Change& change) {
    Scene scene;
    std::vector<VoxelPoint> points;
    Object object;
    object.name = "one";
    object.geometry = 0;
    for (int i = 0; i < count; ++i) {
        kernels::Material material = default_material(kernels::MATERIAL_DIFFUSE);
        material.color = vec3(float(i % 100) / 100, float(i / 100) / 10, 0.5f);
        change(i, material);
        scene.materials.push_back({"m" + std::to_string(i), material});
        object.materials.push_back(i);
        points.push_back({{i, 0, 0}, std::uint16_t(i + 1)});
    }
    scene.geometries.push_back({"many", VoxelGeometry{*build_voxel_tree({count, 1, 1}, points)}});
    scene.objects.push_back(object);
    return scene;
}

TEST_F(VoxWriter, more_colours_than_a_palette_has_are_drawn_together) {
    // 900 colours of two sorts, which stay apart: the metals, few of them, keep theirs.
    const Scene scene = many_materials(900, [](int i, kernels::Material& m) {
        if (i % 100 != 7) return;
        m = default_material(kernels::MATERIAL_METAL);
        m.color = vec3(0.9f, float(i) / 900, 0.2f);
    });
    const auto path = folder / "a.vox";
    const Result<Notes> saved = save_vox(scene, path);
    ASSERT_TRUE(saved) << saved.error().message;
    ASSERT_EQ(saved->size(), 1u);
    EXPECT_EQ(saved->front(), "what the format has no words for is left out or changed: 900 colours as 255");
    const Result<Scene> back = load_vox(path);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_LE(back->materials.size(), 255u);
    EXPECT_GE(back->materials.size(), 250u);
    std::map<int, kernels::Material> read;  // by the place in the row
    for (const Object& object : back->objects)
        std::get<VoxelGeometry>(back->geometries[std::size_t(object.geometry)].data)
            .tree->for_each([&](ivec3 cell, std::uint16_t palette) {
                const vec3 at = object.transform * vec4(vec3(cell) + 0.5f, 1);
                const auto slot = object.materials.size() == 1 ? 0u : palette - 1u;
                read[int(std::floor(at.x))] = back->materials[std::size_t(object.materials[slot])].values;
            });
    ASSERT_EQ(read.size(), 900u);
    const int first = read.begin()->first;
    for (int i = 0; i < 900; ++i) {
        const kernels::Material &meant = scene.materials[std::size_t(i)].values, &got = read.at(first + i);
        EXPECT_EQ(got.kind, meant.kind) << i;
        const vec3 apart = oklab_of_linear(got.color) - oklab_of_linear(meant.color);
        EXPECT_LT(glm::length(apart), 0.06f) << i;
    }
}

TEST_F(VoxWriter, what_a_file_has_no_words_for_is_told_in_one_sentence) {
    Scene scene = many_materials(6, [](int i, kernels::Material& m) {
        if (i == 1) m.roughness = 0.7f;  // of a diffuse surface
        if (i == 2 || i == 3) {
            m = default_material(kernels::MATERIAL_METAL);
            m.emission = vec3(3, 2, 1);  // what glows is diffuse
            m.color = vec3(1);
        }
        if (i == 4) m.opacity = 0.5f;
        if (i == 5) {
            m = default_material(kernels::MATERIAL_METAL);  // of gold: kept as a colour
            m.eta = vec3(0.18f, 0.42f, 1.37f);
            m.k = vec3(3.4f, 2.35f, 1.77f);
        }
    });
    scene.lights.push_back({"lamp", PointLight{}});
    const Result<Notes> saved = save_vox(scene, folder / "a.vox");
    ASSERT_TRUE(saved) << saved.error().message;
    ASSERT_EQ(saved->size(), 1u);
    const std::string& note = saved->front();
    for (const char* part :
         {"metal → diffuse of 2 materials", "roughness of 3 materials", "opacity of 1 material", ", lights"})
        EXPECT_NE(note.find(part), std::string::npos) << part << " is not in: " << note;
    for (const char* part : {" eta", "textures", "colours", "environment", "\n"})
        EXPECT_EQ(note.find(part), std::string::npos) << part << " is in: " << note;
    const Result<Scene> back = load_vox(folder / "a.vox");
    ASSERT_TRUE(back);
    bool golden = false;
    for (const Material& m : back->materials)
        golden |= m.values.kind == kernels::MATERIAL_METAL && m.values.color.x > 0.9f && m.values.color.z < 0.5f;
    EXPECT_TRUE(golden);

    const Scene plain = many_materials(3, [](int, kernels::Material&) {});
    const Result<Notes> whole = save_vox(plain, folder / "b.vox");
    ASSERT_TRUE(whole);
    EXPECT_TRUE(whole->empty()) << whole->front();
}

TEST_F(VoxWriter, what_a_file_cannot_hold_is_not_written) {
    const auto refused = [&](const Scene& scene, const std::string& why) {
        expect_refused(save_vox(scene, folder / "a.vox"), folder / "a.vox", why);
        EXPECT_FALSE(std::filesystem::exists(folder / "a.vox"));
    };
    Scene scene;
    refused(scene, "no object");
    // Each with a roughness of its own, which no colour can stand for.
    scene = many_materials(300, [](int i, kernels::Material& m) {
        m.kind = kernels::MATERIAL_PLASTIC;
        m.roughness = float(i) / 300;
    });
    refused(scene, "300 sorts that differ in more than colour");
    scene.objects[0].materials = {0};
    scene.objects[0].transform[0] = vec3(0.8f, 0.6f, 0);
    refused(scene, "lattice");
    scene.objects[0].transform = mat4x3(1);
    scene.objects.push_back(scene.objects[0]);
    scene.objects[1].transform[3].x = 0.5f;
    refused(scene, "lattice");
    scene.geometries[0].data = SphereGeometry{};
    refused(scene, "not made of voxels");
}

TEST_F(VoxWriter, every_real_file_survives_being_written) {
    if (!std::filesystem::exists(data_folder / "vox")) GTEST_SKIP() << "no " << data_folder / "vox";
    for (const char* file : {"vox/ephtracy/chr_knight.vox", "vox/scene/test_groups.vox", "vox/bevy/cloud.vox",
                             "vox/bevy/study.vox", "vox/kluchek/red_booth_transparency.vox", "vox/dot_vox/axes.vox"}) {
        const Result<Scene> scene = load_vox(data_folder / file);
        ASSERT_TRUE(scene) << scene.error().message;
        const Result<Notes> saved = save_vox(*scene, folder / "a.vox");
        ASSERT_TRUE(saved) << file << ": " << saved.error().message;
        const Result<Scene> back = load_vox(folder / "a.vox");
        ASSERT_TRUE(back) << file << ": " << back.error().message;
        const auto all = [](const Scene& s) {
            Centers result;
            for (const Object& object : s.objects) {
                const Centers own = centers(s, object);
                result.insert(result.end(), own.begin(), own.end());
            }
            std::sort(result.begin(), result.end());
            return result;
        };
        const Centers before = all(*scene), after = all(*back);
        ASSERT_EQ(before.size(), after.size()) << file;
        const ivec3 shift(after[0][0] - before[0][0], after[0][1] - before[0][1], after[0][2] - before[0][2]);
        bool same = true;
        for (std::size_t i = 0; i < before.size() && same; ++i)
            for (int axis = 0; axis < 3; ++axis)
                same = same && after[i][std::size_t(axis)] - before[i][std::size_t(axis)] == shift[axis];
        EXPECT_TRUE(same) << file;
    }
}

}  // namespace
}  // namespace spinel::vox_writer_test
