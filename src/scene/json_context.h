#pragma once
// What the parts of the scene reader share while they fill one Scene.

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scene/json_fields.h"
#include "scene/json_reader.h"

namespace spinel {

// What an object's "geometry" gives: one geometry without materials, or the objects of a model file.
struct GeometryParts {
    std::vector<Object> objects;
    bool from_file = false;
};

struct JsonContext {
    JsonReader& json;
    const SceneLoaders& loaders;
    std::filesystem::path folder;
    Scene& scene;
    NameTable textures{"texture", {}, {}};
    NameTable materials{"material", {}, {}};
    NameTable media{"medium", {}, {}};
    NameTable geometries{"geometry", {}, {}};
    std::map<std::string, std::shared_ptr<const PixelBuffer>> pictures = {};  // by path: an atlas is read once
    std::vector<GeometryParts> geometry_parts = {};                           // by index in `geometries`
};

// Each reads the value of one key of the scene file.
void read_materials(JsonContext& context, const JsonValue& value);   // json_materials.cpp
void read_geometries(JsonContext& context, const JsonValue& value);  // json_geometry.cpp
GeometryParts read_geometry(JsonContext& context, const JsonValue& value, const std::string& name);
SdfGeometry read_sdf(JsonContext& context, const JsonValue& value, const std::string& what);  // json_sdf.cpp
void read_objects(JsonContext& context, const JsonValue& value);                              // json_objects.cpp
mat4x3 read_transform(JsonContext& context, const JsonValue& value, const std::string& what);

// Reads "file": the path behind the scene's folder.
std::filesystem::path read_path(JsonContext& context, const JsonValue& value, const std::string& where);

inline std::string named(const char* noun, const std::string& name) { return std::string(noun) + " \"" + name + "\""; }

// Puts the alternative that `record` stands for into `data`, in its initial state; returns its address.
// Records stand in the order of the alternatives, from alternative `first` on.
template <std::size_t first = 0, class Variant>
void* emplace(Variant& data, const Family& family, const Record& record) {
    const std::size_t wanted = first + std::size_t(&record - family.records.data());
    void* address = nullptr;
    [&]<std::size_t... i>(std::index_sequence<i...>) {
        (void)((i == wanted ? (address = &data.template emplace<i>(), true) : false) || ...);
    }
    (std::make_index_sequence<std::variant_size_v<Variant>>());
    return address;
}

}  // namespace spinel
