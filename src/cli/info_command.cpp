#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/load_options.h"
#include "image/pixels.h"
#include "scene/complete.h"
#include "scene/json_reader.h"
#include "scene/material_registry.h"
#include "scene/number_text.h"
#include "scene/validate.h"
#include "spinel/formats.h"

namespace spinel::cli {
namespace {

using Json = nlohmann::ordered_json;

// The double whose shortest text is the float's: 0.3, not 0.30000001192092896.
double number_json(float x) { return std::stod(number_text(x)); }
Json vector_json(vec3 v) { return {number_json(v.x), number_json(v.y), number_json(v.z)}; }

struct Describe {
    const Scene& scene;
    Json operator()(const MeshGeometry& mesh) const {
        return {{"vertices", mesh.positions.size()},
                {"triangles", mesh.triangles.size()},
                {"normals", !mesh.normals.empty()},
                {"uvs", !mesh.uvs.empty()}};
    }
    Json operator()(const VoxelGeometry& voxels) const {
        const ivec3 size = voxels.tree->size();
        return {{"size", {size.x, size.y, size.z}}, {"voxels", voxels.tree->voxel_count()}};
    }
    Json operator()(const VolumeGeometry& volume) const {
        const Grid& grid = scene.grids[std::size_t(volume.grid)];
        const ivec3 size = grid.samples->size();
        Json json = {{"size", {size.x, size.y, size.z}}};
        if (volume.surface) json["as"] = "surface";
        if (grid.samples->channels() > 1) json["channels"] = grid.samples->channels();
        json["minimum"] = number_json(grid.samples->minimum());
        json["maximum"] = number_json(grid.samples->maximum());
        if (!grid.unit.empty()) json["unit"] = grid.unit;
        // Bricks of 8³ that are stored, of those in the box.
        json["bricks"] = {grid.samples->stored_count(), grid.samples->table().size()};
        return json;
    }
    Json operator()(const SdfGeometry& sdf) const { return {{"operations", count(sdf.root)}}; }
    Json operator()(const SdfVoxelGeometry& voxels) const {
        return {{"operations", count(voxels.sdf.root)}, {"cell", number_json(voxels.cell)}};
    }
    Json operator()(const SphereGeometry& s) const { return {{"radius", number_json(s.radius)}}; }
    Json operator()(const BoxGeometry& b) const { return {{"size", vector_json(b.size)}}; }
    Json operator()(const PlaneGeometry&) const { return Json::object(); }
    Json operator()(const RectangleGeometry& r) const {
        return {{"size", {number_json(r.size.x), number_json(r.size.y)}}};
    }

    static std::size_t count(const SdfNode& node) {
        std::size_t n = 1;
        for (const SdfNode& child : node.children) n += count(child);
        return n;
    }
};

Json describe(const Scene& scene) {
    Json json;
    const std::vector<vec3> points = outline_points(scene);
    if (!points.empty()) {
        vec3 lower = points[0], upper = points[0];
        for (const vec3& p : points) {
            lower = glm::min(lower, p);
            upper = glm::max(upper, p);
        }
        json["bounds"] = {{"lower", vector_json(lower)}, {"upper", vector_json(upper)}};
    }
    json["geometries"] = Json::array();
    for (const Geometry& geometry : scene.geometries) {
        Json entry = {{"name", geometry.name}, {"type", std::string(kind_name(geometry))}};
        entry.update(std::visit(Describe{scene}, geometry.data));
        json["geometries"].push_back(entry);
    }
    json["objects"] = scene.objects.size();
    json["materials"] = Json::array();
    for (const Material& material : scene.materials)
        json["materials"].push_back(
            {{"name", material.name}, {"type", std::string(material_infos()[material.values.kind].name)}});
    json["textures"] = Json::array();
    for (const Texture& texture : scene.textures) {
        Json entry = {{"name", texture.name}};
        if (const auto* image = std::get_if<ImageTexture>(&texture.data)) {
            entry["file"] = image->file;
            entry["size"] = {image->pixels->width, image->pixels->height};
        }
        json["textures"].push_back(entry);
    }
    json["media"] = scene.media.size();
    json["lights"] = scene.lights.size();
    json["cameras"] = Json::array();
    for (const Camera& camera : scene.cameras) json["cameras"].push_back(camera.name);
    json["notes"] = scene.notes;
    return json;
}

void print(const std::string& file, const Json& json) {
    fmt::print("{}\n", file);
    if (json.contains("bounds")) {
        const auto& l = json["bounds"]["lower"];
        const auto& u = json["bounds"]["upper"];
        fmt::print("  bounds      ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g})\n", l[0].get<double>(),
                   l[1].get<double>(), l[2].get<double>(), u[0].get<double>(), u[1].get<double>(), u[2].get<double>());
    }
    fmt::print("  objects     {}\n", json["objects"].get<std::size_t>());
    const auto section = [&](const char* title, const char* key) {
        if (json[key].empty()) return;
        fmt::print("  {:<11} {}\n", title, json[key].size());
        std::size_t shown = 0;
        for (const auto& entry : json[key]) {
            if (++shown > 20) {
                fmt::print("    … and {} more\n", json[key].size() - 20);
                break;
            }
            std::string line = entry.is_string() ? entry.get<std::string>() : entry["name"].get<std::string>();
            if (line.empty()) line = "(unnamed)";
            if (entry.is_object())
                for (const auto& [name, value] : entry.items())
                    if (name != "name")
                        line += fmt::format("  {}{}", name == "type" ? "" : name + " ",
                                            value.is_string() ? value.get<std::string>() : value.dump());
            fmt::print("    {}\n", line);
        }
    };
    section("geometries", "geometries");
    section("materials", "materials");
    section("textures", "textures");
    section("cameras", "cameras");
    if (json["media"] != 0) fmt::print("  media       {}\n", json["media"].get<std::size_t>());
    section("notes", "notes");
    if (json["lights"] != 0) fmt::print("  lights      {}\n", json["lights"].get<std::size_t>());
}

int run(const std::vector<std::string>& files, const LoadOptions& options, const CommonOptions& common) {
    int code = exit_ok;
    for (const std::string& file : files) {
        const Result<Scene> scene = load_bare(file, options);
        if (!scene) {
            code = fail(scene.error());
            continue;
        }
        Json json = describe(*scene);
        if (common.json) {
            json["file"] = file;
            fmt::print("{}\n", json_text(json, 2));
        } else {
            print(file, json);
        }
    }
    return code;
}

}  // namespace

std::function<int()> info_command(CLI::App& app, const CommonOptions& common) {
    auto files = std::make_shared<std::vector<std::string>>();
    app.add_option("FILE", *files, "scene files or models")->required();
    auto options = std::make_shared<LoadOptions>();
    add_load_options(app, *options);
    return [files, options, &common] { return run(*files, *options, common); };
}

}  // namespace spinel::cli
