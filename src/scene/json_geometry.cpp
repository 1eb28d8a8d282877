// Geometries of the scene file: written in place, or files that may bring several objects with their
// materials.

#include <algorithm>

#include "geometry/volume/level_set_fog.h"
#include "scene/json_context.h"
#include "scene/merge.h"
#include "scene/validate.h"

namespace spinel {
namespace {

// A geometry is either a file or written in place: `keys` are those of the second form.
bool has_no(JsonContext& context, const JsonValue& value, std::initializer_list<const char*> keys,
            const std::string& what, const char* instead) {
    for (const JsonMember& member : *value.object())
        for (const char* key : keys)
            if (member.key == key) {
                context.json.fail(member.offset, "\"" + member.key + "\" of " + what + " excludes \"" + instead + "\"");
                return false;
            }
    return true;
}

const JsonValue* needed(JsonContext& context, const JsonValue& value, const char* key, const std::string& what,
                        const std::string& otherwise) {
    const JsonValue* found = value.find(key);
    if (!found) context.json.fail(value, what + " needs \"" + key + "\"" + otherwise);
    return found;
}

// A list of vectors of `count` numbers each.
template <class Vector>
std::vector<Vector> read_vectors(JsonContext& context, const JsonValue* value, std::size_t count,
                                 const std::string& where) {
    std::vector<Vector> vectors;
    if (!value) return vectors;
    if (value->array()) vectors.reserve(value->array()->size());
    context.json.elements(*value, where, [&](const JsonValue& element, std::size_t) {
        Vector v(0);
        context.json.numbers(element, count, any, where, &v[0]);
        vectors.push_back(v);
    });
    return vectors;
}

template <class T>
std::vector<T> read_integers(JsonContext& context, const JsonValue* value, int upper, const std::string& where) {
    std::vector<T> integers;
    if (!value) return integers;
    if (value->array()) integers.reserve(value->array()->size());
    context.json.elements(*value, where, [&](const JsonValue& element, std::size_t) {
        integers.push_back(T(context.json.integer(element, {0, double(upper)}, where).value_or(0)));
    });
    return integers;
}

std::string of(const char* key, const std::string& what) { return "\"" + std::string(key) + "\" of " + what; }

MeshGeometry read_mesh(JsonContext& context, const JsonValue& value, const std::string& what) {
    MeshGeometry mesh;
    const JsonValue* positions = needed(context, value, "positions", what, " (or \"file\")");
    const JsonValue* triangles = needed(context, value, "triangles", what, "");
    mesh.positions = read_vectors<vec3>(context, positions, 3, of("positions", what));
    mesh.normals = read_vectors<vec3>(context, value.find("normals"), 3, of("normals", what));
    mesh.uvs = read_vectors<vec2>(context, value.find("uvs"), 2, of("uvs", what));
    mesh.second_uvs = read_vectors<vec2>(context, value.find("second_uvs"), 2, of("second_uvs", what));
    mesh.tangents = read_vectors<vec4>(context, value.find("tangents"), 4, of("tangents", what));
    mesh.colors = read_vectors<vec4>(context, value.find("colors"), 4, of("colors", what));
    mesh.slots = read_integers<std::uint32_t>(context, value.find("slots"), 65535, of("slots", what));
    if (!triangles || mesh.positions.empty()) return mesh;
    const std::string where = of("triangles", what);
    const Range vertex{0, double(mesh.positions.size() - 1)};
    context.json.elements(*triangles, where, [&](const JsonValue& element, std::size_t) {
        uvec3 corners(0);
        if (!element.array() || element.array()->size() != 3)
            context.json.fail(element, where + " must be arrays of 3 vertex indices, not " + element.description());
        else
            for (int i = 0; i < 3; ++i)
                corners[i] =
                    kernels::uint(context.json.integer((*element.array())[std::size_t(i)], vertex, where).value_or(0));
        mesh.triangles.push_back(corners);
    });
    return mesh;
}

// '.' and ' ' are empty, 1…9 and a…z the palette indices 1…35; −1: not a voxel's character.
int palette_index(char c) {
    if (c == '.' || c == ' ') return 0;
    if (c >= '1' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'z') return c - 'a' + 10;
    return -1;
}

VoxelGeometry voxels_of(JsonContext& context, const JsonValue& value, const std::string& what, ivec3 size,
                        const std::vector<std::uint16_t>& cells) {
    if (context.json.error()) return {};
    const Result<VoxelTreePointer> tree = build_voxel_tree(size, cells);
    if (!tree) {
        context.json.fail(value, what + ": " + tree.error().message);
        return {};
    }
    return {*tree};
}

VoxelGeometry read_layers(JsonContext& context, const JsonValue& value, const std::string& what) {
    const std::string where = of("layers", what);
    ivec3 size(0);
    std::vector<const std::string*> rows;
    context.json.elements(value, where, [&](const JsonValue& layer, std::size_t y) {
        context.json.elements(layer, where, [&](const JsonValue& row, std::size_t z) {
            const auto text = context.json.text(row, where);
            if (!text) return;
            if (y == 0 && z == 0) size.x = int(text->size());
            if (int(text->size()) != size.x)
                context.json.fail(row, where + ": a row of " + std::to_string(text->size()) +
                                           " characters, but the first row has " + std::to_string(size.x));
            for (const char c : *text)
                if (palette_index(c) < 0)
                    context.json.fail(row, where + ": '" + std::string(1, c) +
                                               "' is no voxel; allowed: '.' and ' ' (empty), 1…9, a…z");
            rows.push_back(row.text());
        });
        const int depth = layer.array() ? int(layer.array()->size()) : 0;
        if (y == 0) size.z = depth;
        if (depth != size.z)
            context.json.fail(layer, where + ": a layer of " + std::to_string(depth) + " rows, but the first has " +
                                         std::to_string(size.z));
    });
    if (context.json.error()) return {};
    size.y = int(value.array()->size());
    if (rows.empty()) context.json.fail(value, where + " holds no voxels");
    // Rows came layer by layer and from z = 0 on; cells run x fastest, then y, then z.
    std::vector<std::uint16_t> cells;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (const char c : *rows[std::size_t(y) * std::size_t(size.z) + std::size_t(z)])
                cells.push_back(std::uint16_t(palette_index(c)));
    return voxels_of(context, value, what, size, cells);
}

VoxelGeometry read_voxels(JsonContext& context, const JsonValue& value, const std::string& what) {
    if (const JsonValue* layers = value.find("layers")) {
        if (!has_no(context, value, {"size", "cells"}, what, "layers")) return {};
        return read_layers(context, *layers, what);
    }
    const JsonValue* size = needed(context, value, "size", what, " with \"cells\" (or \"layers\" or \"file\")");
    const JsonValue* cells = needed(context, value, "cells", what, "");
    if (!size || !cells) return {};
    const ivec3 edges = context.json.size(*size, of("size", what)).value_or(ivec3(0));
    return voxels_of(context, value, what, edges,
                     read_integers<std::uint16_t>(context, cells, 65535, of("cells", what)));
}

std::optional<VoxelOutlines> read_outlines(JsonContext& context, const JsonValue& value, const std::string& what) {
    const JsonValue* outlines = value.find("outlines");
    if (!outlines) return {};
    VoxelOutlines read;
    context.json.record(*outlines, outlines_record(), &read, "\"outlines\" of " + what);
    return read;
}

std::optional<VoxelWaves> read_waves(JsonContext& context, const JsonValue& value, const std::string& what) {
    const JsonValue* waves = value.find("waves");
    if (!waves) return {};
    const std::string where = of("waves", what);
    VoxelWaves read;
    if (!context.json.record(*waves, waves_record(), &read, where)) return read;
    if (const JsonValue* palette = waves->find("palette"))
        context.json.elements(*palette, of("palette", where), [&](const JsonValue& index, std::size_t) {
            read.palette.push_back(context.json.integer(index, {1, 65535}, of("palette", where)).value_or(1));
        });
    return read;
}

// One number for all, or one a palette index.
std::vector<float> read_rounding(JsonContext& context, const JsonValue& value, const std::string& what) {
    std::vector<float> radii;
    const JsonValue* rounding = value.find("rounding");
    if (!rounding) return radii;
    const auto add = [&](const JsonValue& number) {
        radii.push_back(float(context.json.number(number, {0, 0.5}, of("rounding", what)).value_or(0)));
    };
    if (rounding->array()) {
        for (const JsonValue& number : *rounding->array()) add(number);
        // One in a list is that of palette index 1, not of all.
        if (radii.size() == 1) radii.push_back(0);
    } else {
        add(*rounding);
    }
    return radii;
}

// How voxels look, whether written here or in a file.
void read_looks(JsonContext& context, const JsonValue& value, const std::vector<Object>& parts,
                const std::string& what) {
    const std::vector<float> rounding = read_rounding(context, value, what);
    const auto outlines = read_outlines(context, value, what);
    const auto waves = read_waves(context, value, what);
    if (context.json.error()) return;
    for (const Object& part : parts) {
        Geometry& geometry = context.scene.geometries[std::size_t(part.geometry)];
        auto* voxels = std::get_if<VoxelGeometry>(&geometry.data);
        if (!voxels) continue;
        voxels->rounding = rounding;
        voxels->outlines = outlines;
        voxels->waves = waves;
        if (const auto f = fault(geometry)) context.json.fail(value, what + " " + *f);
    }
}

void read_sdf_voxels(JsonContext& context, const JsonValue& value, const std::string& what, SdfVoxelGeometry& voxels) {
    voxels.sdf = read_sdf(context, value, what);
    voxels.outlines = read_outlines(context, value, what);
    if (const JsonValue* strata = value.find("strata"))
        context.json.elements(*strata, of("strata", what), [&](const JsonValue& height, std::size_t) {
            voxels.strata.push_back(float(context.json.number(height, any, of("strata", what)).value_or(0)));
        });
}

Grid read_grid(JsonContext& context, const JsonValue& value, const std::string& what, const std::string& name) {
    Grid grid;
    grid.name = name;
    const JsonValue* size = needed(context, value, "size", what, " with \"values\" (or \"file\")");
    const JsonValue* values = needed(context, value, "values", what, "");
    const ivec3 edges = size ? context.json.size(*size, of("size", what)).value_or(ivec3(0)) : ivec3(0);
    if (const JsonValue* transform = value.find("transform"))
        grid.index_to_local = read_transform(context, *transform, what);
    if (!values) return grid;
    const std::string where = of("values", what);
    std::vector<float> read;
    context.json.elements(*values, where, [&](const JsonValue& element, std::size_t) {
        read.push_back(float(context.json.number(element, any, where).value_or(0)));
    });
    if (context.json.error()) return grid;
    Result<GridPointer> samples = build_grid(edges, read);
    if (!samples) {
        context.json.fail(value, what + " " + samples.error().message);
        return grid;
    }
    grid.samples = *samples;
    if (const auto f = fault(grid)) context.json.fail(value, what + " " + *f);
    return grid;
}

// The objects of a model file, merged into the scene.
std::vector<Object> read_model(JsonContext& context, const JsonValue& file, const LoadOptions& options,
                               const Record& record, const std::string& what) {
    const auto path = read_path(context, file, of("file", what));
    if (path.empty()) return {};
    Result<Scene> model = context.loaders.model(path, options);
    if (!model) {
        context.json.fail(file, model.error().message);
        return {};
    }
    if (const Result<void> valid = validate(*model); !valid) {
        context.json.fail(file, path.string() + ": " + valid.error().message);
        return {};
    }
    if (model->objects.empty()) context.json.fail(file, path.string() + " holds no objects");
    for (const Object& object : model->objects) {
        const Geometry& geometry = model->geometries[std::size_t(object.geometry)];
        // Blocks that are no cubes come as meshes along with voxels.
        if (kind_name(geometry) == record.type || (record.type == "voxels" && kind_name(geometry) == "mesh" &&
                                                   kind_name(model->geometries.front()) == "voxels"))
            continue;
        context.json.fail(file, what + " is of type \"" + std::string(record.type) + "\", but " + path.string() +
                                    " holds a geometry of type \"" + std::string(kind_name(geometry)) + "\"");
        return {};
    }
    return merge_model(context.scene, *std::move(model));
}

// "frame", "height" and "grid" of what is in a file.
LoadOptions read_load_options(JsonContext& context, const JsonValue& value, const std::string& what) {
    LoadOptions options;
    if (const JsonValue* frame = value.find("frame"))
        options.frame = context.json.integer(*frame, {0, 1 << 20}, of("frame", what));
    if (const JsonValue* height = value.find("height"))
        if (const auto number = context.json.number(*height, {1, 65536}, of("height", what)))
            options.heightmap = float(*number);
    if (const JsonValue* grid = value.find("grid"))
        options.grid = context.json.text(*grid, of("grid", what)).value_or("");
    return options;
}

// A voxel set's "level_of_detail", also for those of a file.
void read_level_of_detail(JsonContext& context, const JsonValue& value, const std::vector<Object>& parts,
                          const std::string& what) {
    const JsonValue* level = value.find("level_of_detail");
    if (!level) return;
    const auto pixels = context.json.number(*level, {0, 1024}, of("level_of_detail", what));
    if (!pixels) return;
    for (const Object& part : parts)
        if (auto* voxels = std::get_if<VoxelGeometry>(&context.scene.geometries[std::size_t(part.geometry)].data))
            voxels->level_of_detail = float(*pixels);
}

// What a volume is shown as: "as", "level", "solid".
void read_look(JsonContext& context, const JsonValue& value, std::vector<Object>& parts, const std::string& what) {
    std::optional<int> as;
    if (const JsonValue* chosen = value.find("as")) as = context.json.choice(*chosen, volume_looks, of("as", what));
    for (Object& part : parts) {
        auto* volume = std::get_if<VolumeGeometry>(&context.scene.geometries[std::size_t(part.geometry)].data);
        if (!volume) continue;
        Grid& grid = context.scene.grids[std::size_t(volume->grid)];
        const bool surface = as ? *as == 1 : volume->surface;
        if (!surface)
            for (const char* key : {"level", "solid"})
                if (value.find(key)) context.json.fail(value, of(key, what) + " needs \"as\": \"surface\"");
        if (surface && !volume->surface) {  // what the file made of it was fog
            part.materials.clear();
            part.interior = -1;
        }
        if (!surface && grid.level_set) {
            grid = fog_of_level_set(grid);
            part.materials = {-1};
        }
        volume->surface = surface;
        if (const JsonValue* level = value.find("level"))
            volume->level = float(context.json.number(*level, any, of("level", what)).value_or(0));
        if (const JsonValue* solid = value.find("solid"))
            volume->solid_above = context.json.choice(*solid, solid_sides, of("solid", what)).value_or(0) == 1;
    }
}

// A volume's "filter" and "precision" replace those of the grids it brings.
void read_look_up(JsonContext& context, const JsonValue& value, const std::vector<Object>& parts,
                  const std::string& what) {
    std::optional<int> filter, precision;
    if (const JsonValue* chosen = value.find("filter"))
        filter = context.json.choice(*chosen, volume_filters, of("filter", what));
    if (const JsonValue* chosen = value.find("precision"))
        precision = context.json.choice(*chosen, grid_precisions, of("precision", what));
    for (const Object& part : parts) {
        const auto* volume = std::get_if<VolumeGeometry>(&context.scene.geometries[std::size_t(part.geometry)].data);
        if (!volume) continue;
        Grid& grid = context.scene.grids[std::size_t(volume->grid)];
        if (filter) grid.filter = Filter(*filter);
        if (precision) grid.precision = GridPrecision(*precision);
    }
}

}  // namespace

GeometryParts read_geometry(JsonContext& context, const JsonValue& value, const std::string& name) {
    const std::string what = named("geometry", name);
    const Family& family = geometry_family();
    const Record* record = context.json.select(value, family, what);
    if (!record) return {};
    Geometry geometry{name, {}};
    void* data = emplace(geometry.data, family, *record);
    context.json.record(value, *record, record->defaults ? data : nullptr, what);

    GeometryParts parts;
    const JsonValue* file = record->find("file") ? value.find("file") : nullptr;
    if (file) {
        const bool alone = has_no(context, value,
                                  {"positions", "triangles", "normals", "uvs", "second_uvs", "tangents", "colors",
                                   "slots", "size", "cells", "layers", "values", "transform"},
                                  what, "file");
        if (!alone) return {};
        parts.from_file = true;
        parts.objects = read_model(context, *file, read_load_options(context, value, what), *record, what);
    } else {
        if (!has_no(context, value, {"frame", "height", "grid"}, what, record->type == "volume" ? "values" : "cells"))
            return {};
        if (auto* mesh = std::get_if<MeshGeometry>(&geometry.data)) *mesh = read_mesh(context, value, what);
        if (auto* voxels = std::get_if<VoxelGeometry>(&geometry.data)) *voxels = read_voxels(context, value, what);
        if (auto* sdf = std::get_if<SdfGeometry>(&geometry.data)) *sdf = read_sdf(context, value, what);
        if (auto* voxels = std::get_if<SdfVoxelGeometry>(&geometry.data))
            read_sdf_voxels(context, value, what, *voxels);
        if (auto* volume = std::get_if<VolumeGeometry>(&geometry.data)) {
            volume->grid = int(context.scene.grids.size());
            context.scene.grids.push_back(read_grid(context, value, what, name));
        }
        if (!context.json.error())
            if (const auto f = fault(geometry)) context.json.fail(value, what + " " + *f);
        Object object;
        object.geometry = int(context.scene.geometries.size());
        context.scene.geometries.push_back(std::move(geometry));
        parts.objects.push_back(std::move(object));
    }
    if (record->type == "volume") {
        read_look(context, value, parts.objects, what);
        read_look_up(context, value, parts.objects, what);
    }
    read_level_of_detail(context, value, parts.objects, what);
    if (record->type == "voxels") read_looks(context, value, parts.objects, what);
    return parts;
}

void read_geometries(JsonContext& context, const JsonValue& value) {
    if (!value.object()) return;  // said already, when the names were collected
    for (const JsonMember& member : *value.object())
        context.geometry_parts.push_back(read_geometry(context, member.value, member.key));
}

}  // namespace spinel
