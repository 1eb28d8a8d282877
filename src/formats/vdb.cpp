// With vdb_volume.cpp the only file that includes OpenVDB: its headers are slow to compile.
#include "formats/vdb.h"

#include <fmt/format.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <type_traits>

#include "core/atomic_file.h"
#include "formats/file_bytes.h"
#include "formats/left_out.h"
#include "formats/vdb_layout.h"
#include "formats/vdb_volume.h"
#include "image/palette.h"
#include "kernels/materials.h"
#include "scene/json_reader.h"
#include "scene/json_writer.h"
#include "scene/material_registry.h"
#include "scene/validate.h"

namespace spinel {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

constexpr const char* size_key = "spinel_size";
constexpr const char* materials_key = "spinel_materials";

template <class Value>
std::uint16_t palette_index(Value value) {
    if constexpr (std::is_same_v<Value, bool> || std::is_same_v<Value, openvdb::ValueMask>) return 1;
    else return value >= Value(1) && value <= Value(65535) && value == std::floor(value) ? std::uint16_t(value) : 1;
}

// The cells of a grid from `origin` on; answers for boxes as far as they lie in tiles.
template <class GridType>
Result<VoxelTreePointer> tree_of(const GridType& grid, Coord origin, ivec3 size) {
    using Accessor = typename GridType::ConstUnsafeAccessor;
    tbb::enumerable_thread_specific<Accessor> accessors([&] { return grid.getConstUnsafeAccessor(); });
    const auto look = [](const Accessor& accessor, const Coord& c) {
        typename GridType::ValueType value;
        return accessor.probeValue(c, value) ? palette_index(value) : std::uint16_t(0);
    };
    const auto at = [&](ivec3 cell) { return look(accessors.local(), origin.offsetBy(cell.x, cell.y, cell.z)); };
    const auto box = [&](ivec3 lower, ivec3 upper) -> std::optional<std::uint16_t> {
        const Accessor& accessor = accessors.local();
        // Where nothing finer than tiles of an edge is, all of their rows are alike.
        constexpr int tile_edges[] = {4096, 4096, 128, 8};  // at the depths −1 (background), 0, 1, 2; 3 is a voxel
        const auto next = [](int at, int edge) { return (at & ~(edge - 1)) + edge; };
        const Coord first = origin.offsetBy(lower.x, lower.y, lower.z),
                    end = origin.offsetBy(upper.x, upper.y, upper.z);
        std::optional<std::uint16_t> all;
        int z_edge = 4096;
        for (int z = first.z(); z < end.z(); z = next(z, z_edge)) {
            z_edge = 4096;
            int y_edge = 4096;
            for (int y = first.y(); y < end.y(); y = next(y, y_edge)) {
                y_edge = 4096;
                for (int x = first.x(), edge; x < end.x(); x = next(x, edge)) {
                    const Coord c(x, y, z);
                    const int depth = accessor.getValueDepth(c);
                    if (depth >= 3) return std::nullopt;
                    edge = tile_edges[depth + 1];
                    y_edge = std::min(y_edge, edge);
                    const std::uint16_t here = look(accessor, c);
                    if (all && *all != here) return std::nullopt;
                    all = here;
                }
                z_edge = std::min(z_edge, y_edge);
            }
        }
        return all;
    };
    return build_voxel_tree(size, {at, box});
}

// Colours that are easily told apart: hues by the golden ratio.
std::vector<Material> plain_materials(std::size_t count) {
    std::vector<Material> materials;
    for (std::size_t i = 0; i < count; ++i) {
        const float hue = 6.2831853f * float(std::fmod(0.08 + 0.61803398875 * double(i), 1.0));
        const float lightness = 0.62f + 0.12f * float(int(i % 3) - 1);
        Material m{fmt::format("palette {}", i + 1), default_material(kernels::MATERIAL_DIFFUSE)};
        m.values.color =
            glm::clamp(linear_of_oklab({lightness, 0.11f * std::cos(hue), 0.11f * std::sin(hue)}), 0.0f, 1.0f);
        materials.push_back(std::move(m));
    }
    return materials;
}

class Reader {
  public:
    Reader(const std::filesystem::path& path, const LoadOptions& options) : path_(path), options_(options) {}

    Result<Scene> read() {
        const Result<std::vector<VdbGridEntry>> listed = read_vdb_layout(path_);
        if (!listed) return listed.error();
        const bool volumes = std::any_of(listed->begin(), listed->end(),
                                         [](const VdbGridEntry& grid) { return is_volume(plain_type(grid.type)); });
        if (volumes && !options_.voxels) return read_vdb_volumes(path_, options_);
        for (const VdbGridEntry& grid : *listed)
            if (Result<void> usable = check(grid.name, grid.type); !usable) return usable.error();
        openvdb::initialize();
        // OpenVDB does not ask whether it has been given what it reads; the stream tells.
        std::ifstream file(path_, std::ios::binary);
        file.exceptions(std::ios::failbit | std::ios::badbit);
        const openvdb::GridPtrVecPtr grids = openvdb::io::Stream(file, false).getGrids();
        for (const openvdb::GridBase::Ptr& grid : *grids) {
            if (Result<void> usable = check(grid->getName(), grid->type()); !usable) return usable.error();
            if (Result<void> added = add(grid); !added) return added.error();
        }
        if (scene_.objects.empty()) return cannot_read(path_, "none of its grids has an active voxel");
        return std::move(scene_);
    }

  private:
    Error refused(const std::string& name, const std::string& why) const {
        return cannot_read(path_, fmt::format("its grid '{}' {}", name, why));
    }
    Error refused(const openvdb::GridBase& grid, const std::string& why) const { return refused(grid.getName(), why); }

    static std::string plain_type(std::string type) {
        constexpr std::string_view half = "_HalfFloat";  // stored so, read as floats
        if (type.ends_with(half)) type.resize(type.size() - half.size());
        return type;
    }
    static bool is_scalar(const std::string& type) {
        return type == openvdb::FloatGrid::gridType() || type == openvdb::DoubleGrid::gridType();
    }
    static bool is_volume(const std::string& type) {
        return is_scalar(type) || type == openvdb::Vec3SGrid::gridType() || type == openvdb::Vec3DGrid::gridType();
    }

    Result<void> check(const std::string& name, const std::string& stored) const {
        const std::string type = plain_type(stored);
        const bool is_float = is_scalar(type);
        const bool is_whole = type == openvdb::BoolGrid::gridType() || type == openvdb::MaskGrid::gridType() ||
                              type == openvdb::Int32Grid::gridType() || type == openvdb::Int64Grid::gridType();
        if (type.find("ptdata") != type.npos) return refused(name, "holds points, which are not read");
        if (!is_whole && !is_float)
            return refused(name,
                           fmt::format("is of type {}; grids of integers, bits or floats can be read as voxels", type));
        return {};
    }

    Result<void> add(const openvdb::GridBase::Ptr& grid) {
        if (!grid->transform().isLinear()) return refused(*grid, "has a transform that is not affine");
        const CoordBBox active = grid->evalActiveVoxelBoundingBox();
        if (active.empty()) return {};
        Coord origin = active.min();
        const auto extent = active.extents().asVec3d();
        ivec3 size(0);
        if (const auto written = grid->getMetadata<openvdb::Vec3IMetadata>(size_key)) {
            const openvdb::Vec3i v = written->value();
            const CoordBBox said(Coord(0), Coord(v[0] - 1, v[1] - 1, v[2] - 1));
            if (said.empty() || !said.isInside(active))
                return refused(*grid, fmt::format("has a bad \"{}\"", size_key));
            origin = Coord(0);
            size = {v[0], v[1], v[2]};
        } else {
            for (int i = 0; i < 3; ++i) size[i] = int(std::min(extent[i], 2.0e9));
        }
        Result<VoxelTreePointer> tree = Error{""};
        if (grid->isType<openvdb::BoolGrid>()) tree = read<openvdb::BoolGrid>(*grid, origin, size);
        else if (grid->isType<openvdb::MaskGrid>()) tree = read<openvdb::MaskGrid>(*grid, origin, size);
        else if (grid->isType<openvdb::Int32Grid>()) tree = read<openvdb::Int32Grid>(*grid, origin, size);
        else if (grid->isType<openvdb::Int64Grid>()) tree = read<openvdb::Int64Grid>(*grid, origin, size);
        else if (grid->isType<openvdb::FloatGrid>()) tree = read<openvdb::FloatGrid>(*grid, origin, size);
        else tree = read<openvdb::DoubleGrid>(*grid, origin, size);
        if (!tree) return refused(*grid, "cannot become voxels: " + tree.error().message);

        Object object;
        object.name = grid->getName();
        const openvdb::Vec3d corner = origin.asVec3d() - 0.5, at = grid->indexToWorld(corner);
        for (int axis = 0; axis < 3; ++axis) {
            openvdb::Vec3d step = corner;
            step[axis] += 1;
            const openvdb::Vec3d column = grid->indexToWorld(step) - at;
            object.transform[axis] = vec3(column[0], column[1], column[2]);
        }
        object.transform[3] = vec3(at[0], at[1], at[2]);
        if (const auto fault = transform_fault(object.transform)) return refused(*grid, *fault);
        if (Result<void> colored = add_materials(*grid, **tree, object); !colored) return colored.error();
        object.geometry = int(scene_.geometries.size());
        scene_.geometries.push_back({object.name, VoxelGeometry{*tree}});
        scene_.objects.push_back(std::move(object));
        return {};
    }

    template <class GridType>
    static Result<VoxelTreePointer> read(const openvdb::GridBase& grid, Coord origin, ivec3 size) {
        return tree_of(static_cast<const GridType&>(grid), origin, size);
    }

    Result<void> add_materials(const openvdb::GridBase& grid, const VoxelTree& tree, Object& object) {
        Scene brought;
        if (const auto text = grid.getMetadata<openvdb::StringMetadata>(materials_key)) {
            const auto nothing = [](const std::filesystem::path&, const auto&...) {
                return Error{"materials of voxels name no files"};
            };
            Result<Scene> read =
                read_scene_json(text->value(), path_.string() + "#" + materials_key, {nothing, nothing});
            if (!read) return read.error();
            if (read->materials.size() < tree.palette_maximum() && read->materials.size() != 1)
                return refused(grid, fmt::format("has {} materials for palette indices up to {}",
                                                 read->materials.size(), tree.palette_maximum()));
            brought.materials = std::move(read->materials);
            brought.media = std::move(read->media);
            if (std::any_of(brought.media.begin(), brought.media.end(), [](const Medium& m) { return m.grid >= 0; }))
                return refused(grid, "has materials that name a grid");
        } else {
            brought.materials = plain_materials(tree.palette_maximum());
        }
        const auto first = int(scene_.materials.size()), first_medium = int(scene_.media.size());
        for (Material& m : brought.materials)
            if (m.values.interior != kernels::NONE) m.values.interior += std::uint32_t(first_medium);
        object.materials.resize(std::min<std::size_t>(brought.materials.size(), tree.palette_maximum()));
        std::iota(object.materials.begin(), object.materials.end(), first);
        std::move(brought.materials.begin(), brought.materials.end(), std::back_inserter(scene_.materials));
        std::move(brought.media.begin(), brought.media.end(), std::back_inserter(scene_.media));
        return {};
    }

    const std::filesystem::path& path_;
    const LoadOptions& options_;
    Scene scene_;
};

}  // namespace

Result<Scene> load_vdb(const std::filesystem::path& path, const LoadOptions& options) {
    try {
        return Reader(path, options).read();
    } catch (const std::bad_alloc&) {
        return cannot_read(path, "it holds more than fits into memory, or is damaged");
    } catch (const std::ios_base::failure&) {
        return cannot_read(path, "it is cut off, or damaged");
    } catch (const std::exception& e) { return cannot_read(path, e.what()); }
}

namespace {

// The object's materials as a scene file, in the order of its slots.
Result<std::string> materials_text(const Scene& scene, const Object& object) {
    Scene part;
    part.media = scene.media;
    for (const int m : object.materials) {
        if (m < 0) return Error{"some of its voxels have no surface; .vdb holds such as have one"};
        const Material& material = scene.materials[std::size_t(m)];
        const kernels::Material& v = material.values;
        for (const std::uint32_t texture : {v.color_texture, v.roughness_texture, v.metallic_texture,
                                            v.emission_texture, v.normal_texture, v.opacity_texture})
            if (texture != kernels::NONE) return Error{"its material '" + material.name + "' has textures"};
        part.materials.push_back(material);
    }
    const bool holds_media = std::any_of(part.materials.begin(), part.materials.end(),
                                         [](const Material& m) { return m.values.interior != kernels::NONE; });
    if (!holds_media) part.media.clear();
    for (const Medium& medium : part.media)
        if (medium.grid >= 0) return Error{"its materials hold a volume"};
    return write_scene_json(part);
}

openvdb::Int32Grid::Ptr grid_of(const VoxelTree& tree, const mat4x3& placed) {
    auto grid = openvdb::Int32Grid::create(0);
    auto accessor = grid->getAccessor();
    // A leaf takes 2 KB, and most of a terrain's are of one index throughout: these become tiles again and again.
    constexpr std::int64_t cells_between_prunings = std::int64_t(1) << 24;
    std::int64_t cells = 0;
    const auto prune = [&] {
        accessor.clear();
        openvdb::tools::prune(grid->tree());
        cells = 0;
    };
    tree.for_each_cube([&](ivec3 lower, int edge, std::uint16_t palette) {
        const Coord first(lower.x, lower.y, lower.z);
        if (edge >= 8) {
            grid->sparseFill(CoordBBox(first, first.offsetBy(edge - 1)), palette, true);
            return;
        }
        cells += std::int64_t(edge) * edge * edge;
        if (cells > cells_between_prunings) prune();
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y)
                for (int x = 0; x < edge; ++x) accessor.setValueOn(first.offsetBy(x, y, z), palette);
    });
    prune();
    openvdb::math::Mat4d m = openvdb::math::Mat4d::identity();  // of row vectors
    const glm::dmat4x3 placement(placed);
    const glm::dvec3 centre = placement * glm::dvec4(0.5, 0.5, 0.5, 1);
    for (int row = 0; row < 3; ++row)
        for (int k = 0; k < 3; ++k) m[row][k] = placement[row][k];
    for (int k = 0; k < 3; ++k) m[3][k] = centre[k];
    grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
    const ivec3 size = tree.size();
    grid->insertMeta(size_key, openvdb::Vec3IMetadata(openvdb::Vec3i(size.x, size.y, size.z)));
    return grid;
}

}  // namespace

Result<Notes> save_vdb(const Scene& scene, const std::filesystem::path& path) {
    const auto cannot_write = [&](const std::string& why) {
        return Error{fmt::format("cannot write '{}': {}", path.string(), why)};
    };
    if (scene.objects.empty()) return cannot_write("the scene is empty");
    openvdb::initialize();
    openvdb::GridPtrVec grids;
    for (const Object& object : scene.objects) {
        const auto* voxels = std::get_if<VoxelGeometry>(&scene.geometries[std::size_t(object.geometry)].data);
        if (!voxels) return cannot_write(fmt::format("object '{}' is not made of voxels", object.name));
        const Result<std::string> materials = materials_text(scene, object);
        if (!materials) return cannot_write(fmt::format("object '{}': {}", object.name, materials.error().message));
        const auto grid = grid_of(*voxels->tree, object.transform);
        grid->setName(object.name);
        if (!object.materials.empty()) grid->insertMeta(materials_key, openvdb::StringMetadata(*materials));
        grids.push_back(grid);
    }
    const Result<void> written = write_file_atomically(path, [&](const std::filesystem::path& fresh) -> Result<void> {
        try {
            openvdb::io::File file(fresh.string());
            file.write(grids);
            file.close();
        } catch (const std::exception& e) { return cannot_write(e.what()); }
        return {};
    });
    if (!written) return written.error();
    LeftOut left_out;
    left_out.add_light_and_cameras(scene);
    return left_out.notes();
}

}  // namespace spinel
