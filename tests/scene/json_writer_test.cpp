#include "scene/json_writer.h"

#include <cstring>
#include <random>

#include "json_test.h"

namespace spinel::json_writer_test {
namespace {

using test::scene_of;

// Something of everything, nothing at its default.
const char* const full = R"j({"version": 1,
  "cameras": {"front": {"from": [0, 1, 5], "fov": 30.5, "mirrored": true},
              "top": {"type": "orthographic", "from": [0, 9, 0], "up": [0, 0, 1], "height": 3}},
  "film": {"size": [64, 32], "exposure": -0.1, "tone_map": "linear", "filter": "tent", "filter_radius": 1},
  "integrator": {"spp": 3, "max_bounces": 4},
  "environment": {"type": "image", "file": "picture.exr", "scale": [1, 2, 3], "rotation": 30, "filter": "nearest"},
  "textures": {"t": {"type": "image", "file": "picture.png", "srgb": false, "wrap": "clamp", "scale": [2, 3]},
               "linear": {"type": "image", "file": "picture.exr"},
               "c": {"type": "checker", "color_a": [0.1, 0.2, 0.3], "offset": [0.5, 0]}},
  "geometries": {
    "mesh": {"type": "mesh", "positions": [[0,0,0],[1,0,0],[0,1.1,0]], "triangles": [[0,1,2],[2,1,0]], "slots": [0, 1],
             "normals": [[0,0,1],[0,0,1],[0,0,1]], "uvs": [[0,0],[1,0],[0,1]],
             "tangents": [[1,0,0,-1],[1,0,0,-1],[1,0,0,-1]], "colors": [[1,1,1,1],[0.5,1,1,1],[1,1,1,1]]},
    "voxels": {"type": "voxels", "layers": [["1.2"]]},
    "volume": {"type": "volume", "size": [1, 2, 1], "values": [0.1, 2], "filter": "nearest",
               "transform": [{"scale": [0.5, 0.25, 1]}, {"translate": [1, 0, 0]}]},
    "sdf": {"type": "sdf", "expression": "smooth_union(0.1, box(1, 2, 0.3), sphere(0.7))",
            "bounds": [[-1, -1, -1], [1, 1, 1]]},
    "ball": {"type": "sphere", "radius": 0.3}, "box": {"type": "box", "size": [1, 2, 3]},
    "plane": {"type": "plane"}, "wall": {"type": "rectangle", "size": [2, 1]}},
  "media": {"fog": {"scattering": 1, "absorption": [0.1, 0.2, 0.3], "g": 0.7, "emission": 2},
            "cloud": {"scattering": 9, "density": "volume", "erosion": {"type": "value", "strength": 0.5, "drift": [1, 2, 3]}}},
  "materials": {
    "a": {"type": "diffuse", "color": "t", "roughness": {"texture": "c", "factor": 0.5}, "emission": [1, 2, 3],
          "emission_two_sided": true, "normal_map": "t", "normal_scale": 0.5, "opacity": 0.75},
    "gold": {"type": "metal", "preset": "gold", "roughness": 0},
    "tinted": {"type": "metal", "color": [0.9, 0.5, 0.1], "edge_color": 0.5},
    "glass": {"type": "dielectric", "ior": 1.3, "absorption": 0.1, "priority": -3, "interior": "fog"},
    "plastic": {"type": "plastic", "color": 0.1, "ior": 1.6},
    "rough": {"type": "principled", "metallic": {"texture": "t", "factor": 0.25}}},
  "objects": [
    {"name": "m", "geometry": "mesh", "material": ["a", "gold"], "transform": [{"rotate": {"axis": [1, 2, 3], "degrees": 40}}]},
    {"name": "v", "geometry": "voxels", "material": ["tinted", null]},
    {"name": "c", "geometry": "volume", "interior": "cloud"},
    {"name": "s", "geometry": "sdf", "material": "glass"},
    {"name": "i", "geometry": "ball", "material": null, "interior": "fog"},
    {"name": "b", "geometry": "box", "material": "plastic"},
    {"name": "p", "geometry": "plane", "material": "rough"},
    {"name": "w", "geometry": "wall", "material": "rough"}],
  "lights": [{"type": "point", "name": "bulb", "intensity": [1, 2, 3]},
             {"type": "spot", "direction": [1, -1, 0], "inner_angle": 1, "outer_angle": 2},
             {"type": "directional", "angular_radius": 0.265}],
  "expected": {"mean": [0.1, 0.2, 0.3], "tolerance": 0.01}})j";

std::string written(const Scene& scene) {
    const Result<std::string> text = write_scene_json(scene);
    if (text) return *text;
    ADD_FAILURE() << text.error().message;
    return "";
}

TEST(JsonWriter, a_scene_reads_back_as_it_was_written) {
    const Scene first = scene_of(full);
    const std::string text = written(first);
    const Scene second = scene_of(text);
    EXPECT_EQ(written(second), text);

    // What is not a row of a table, one by one.
    ASSERT_EQ(second.cameras.size(), 2u);
    EXPECT_EQ(second.cameras[1].kind, Camera::Kind::orthographic);
    EXPECT_EQ(std::get<ImageEnvironment>(second.environment).file, "picture.exr");
    EXPECT_FALSE(std::get<ImageTexture>(second.textures.at(0).data).srgb);
    const auto& mesh = std::get<MeshGeometry>(second.geometries.at(0).data);
    const auto& mesh_before = std::get<MeshGeometry>(first.geometries.at(0).data);
    EXPECT_EQ(mesh.positions, mesh_before.positions);
    EXPECT_EQ(mesh.triangles, mesh_before.triangles);
    EXPECT_EQ(mesh.normals, mesh_before.normals);
    EXPECT_EQ(mesh.uvs, mesh_before.uvs);
    EXPECT_EQ(mesh.tangents, mesh_before.tangents);
    EXPECT_EQ(mesh.colors, mesh_before.colors);
    EXPECT_EQ(mesh.slots, mesh_before.slots);
    const VoxelTree& voxels = *std::get<VoxelGeometry>(second.geometries.at(1).data).tree;
    EXPECT_EQ(voxels.voxel_count(), 2u);
    EXPECT_EQ(voxels.at({0, 0, 0}), 1);
    EXPECT_EQ(voxels.at({2, 0, 0}), 2);
    EXPECT_EQ(second.grids.at(0).samples->dense(), first.grids.at(0).samples->dense());
    EXPECT_EQ(second.grids[0].index_to_local, mat4x3(0.5f, 0, 0, 0, 0.25f, 0, 0, 0, 1, 1, 0, 0));
    EXPECT_EQ(second.grids[0].filter, Filter::nearest);
    EXPECT_EQ(std::get<SdfGeometry>(second.geometries.at(3).data).root.numbers, std::vector<float>{0.1f});
    ASSERT_EQ(second.materials.size(), first.materials.size());
    static_assert(std::is_trivially_copyable_v<kernels::Material>);
    for (std::size_t i = 0; i < first.materials.size(); ++i)
        EXPECT_EQ(std::memcmp(&second.materials[i].values, &first.materials[i].values, sizeof(kernels::Material)), 0)
            << first.materials[i].name;
    EXPECT_EQ(second.media.at(1).grid, 0);
    EXPECT_EQ(second.media[1].erosion.drift, vec3(1, 2, 3));
    ASSERT_EQ(second.objects.size(), first.objects.size());
    for (std::size_t i = 0; i < first.objects.size(); ++i) {
        EXPECT_EQ(second.objects[i].name, first.objects[i].name);
        EXPECT_EQ(second.objects[i].transform, first.objects[i].transform) << "bit by bit";
        EXPECT_EQ(second.objects[i].materials, first.objects[i].materials);
        EXPECT_EQ(second.objects[i].interior, first.objects[i].interior);
    }
}

TEST(JsonWriter, things_without_a_name_of_their_own_get_one) {
    Scene scene = scene_of(full);
    for (Geometry& geometry : scene.geometries) geometry.name = "same";
    for (Material& material : scene.materials) material.name.clear();
    scene.materials[1].name = "material 1";  // which the first must not take
    const Scene again = scene_of(written(scene));
    ASSERT_EQ(again.materials.size(), scene.materials.size());
    EXPECT_EQ(again.materials[0].name, "material 2");
    EXPECT_EQ(again.materials[1].name, "material 1");
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        EXPECT_EQ(again.objects[i].geometry, scene.objects[i].geometry);
        EXPECT_EQ(again.objects[i].materials, scene.objects[i].materials);
    }
}

TEST(JsonWriter, an_embedded_picture_is_an_error) {
    Scene scene = scene_of(full);
    std::get<ImageTexture>(scene.textures[0].data).file.clear();
    const Result<std::string> text = write_scene_json(scene);
    ASSERT_FALSE(text);
    EXPECT_EQ(text.error().message,
              "texture \"t\" has a picture that is in no file of its own, so a scene file cannot name it");
}

// A small fuzzer: harmed texts give a scene or a positioned sentence, never a crash.
TEST(JsonReader, harmed_texts_are_read_or_refused) {
    const std::string text = full;
    const std::string pieces[] = {"{", "}", "[", "]", "\"", ",", ":", "-", "0", "1e38", "null", "\\", "true", "//"};
    for (unsigned seed = 0; seed < 3000; ++seed) {
        std::mt19937 random(seed);
        std::string harmed = text;
        for (unsigned count = 1 + random() % 3; count > 0; --count) {
            const std::size_t at = random() % harmed.size(), length = random() % 8;
            switch (random() % 4) {
                case 0: harmed.erase(at, length); break;
                case 1: harmed[at] = char(random()); break;
                case 2: harmed.insert(at, pieces[random() % std::size(pieces)]); break;
                case 3: harmed.replace(at, length, harmed.substr(random() % harmed.size(), length)); break;
            }
        }
        const Result<Scene> scene = test::read(harmed);
        if (!scene) {
            EXPECT_EQ(scene.error().message.rfind("scenes/a.json:", 0), 0u)
                << "seed " << seed << ": " << scene.error().message;
        }
    }
}

}  // namespace
}  // namespace spinel::json_writer_test
