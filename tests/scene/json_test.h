#pragma once
// Scenes from text for the tests of the scene reader, with loaders that know a few made-up files.

#include <gtest/gtest.h>

#include <string>

#include "scene/json_reader.h"

namespace spinel::test {

inline Scene two_meshes() {
    Scene model;
    PixelBuffer white{1, 1, 3, std::vector<std::uint8_t>{255, 255, 255}};
    ImageTexture image;
    image.file = "white.png";
    image.pixels = std::make_shared<const PixelBuffer>(white);
    model.textures.push_back({"white", image});
    for (unsigned i = 0; i < 2; ++i) {
        MeshGeometry mesh;
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        mesh.triangles = {{0, 1, 2}};
        model.geometries.push_back({"mesh" + std::to_string(i), mesh});
        Material material;
        material.name = "paint" + std::to_string(i);
        material.values = kernels::Material{};
        material.values.ior = 1.5f;
        material.values.opacity = 1;
        kernels::Material& m = material.values;
        m.color_texture = i == 1 ? 0 : kernels::NONE;
        m.roughness_texture = m.metallic_texture = m.emission_texture = m.normal_texture = m.opacity_texture =
            m.interior = kernels::NONE;
        model.materials.push_back(material);
        Object object;
        object.name = "part" + std::to_string(i);
        object.geometry = int(i);
        object.materials = {int(i)};
        object.transform[3] = vec3(1.0f + float(i), 0, 0);
        model.objects.push_back(object);
    }
    return model;
}

inline Scene cloud() {
    Scene model;
    model.grids.push_back({"cloud", *build_grid({2, 1, 1}, std::vector<float>{1, 2})});
    model.media.push_back({"cloud", vec3(1), vec3(0), 0, vec3(0), 0});
    model.geometries.push_back({"cloud", VolumeGeometry{0}});
    Object object;
    object.geometry = 0;
    object.interior = 0;
    model.objects.push_back(object);
    return model;
}

// Knows "two.obj": two meshes at x = 1 and x = 2, a material each, the second's under a texture; "cloud.vol":
// a volume of 2×1×1 samples with its medium; "empty.obj": nothing. Pictures: "picture.exr" of floats,
// "picture.png" of bytes. All in the folder "scenes".
inline SceneLoaders fake_loaders() {
    SceneLoaders loaders;
    loaders.model = [](const std::filesystem::path& path, const LoadOptions&) -> Result<Scene> {
        if (path == "scenes/two.obj") return two_meshes();
        if (path == "scenes/cloud.vol") return cloud();
        if (path == "scenes/empty.obj") return Scene{};
        return Error{path.string() + ": no such file"};
    };
    loaders.pixels = [](const std::filesystem::path& path) -> Result<PixelBuffer> {
        if (path == "scenes/picture.exr") return PixelBuffer{1, 1, 3, std::vector<float>{1, 2, 3}};
        if (path == "scenes/picture.png") return PixelBuffer{1, 1, 3, std::vector<std::uint8_t>{1, 2, 3}};
        return Error{path.string() + ": no such file"};
    };
    return loaders;
}

// The scene of a text in "scenes/a.json".
inline Result<Scene> read(const std::string& text) { return read_scene_json(text, "scenes/a.json", fake_loaders()); }

// The scene of a text that must be right.
inline Scene scene_of(const std::string& text) {
    Result<Scene> scene = read(text);
    if (scene) return *std::move(scene);
    ADD_FAILURE() << scene.error().message;
    return {};
}

// The message that a wrong text gives, without "scenes/".
inline std::string message(const std::string& text) {
    const Result<Scene> scene = read(text);
    return scene ? "no error" : scene.error().message.substr(7);
}

}  // namespace spinel::test
