#pragma once
// The scene that kernel_cases.h asks about, in the host's memory and in a device's: one of everything that has a walk,
// media, and a table of materials of every kind with parameters drawn from their descriptions.

#include <algorithm>
#include <random>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "devices/vulkan/vulkan_device.h"
#include "scene/compiled_scene.h"
#include "scene/json_reader.h"
#include "scene/material_registry.h"
#include "vulkan/kernel_cases.h"

namespace spinel {

inline constexpr std::string_view case_scene_json = R"json({
  "version": 1,
  "materials": {
    "matte": {"type": "diffuse"},
    "water": {"type": "dielectric", "ior": 1.33, "absorption": [0.4, 0.1, 0.05]}
  },
  "geometries": {
    "steps": {"type": "voxels", "layers": [["111.2", "1.122", "22211"], ["1...2", "12.2.", ".1.12"], ["..1..", "2.2.2", "1...1"]]},
    "ring": {"type": "sdf", "expression": "difference(torus(0.7, 0.25), box(2, 2, 0.3))"},
    "knot": {"type": "sdf", "expression": "smooth_union(0.1, twist(90, box(0.6, 1.4, 0.6)), sphere(0.5))"},
    "tent": {"type": "mesh", "positions": [[-1, -1, -1], [1, -1, -1], [1, -1, 1], [-1, -1, 1], [0, 1, 0]],
             "triangles": [[0, 1, 2], [0, 2, 3], [0, 4, 1], [1, 4, 2], [2, 4, 3], [3, 4, 0]]},
    "linear": {"type": "volume", "size": [3, 2, 2], "values": [0, 1, 2, 0.5, 0, 1, 1, 3, 0, 2, 0.1, 1],
               "transform": [{"scale": [0.6, 0.9, 0.9]}, {"translate": [-1, -1, -1]}]},
    "nearest": {"type": "volume", "size": [2, 2, 1], "values": [0, 1, 1, 0.5], "filter": "nearest",
                "transform": [{"translate": [-1, -1, -0.5]}]},
    "half": {"type": "volume", "size": [3, 3, 2], "values": [0, 1, 2, 0.5, 0, 1, 1, 3, 0, 2, 0.1, 1, 0, 2, 1, 1, 0.3, 2],
             "precision": "half", "transform": [{"scale": [0.6, 0.6, 0.9]}, {"translate": [-1, -1, -1]}]},
    "cubic": {"type": "volume", "size": [10, 1, 2], "filter": "cubic", "precision": "16 bits",
              "values": [0, 1, 2, 0.5, 0, 1, 1, 3, 0, 2, 0.1, 1, 0, 2, 1, 1, 0.3, 2, 0.7, 3],
              "transform": [{"scale": [0.2, 1.8, 0.9]}, {"translate": [-1, -1, -1]}]},
    "pebble": {"type": "volume", "as": "surface", "size": [3, 3, 3], "transform": [{"translate": [-1.5, -1.5, -1.5]}],
               "values": [1.2, 0.9, 1.1, 0.8, 0.3, 0.6, 1.2, 1, 1.3, 0.7, 0.2, 0.5, 0.1, -0.9, -0.2, 0.6, 0.2, 0.7,
                          1.1, 0.8, 1, 0.9, 0.4, 0.7, 1.3, 1, 1.2]},
    "blob": {"type": "volume", "as": "surface", "level": 0.4, "solid": "above", "filter": "cubic", "precision": "half",
             "size": [3, 3, 3], "transform": [{"translate": [-1.5, -1.5, -1.5]}],
             "values": [0, 0.1, 0, 0.2, 0.9, 0.3, 0, 0.1, 0, 0.3, 1, 0.2, 0.9, 2, 1, 0.2, 1.1, 0.4,
                        0, 0.2, 0, 0.1, 0.8, 0.2, 0, 0.1, 0]},
    "bytes": {"type": "volume", "size": [1, 2, 9], "precision": "8 bits",
              "values": [0, 1, 2, 0.5, 0, 1, 1, 3, 0, 2, 0.1, 1, 0, 2, 1, 1, 0.3, 2],
              "transform": [{"scale": [1.8, 0.9, 0.2]}, {"translate": [-1, -1, -1]}]}
  },
  "media": {
    "fog": {"scattering": [2, 1, 0.5], "absorption": 0.1, "g": 0.3},
    "plain": {"scattering": 5, "density": "linear"},
    "wool": {"scattering": 5, "density": "linear", "erosion": {"type": "value", "strength": 1.2, "frequency": 5}},
    "mist": {"scattering": 5, "density": "nearest", "erosion": {"type": "fbm", "frequency": 3, "drift": [1, 2, 3]}},
    "dust": {"scattering": 5, "density": "half", "erosion": {"type": "perlin", "frequency": 3, "offset": 0.3}},
    "silk": {"scattering": 5, "density": "cubic", "density_range": [0.2, 3],
             "erosion": {"type": "simplex", "frequency": 4, "offset": 0.5, "octaves": 3, "gain": 0.6, "lacunarity": 2.3}},
    "snow": {"scattering": 5, "density": "bytes"}
  },
  "objects": [
    {"geometry": "steps", "material": ["matte", "water"],
     "transform": [{"translate": [-2.5, -1.5, -1.5]}, {"scale": 0.5}, {"rotate": {"axis": [1, 2, 3], "degrees": 40}}]},
    {"geometry": {"type": "box", "size": [1, 2, 1]}, "material": null, "interior": "fog",
     "transform": [{"rotate": {"axis": [0, 1, 0], "degrees": 30}}, {"translate": [3, 0, 0]}]},
    {"geometry": "ring", "material": "matte", "transform": [{"translate": [-3, 0, 0]}]},
    {"geometry": "knot", "material": "water", "transform": [{"translate": [0, 0, 2.5]}]},
    {"geometry": "tent", "material": "matte", "transform": [{"scale": 0.7}, {"translate": [0, 0, -2.5]}]},
    {"geometry": {"type": "sphere", "radius": 0.6}, "material": "matte", "transform": [{"translate": [2, 1, 1]}]},
    {"geometry": "linear", "material": null, "interior": "plain"},
    {"geometry": "linear", "material": null, "interior": "wool", "transform": [{"translate": [0.1, 0.3, 0.2]}]},
    {"geometry": "nearest", "material": null, "interior": "mist", "transform": [{"translate": [0.2, 0, 0.1]}]},
    {"geometry": "half", "material": null, "interior": "dust"},
    {"geometry": "cubic", "material": null, "interior": "silk", "transform": [{"translate": [0.1, 0.3, 0.2]}]},
    {"geometry": "bytes", "material": null, "interior": "snow"},
    {"geometry": "pebble", "material": "matte", "transform": [{"scale": [0.8, 0.6, 0.7]}, {"translate": [0, 2.5, 0]}]},
    {"geometry": "blob", "material": "water", "transform": [{"translate": [0, -2.5, 0]}]}
  ]
})json";

// MATERIAL_VARIANTS of each kind. Every parameter that a kind describes is drawn over its range, in a quarter of the
// cases each left at its default, so that what is chosen by a zero (a metal by colour, not by index) is there too;
// roughnesses also hit 0 and 1.
inline std::vector<kernels::Material> draw_case_materials(unsigned seed) {
    std::mt19937 engine(seed);
    const auto uniform = [&](float lower, float upper) {
        return lower + (upper - lower) * (float(engine() >> 8) * 0x1p-24f);
    };
    std::vector<kernels::Material> materials;
    for (const MaterialInfo& info : material_infos())
        for (kernels::uint i = 0; i < kernels::MATERIAL_VARIANTS; ++i) {
            kernels::Material material = default_material(info.kind);
            for (const MaterialParameter& parameter : info.parameters) {
                if (uniform(0, 1) < 0.25f) continue;
                const float lower = parameter.minimum, upper = parameter.maximum;
                if (const auto* number = std::get_if<float kernels::Material::*>(&parameter.member)) {
                    // An index of 1 is no interface, and next to it the last bits decide.
                    float& value = material.*(*number);
                    value = parameter.name == "ior" ? uniform(1.05f, upper) : uniform(lower, upper);
                    if (parameter.name == "roughness" && i % 8 < 2) value = float(i % 8);
                } else if (const auto* color = std::get_if<vec3 kernels::Material::*>(&parameter.member)) {
                    for (int c = 0; c < 3; ++c) (material.*(*color))[c] = uniform(lower, upper);
                }
            }
            materials.push_back(material);
        }
    return materials;
}

inline Result<CompiledScene> make_case_scene() {
    const SceneLoaders no_files = {[](const auto&, const auto&) { return Error{"no models here"}; },
                                   [](const auto&) { return Error{"no pictures here"}; }};
    const Result<Scene> scene = read_scene_json(case_scene_json, "case_scene.json", no_files);
    if (!scene) return scene.error();
    Result<CompiledScene> compiled = compile(*scene);
    if (compiled) compiled->materials = draw_case_materials(1);
    return compiled;
}

// A compiled scene in a device's memory; `view` holds its addresses there.
class DeviceScene {
  public:
    static Result<DeviceScene> upload(VulkanDevice& device, const CompiledScene& scene) {
        DeviceScene there;
        kernels::SceneView view = scene.view();
        std::optional<Error> error;
        const auto move = [&](auto& array, const auto& values) {
            array.at = nullptr;
            if (values.empty() || error) return;
            using T = std::remove_cvref_t<decltype(values[0])>;
            auto buffer = device.create_buffer<T>(values);
            if (!buffer) return error = buffer.error(), void();
            array.at = reinterpret_cast<const T*>(buffer->address());
            there.buffers_.push_back(std::move(*buffer));
        };
        move(view.instances, scene.instances);
        move(view.instance_nodes, scene.instance_nodes);
        move(view.instance_order, scene.instance_order);
        move(view.slots, scene.slots);
        move(view.nodes, scene.nodes);
        move(view.kd_nodes, scene.kd_nodes);
        move(view.wide_units, scene.wide_units);
        move(view.sphere_nodes, scene.sphere_nodes);
        move(view.mesh_grids, scene.mesh_grids);
        move(view.unit_triangles, scene.unit_triangles);
        move(view.positions, scene.positions);
        move(view.triangles, scene.triangles);
        move(view.triangle_infos, scene.triangle_infos);
        move(view.normals, scene.normals);
        move(view.uvs, scene.uvs);
        move(view.tangents, scene.tangents);
        move(view.colors, scene.colors);
        move(view.meshes, scene.meshes);
        move(view.voxel_grids, scene.voxel_grids);
        move(view.sdf_ops, scene.sdf_ops);
        move(view.sdfs, scene.sdfs);
        move(view.interiors, scene.interiors);
        move(view.media, scene.media);
        move(view.grids, scene.grids);
        move(view.materials, scene.materials);
        move(view.textures, scene.textures);
        move(view.lights, scene.lights);
        move(view.light_table, scene.light_table);
        move(view.words, scene.words);
        move(view.floats, scene.floats);
        kernels::SceneViews views = {};
        move(views, std::vector<kernels::SceneView>{view});
        if (error) return *error;
        there.view_ = reinterpret_cast<uint64_t>(views.at);
        return there;
    }
    uint64_t view() const { return view_; }  // address of the SceneView

  private:
    std::vector<VulkanBuffer> buffers_;
    uint64_t view_ = 0;
};

}  // namespace spinel
