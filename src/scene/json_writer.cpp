#include "scene/json_writer.h"

#include <optional>
#include <set>

#include "geometry/sdf/sdf_text.h"
#include "scene/json_values.h"
#include "scene/material_fields.h"
#include "scene/material_registry.h"
#include "scene/scene_fields.h"
#include "scene/validate.h"

namespace spinel {
namespace {

using Names = std::vector<std::string>;

// A name for each thing: its own, or made up where that is missing or taken.
template <class T>
Names unique_names(const std::vector<T>& things, const std::string& noun) {
    Names names;
    std::set<std::string> taken;
    for (const T& thing : things) taken.insert(thing.name);
    std::set<std::string> given;
    for (const T& thing : things) {
        std::string name = thing.name;
        for (int i = 1; name.empty() || given.contains(name); ++i) {
            name = (thing.name.empty() ? noun : thing.name) + " " + std::to_string(i);
            if (taken.contains(name)) name.clear();
        }
        given.insert(name);
        names.push_back(name);
    }
    return names;
}

template <class Vector>
OrderedJson vectors(const std::vector<Vector>& values) {
    OrderedJson list = OrderedJson::array();
    for (const Vector& v : values) {
        OrderedJson element = OrderedJson::array();
        for (int i = 0; i < Vector::length(); ++i) element.push_back(json_number(float(v[i])));
        list.push_back(std::move(element));
    }
    return list;
}

OrderedJson indices(const std::vector<uvec3>& values) {
    OrderedJson list = OrderedJson::array();
    for (const uvec3& v : values) list.push_back({v.x, v.y, v.z});
    return list;
}

OrderedJson floats(const std::vector<float>& values) {
    OrderedJson list = OrderedJson::array();
    for (const float x : values) list.push_back(json_number(x));
    return list;
}

OrderedJson triple(const ivec3& v) { return {v.x, v.y, v.z}; }

OrderedJson matrix(const mat4x3& m) {
    OrderedJson list = OrderedJson::array();
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column) list.push_back(json_number(m[column][row]));
    return list;
}

class Writer {
  public:
    explicit Writer(const Scene& scene)
        : scene_(scene),
          textures_(unique_names(scene.textures, "texture")),
          materials_(unique_names(scene.materials, "material")),
          media_(unique_names(scene.media, "medium")),
          geometries_(unique_names(scene.geometries, "geometry")) {}

    Result<std::string> write() {
        OrderedJson root = {{"version", 1}};
        cameras(root);
        root["film"] = changes(film_record(), &scene_.film);
        root["integrator"] = changes(integrator_record(), &scene_.integrator);
        if (OrderedJson accelerator = changes(accelerator_record(), &scene_.accelerator); !accelerator.empty())
            root["accelerator"] = std::move(accelerator);
        if (OrderedJson march = changes(march_record(), &scene_.integrator.march); !march.empty())
            root["integrator"]["march"] = std::move(march);
        if (OrderedJson dvr = dvr_value(scene_.integrator.dvr); !dvr.empty())
            root["integrator"]["dvr"] = std::move(dvr);
        environment(root);
        for (std::size_t i = 0; i < textures_.size(); ++i) root["textures"][textures_[i]] = texture(scene_.textures[i]);
        for (std::size_t i = 0; i < materials_.size(); ++i)
            root["materials"][materials_[i]] = material(scene_.materials[i].values);
        for (std::size_t i = 0; i < media_.size(); ++i) root["media"][media_[i]] = medium(scene_.media[i]);
        for (std::size_t i = 0; i < geometries_.size(); ++i)
            root["geometries"][geometries_[i]] = geometry(scene_.geometries[i]);
        for (const Object& object : scene_.objects) root["objects"].push_back(object_value(object));
        for (const Light& light : scene_.lights) root["lights"].push_back(light_value(light));
        if (scene_.expected) root["expected"] = changes(expected_record(), &*scene_.expected);
        if (error_) return *error_;
        return root.dump(1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
    }

  private:
    OrderedJson dvr_value(const DvrOptions& dvr) {
        OrderedJson value = changes(dvr_record(), &dvr);
        for (const TransferPoint& point : dvr.points)
            value["points"].push_back(changes(transfer_point_record(), &point));
        for (const vec4& p : dvr.clip_planes)
            value["clip_planes"].push_back({json_number(p.x), json_number(p.y), json_number(p.z), json_number(p.w)});
        return value;
    }

    // The rows that differ from their defaults, and those that are required.
    OrderedJson changes(const Record& record, const void* instance) {
        OrderedJson object = OrderedJson::object();
        if (!record.type.empty()) object["type"] = record.type;
        for (const Field& field : record.fields) {
            if (field.kind == FieldKind::by_hand) continue;
            const OrderedJson value = json_value(field, instance);
            kernels::uint texture = kernels::NONE;
            if (field.texture)
                texture = *reinterpret_cast<const kernels::uint*>(static_cast<const char*>(instance) + *field.texture);
            if (texture != kernels::NONE)
                object[std::string(field.name)] = value == OrderedJson(1)
                                                      ? OrderedJson(textures_[texture])
                                                      : OrderedJson{{"texture", textures_[texture]}, {"factor", value}};
            else if (field.required || value != json_value(field, record.defaults))
                object[std::string(field.name)] = value;
        }
        return object;
    }

    // Of an alternative of a variant whose records begin at alternative `first`.
    template <class Variant>
    OrderedJson alternative(const Family& family, const Variant& data, std::size_t first = 0) {
        const Record& record = family.records[data.index() - first];
        return std::visit([&](const auto& value) { return changes(record, &value); }, data);
    }

    OrderedJson picture(const std::string& file, const std::string& what) {
        if (file.empty() && !error_)
            error_ = Error{what + " has a picture that is in no file of its own, so a scene file cannot name it"};
        return file;
    }

    void cameras(OrderedJson& root) {
        const auto camera = [&](const Camera& c) { return changes(camera_family().records[std::size_t(c.kind)], &c); };
        if (scene_.cameras.size() == 1 && scene_.cameras[0].name.empty()) {
            root["camera"] = camera(scene_.cameras[0]);
            return;
        }
        const Names names = unique_names(scene_.cameras, "camera");
        for (std::size_t i = 0; i < names.size(); ++i) root["cameras"][names[i]] = camera(scene_.cameras[i]);
    }

    void environment(OrderedJson& root) {
        if (std::holds_alternative<std::monostate>(scene_.environment)) return;
        OrderedJson& value = root["environment"] = alternative(environment_family(), scene_.environment, 1);
        if (const auto* image = std::get_if<ImageEnvironment>(&scene_.environment))
            value["file"] = picture(image->file, "the environment");
    }

    OrderedJson texture(const Texture& texture) {
        OrderedJson value = alternative(texture_family(), texture.data);
        if (const auto* image = std::get_if<ImageTexture>(&texture.data)) {
            value["file"] = picture(image->file, "texture \"" + texture.name + "\"");
            value["srgb"] = image->srgb;  // its default depends on the picture
        } else if (const auto* faces = std::get_if<FaceTexture>(&texture.data)) {
            static constexpr const char* names[6] = {"west", "east", "bottom", "top", "north", "south"};
            value["file"] = picture(faces->file, "texture \"" + texture.name + "\"");
            value["srgb"] = faces->srgb;
            for (std::size_t i = 0; i < 6; ++i) {
                const glm::ivec4& r = faces->faces[i];
                value[names[i]] = {r.x, r.y, r.z, r.w};
            }
        }
        return value;
    }

    OrderedJson material(const kernels::Material& m) {
        const MaterialInfo& info = *find_material_info(m.kind);
        const Record& record = material_family().records[std::size_t(&info - material_infos().data())];
        OrderedJson value = changes(record, &m);
        if (!info.presets.empty() && (m.eta != vec3(0) || m.k != vec3(0))) {  // by complex index, not by colour
            value.erase("color");
            value.erase("edge_color");
            value["eta"] = json_value(*record.find("eta"), &m);
            value["k"] = json_value(*record.find("k"), &m);
        }
        if (record.find("interior") && m.interior != kernels::NONE) value["interior"] = media_[m.interior];
        if (m.normal_texture != kernels::NONE) value["normal_map"] = textures_[m.normal_texture];
        return value;
    }

    OrderedJson medium(const Medium& medium) {
        OrderedJson value = changes(medium_record(), &medium);
        if (medium.erosion.kind != Erosion::Kind::none) value["erosion"] = changes(erosion_record(), &medium.erosion);
        volume(medium, "density", medium.grid, value);
        volume(medium, "albedo", medium.albedo, value);
        volume(medium, "temperature", medium.temperature, value);
        return value;
    }

    void volume(const Medium& medium, const char* key, int grid, OrderedJson& value) {
        if (grid < 0) return;
        for (std::size_t i = 0; i < geometries_.size(); ++i) {
            const auto* volume = std::get_if<VolumeGeometry>(&scene_.geometries[i].data);
            if (!volume || volume->grid != grid) continue;
            value[key] = geometries_[i];
            return;
        }
        if (!error_)
            error_ = Error{"medium \"" + medium.name + "\" has a " + key + " that no volume of the scene holds"};
    }

    OrderedJson geometry(const Geometry& geometry) {
        const Record& record = geometry_family().records[geometry.data.index()];
        OrderedJson value = {{"type", record.type}};
        if (record.defaults) value = alternative(geometry_family(), geometry.data);
        if (const auto* mesh = std::get_if<MeshGeometry>(&geometry.data)) {
            value["positions"] = vectors(mesh->positions);
            value["triangles"] = indices(mesh->triangles);
            if (!mesh->normals.empty()) value["normals"] = vectors(mesh->normals);
            if (!mesh->uvs.empty()) value["uvs"] = vectors(mesh->uvs);
            if (!mesh->second_uvs.empty()) value["second_uvs"] = vectors(mesh->second_uvs);
            if (!mesh->tangents.empty()) value["tangents"] = vectors(mesh->tangents);
            if (!mesh->colors.empty()) value["colors"] = vectors(mesh->colors);
            if (!mesh->slots.empty()) value["slots"] = mesh->slots;
        } else if (const auto* voxels = std::get_if<VoxelGeometry>(&geometry.data)) {
            const ivec3 size = voxels->tree->size();
            value["size"] = triple(size);
            value["cells"] = cells(*voxels->tree);
            if (voxels->level_of_detail > 0) value["level_of_detail"] = json_number(voxels->level_of_detail);
            if (voxels->rounding.size() == 1) value["rounding"] = json_number(voxels->rounding[0]);
            else if (!voxels->rounding.empty()) value["rounding"] = floats(voxels->rounding);
            if (voxels->outlines) value["outlines"] = changes(outlines_record(), &*voxels->outlines);
            if (voxels->waves) {
                value["waves"] = changes(waves_record(), &*voxels->waves);
                value["waves"]["palette"] = voxels->waves->palette;
            }
        } else if (const auto* volume = std::get_if<VolumeGeometry>(&geometry.data)) {
            const Grid& grid = scene_.grids[std::size_t(volume->grid)];
            value["size"] = triple(grid.samples->size());
            value["values"] = floats(grid.samples->dense());
            if (grid.index_to_local != mat4x3(1)) value["transform"] = matrix(grid.index_to_local);
            value["filter"] = volume_filters[std::size_t(grid.filter)];
            if (volume->surface) value["as"] = volume_looks[1];
            if (volume->surface && volume->level != 0) value["level"] = json_number(volume->level);
            if (volume->surface && volume->solid_above) value["solid"] = solid_sides[1];
            if (grid.precision != GridPrecision::full)
                value["precision"] = grid_precisions[std::size_t(grid.precision)];
        } else if (const auto* sdf = std::get_if<SdfGeometry>(&geometry.data)) {
            value["expression"] = sdf_text(sdf->root);
            if (sdf->bounds) value["bounds"] = vectors(std::vector<vec3>{sdf->bounds->first, sdf->bounds->second});
        } else if (const auto* procedural = std::get_if<SdfVoxelGeometry>(&geometry.data)) {
            const SdfGeometry& solid = procedural->sdf;
            value["expression"] = sdf_text(solid.root);
            if (solid.bounds) value["bounds"] = vectors(std::vector<vec3>{solid.bounds->first, solid.bounds->second});
            if (!procedural->strata.empty()) value["strata"] = floats(procedural->strata);
            if (procedural->outlines) value["outlines"] = changes(outlines_record(), &*procedural->outlines);
        }
        return value;
    }

    // Every cell is written, the empty ones too, so sparse sets of great size have no place in a scene file.
    std::vector<std::uint16_t> cells(const VoxelTree& tree) {
        constexpr std::uint64_t limit = 1u << 26;
        const glm::u64vec3 size(tree.size());
        if (size.x * size.y > limit || size.x * size.y * size.z > limit) {
            error_ = Error{"a voxel set of " + std::to_string(size.x) + "×" + std::to_string(size.y) + "×" +
                           std::to_string(size.z) + " cells cannot be written into a scene file: at most " +
                           std::to_string(limit) + " cells"};
            return {};
        }
        std::vector<std::uint16_t> cells(size.x * size.y * size.z, 0);
        tree.for_each([&](ivec3 cell, std::uint16_t palette) {
            cells[std::size_t(cell.x) + size.x * (std::size_t(cell.y) + size.y * std::size_t(cell.z))] = palette;
        });
        return cells;
    }

    OrderedJson object_value(const Object& object) {
        OrderedJson value = OrderedJson::object();
        if (!object.name.empty()) value["name"] = object.name;
        value["geometry"] = geometries_[std::size_t(object.geometry)];
        OrderedJson slots = OrderedJson::array();
        for (const int material : object.materials)
            slots.push_back(material < 0 ? OrderedJson() : OrderedJson(materials_[std::size_t(material)]));
        if (slots.size() == 1) value["material"] = slots[0];
        else if (!slots.empty()) value["material"] = std::move(slots);
        if (object.interior >= 0) value["interior"] = media_[std::size_t(object.interior)];
        if (object.transform != mat4x3(1)) value["transform"] = matrix(object.transform);
        return value;
    }

    OrderedJson light_value(const Light& light) {
        OrderedJson value = alternative(light_family(), light.data);
        if (!light.name.empty()) value["name"] = light.name;
        return value;
    }

    const Scene& scene_;
    Names textures_, materials_, media_, geometries_;
    std::optional<Error> error_;
};

}  // namespace

Result<std::string> write_scene_json(const Scene& scene) {
    if (const Result<void> valid = validate(scene); !valid) return valid.error();
    return Writer(scene).write();
}

}  // namespace spinel
