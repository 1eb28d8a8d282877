#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <numeric>

#include "geometry/mesh/mesh_builder.h"
#include "geometry/sdf/sdf_builder.h"
#include "geometry/voxels/field_voxels.h"
#include "geometry/voxels/voxelise.h"
#include "image/palette.h"
#include "kernels/sdf.h"
#include "scene/convert.h"
#include "scene/host_texture.h"
#include "scene/material_registry.h"
#include "scene/validate.h"

#include "kernels/materials.h"

namespace spinel {
namespace {

using glm::dmat4x3;
using glm::dvec2;
using glm::dvec3;
using kernels::NONE;

dvec3 transformed(const mat4x3& m, dvec3 p) { return dmat4x3(m) * glm::dvec4(p, 1); }

mat4x3 inverse(const mat4x3& m) { return mat4x3(glm::mat4(glm::inverse(glm::dmat4(glm::mat4(m))))); }

struct Bounds {
    dvec3 lower = dvec3(std::numeric_limits<double>::infinity()), upper = -lower;
    void add(dvec3 p) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    void add_box(const mat4x3& m, dvec3 low, dvec3 high) {
        for (int i = 0; i < 8; ++i)
            add(transformed(m, {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z}));
    }
};

bool has_color_texture(const Material& m) { return m.values.color_texture != NONE; }

// The material that a cell shows, in one plain colour.
kernels::Material without_textures(kernels::Material m) {
    if (m.emission_texture != NONE) m.emission = vec3(0);
    for (const auto member : material_texture_members) m.*member = NONE;
    return m;
}

constexpr std::uint32_t no_color = 0xffffffff;

// A touched cell: the look is a row of `Looks`, the colour its own.
struct ColoredCell {
    ivec3 cell;
    std::uint32_t look;
    std::uint32_t color;  // 8-bit sRGB, or no_color
};

// Materials without their textures; of colored ones, every cell brings its colour.
struct Looks {
    struct Look {
        std::string name;
        kernels::Material material;
        bool colored;
    };
    std::vector<Look> rows;

    std::uint32_t add(const Material& material, bool colored) {
        kernels::Material plain = without_textures(material.values);
        if (colored) plain.color = vec3(1);
        for (std::size_t i = 0; i < rows.size(); ++i)
            if (rows[i].colored == colored && same_material(rows[i].material, plain)) return std::uint32_t(i);
        rows.push_back({material.name, plain, colored});
        return std::uint32_t(rows.size() - 1);
    }
};

// The point of the triangle that is nearest to p, as weights of its corners (Ericson, "Real-Time Collision Detection",
// 5.1.5).
dvec3 nearest_weights(dvec3 p, dvec3 a, dvec3 b, dvec3 c) {
    const dvec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap), d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp),
                 d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
    if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
    if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {0, 1 - w, w};
    }
    const double sum = va + vb + vc;
    return {va / sum, vb / sum, vc / sum};
}

class Voxeliser {
  public:
    Voxeliser(const Scene& scene, const VoxeliseOptions& options) : scene_(scene), options_(options) {}

    Result<Scene> run() {
        if (options_.max_colors < 1 || options_.max_colors > 65535)
            return Error{fmt::format("a palette of {} colours; allowed: 1 … 65535", options_.max_colors)};
        if (!(options_.threshold > 0)) return Error{"the threshold of volumes must be above 0"};
        Bounds bounds;
        std::size_t left_out = 0;
        for (const Object& object : scene_.objects) {
            left_out += is_plane(object);
            if (is_plane(object)) continue;
            if (Result<void> measured = measure(object, bounds); !measured) return measured.error();
        }
        if (left_out == scene_.objects.size()) return Error{"there is nothing bounded to voxelise"};
        if (left_out > 0) notes_.push_back(fmt::format("infinite planes left out: {}", left_out));
        const Result<VoxelFrame> frame = fit_voxel_frame(bounds.lower, bounds.upper, options_.resolution);
        if (!frame) return frame.error();
        frame_ = *frame;
        for (const Object& object : scene_.objects) {
            if (is_plane(object)) continue;
            if (Result<void> added = add(object); !added) return added.error();
        }
        if (Result<void> made = make_palette(); !made) return made.error();
        return finish();
    }

  private:
    // What one object fills. Cells of meshes come first as looks, and as a tree once there is a palette.
    struct Layer {
        std::vector<ColoredCell> cells;
        std::shared_ptr<const MeshInside> inside;
        std::uint32_t inner_look = 0;
        std::function<VoxelFunction(const std::vector<std::uint16_t>&)> field;  // of the palette index of each look
        VoxelFunction function;
    };

    Error refused(const Object& object, const std::string& why) const {
        return Error{fmt::format("object '{}': {}", object.name, why)};
    }
    const Geometry& geometry_of(const Object& object) const { return scene_.geometries[std::size_t(object.geometry)]; }

    bool is_plane(const Object& object) const {
        return std::holds_alternative<PlaneGeometry>(geometry_of(object).data);
    }

    // −1: none.
    int material_of(const Object& object, std::size_t slot) const {
        if (object.materials.empty()) return -1;
        return object.materials.size() == 1 ? object.materials[0] : object.materials[slot];
    }

    std::uint32_t look_of(const Object& object, std::size_t slot) {
        const int material = material_of(object, slot);
        if (material >= 0) return looks_.add(scene_.materials[std::size_t(material)], false);
        // What has no surface is matter of a medium's colour, or grey.
        Material matter{object.name, default_material(kernels::MATERIAL_DIFFUSE)};
        if (object.interior >= 0) {
            const Medium& medium = scene_.media[std::size_t(object.interior)];
            const vec3 extinction = medium.scattering + medium.absorption;
            for (int i = 0; i < 3; ++i)
                matter.values.color[i] = extinction[i] > 0 ? medium.scattering[i] / extinction[i] : 1.0f;
        }
        return looks_.add(matter, false);
    }

    // Spheres and boxes as expressions, rectangles as triangles.
    static std::optional<SdfGeometry> as_sdf(const Geometry& geometry) {
        if (const auto* sdf = std::get_if<SdfGeometry>(&geometry.data)) return *sdf;
        if (const auto* sphere = std::get_if<SphereGeometry>(&geometry.data))
            return SdfGeometry{SdfNode{"sphere", {sphere->radius}, {}}, {}};
        if (const auto* box = std::get_if<BoxGeometry>(&geometry.data))
            return SdfGeometry{SdfNode{"box", {box->size.x, box->size.y, box->size.z}, {}}, {}};
        return std::nullopt;
    }
    static std::optional<MeshGeometry> as_mesh(const Geometry& geometry) {
        if (const auto* mesh = std::get_if<MeshGeometry>(&geometry.data)) return *mesh;
        if (const auto* rectangle = std::get_if<RectangleGeometry>(&geometry.data)) {
            const vec2 h = 0.5f * rectangle->size;
            MeshGeometry mesh;
            mesh.positions = {{-h.x, 0, h.y}, {h.x, 0, h.y}, {h.x, 0, -h.y}, {-h.x, 0, -h.y}};
            mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
            mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
            return mesh;
        }
        return std::nullopt;
    }

    Result<void> measure(const Object& object, Bounds& bounds) const {
        const Geometry& geometry = geometry_of(object);
        const mat4x3& m = object.transform;
        if (const auto mesh = as_mesh(geometry)) {
            if (Result<void> valid = validate_mesh(*mesh); !valid) return refused(object, valid.error().message);
            for (const uvec3& t : mesh->triangles)
                for (int i = 0; i < 3; ++i) bounds.add(transformed(m, mesh->positions[t[i]]));
            return {};
        }
        if (const auto sdf = as_sdf(geometry)) {
            const Result<SdfData> data = build_sdf(*sdf);
            if (!data) return refused(object, data.error().message);
            bounds.add_box(m, data->sdf.lower, data->sdf.upper);
            return {};
        }
        if (const auto* volume = std::get_if<VolumeGeometry>(&geometry.data)) {
            const Grid& grid = scene_.grids[std::size_t(volume->grid)];
            const glm::mat4 to_world = glm::mat4(m) * glm::mat4(grid.index_to_local);
            bounds.add_box(mat4x3(to_world), dvec3(0), dvec3(grid.samples->size()));
            return {};
        }
        if (const auto* voxels = std::get_if<SdfVoxelGeometry>(&geometry.data)) {
            const Result<SdfData> data = build_sdf(voxels->sdf);
            if (!data) return refused(object, data.error().message);
            bounds.add_box(m, dvec3(data->sdf.lower) - double(voxels->cell),
                           dvec3(data->sdf.upper) + double(voxels->cell));
            return {};
        }
        bounds.add_box(m, dvec3(0), dvec3(std::get<VoxelGeometry>(geometry.data).tree->size()));
        return {};
    }

    Result<void> add(const Object& object) {
        const Geometry& geometry = geometry_of(object);
        if (const auto mesh = as_mesh(geometry)) return add_mesh(object, *mesh);
        const mat4x3 to_object = inverse(object.transform);
        Layer layer;
        if (const auto sdf = as_sdf(geometry)) {
            Result<SdfData> built = build_sdf(*sdf);
            if (!built) return refused(object, built.error().message);
            const auto data = std::make_shared<const SdfData>(std::move(*built));
            layer.field = [this, data, to_object, look = look_of(object, 0)](const auto& palette) {
                VoxelFunction f = sdf_voxels(*data, frame_, to_object, palette[look]);
                return VoxelFunction{[data, at = f.palette](ivec3 cell) { return at(cell); }, f.box};
            };
        } else if (const auto* volume = std::get_if<VolumeGeometry>(&geometry.data)) {
            layer.field = [this, volume, to_object, look = look_of(object, 0)](const auto& palette) {
                const Grid& grid = scene_.grids[std::size_t(volume->grid)];
                if (!volume->surface) return volume_voxels(grid, frame_, to_object, options_.threshold, palette[look]);
                return solid_voxels(grid, frame_, to_object, volume->level, volume->solid_above, palette[look]);
            };
        } else if (const auto* procedural = std::get_if<SdfVoxelGeometry>(&geometry.data)) {
            if (Result<void> added = add_sdf_voxels(object, *procedural, layer); !added) return added;
        } else {
            const VoxelTreePointer tree = std::get<VoxelGeometry>(geometry.data).tree;
            std::vector<std::uint32_t> looks;
            for (std::size_t slot = 0; slot < tree->palette_maximum(); ++slot) looks.push_back(look_of(object, slot));
            layer.field = [this, tree, to_object, looks](const auto& palette) {
                return VoxelFunction{[=, this](ivec3 cell) {
                                         const dvec3 p = glm::floor(transformed(to_object, frame_.centre(cell)));
                                         const std::uint16_t there = tree->at(ivec3(p));
                                         return there == 0 ? there : palette[looks[there - 1u]];
                                     },
                                     {}};
            };
        }
        layers_.push_back(std::move(layer));
        return {};
    }

    // What cell of the geometry a centre lies in, and whether that is solid.
    Result<void> add_sdf_voxels(const Object& object, const SdfVoxelGeometry& voxels, Layer& layer) {
        Result<SdfData> built = build_sdf(voxels.sdf);
        if (!built) return refused(object, built.error().message);
        const auto data = std::make_shared<const SdfData>(std::move(*built));
        std::vector<std::uint32_t> looks;
        for (std::size_t slot = 0; slot <= voxels.strata.size(); ++slot) looks.push_back(look_of(object, slot));
        layer.field = [this, data, &voxels, looks, to_object = inverse(object.transform)](const auto& palette) {
            kernels::SceneView view = {};
            view.sdf_ops.at = data->ops.data();
            view.sdfs.at = &data->sdf;
            const auto at = [=, this, &voxels](ivec3 cell) -> std::uint16_t {
                const double edge = double(voxels.cell);
                const vec3 p((glm::floor(transformed(to_object, frame_.centre(cell)) / edge) + 0.5) * edge);
                if (glm::any(glm::lessThan(p, data->sdf.lower)) || glm::any(glm::greaterThan(p, data->sdf.upper)) ||
                    kernels::sdf_distance(view, 0, p) > 0)
                    return 0;
                const auto stratum = std::upper_bound(voxels.strata.begin(), voxels.strata.end(), p.y);
                return palette[looks[std::size_t(stratum - voxels.strata.begin())]];
            };
            return VoxelFunction{at, {}};
        };
        return {};
    }

    Result<void> add_mesh(const Object& object, const MeshGeometry& mesh) {
        if (options_.solid && options_.resolution > MeshInside::max_edge)
            return Error{fmt::format("solid voxels of meshes: at most {} along an edge", MeshInside::max_edge)};
        std::vector<dvec3> positions;
        positions.reserve(mesh.positions.size());
        for (const vec3& p : mesh.positions)
            positions.push_back(frame_.to_cells(transformed(object.transform, dvec3(p))));

        struct Slot {
            int material = -1;
            std::uint32_t look = 0;
            bool colored = false;
            const HostTexture* color = nullptr;
            const HostTexture* opacity = nullptr;
        };
        std::uint32_t slot_count = 1;
        for (const std::uint32_t slot : mesh.slots) slot_count = std::max(slot_count, slot + 1);
        std::vector<Slot> slots(slot_count);
        for (std::size_t i = 0; i < slots.size(); ++i) {
            slots[i].material = material_of(object, i);
            if (slots[i].material < 0) continue;
            const Material& material = scene_.materials[std::size_t(slots[i].material)];
            slots[i].colored = has_color_texture(material) || !mesh.colors.empty();
            slots[i].look = looks_.add(material, slots[i].colored);
            slots[i].color = texture(material.values.color_texture);
            slots[i].opacity = texture(material.values.opacity_texture);
        }

        // What a triangle shows where it is nearest to a cell's centre; alpha as well.
        const auto sample_at = [&](const Slot& slot, const uvec3& t, ivec3 cell) {
            const kernels::Material& m = scene_.materials[std::size_t(slot.material)].values;
            const dvec3 a = positions[t.x], b = positions[t.y], c = positions[t.z];
            const vec3 w(nearest_weights(dvec3(cell) + 0.5, a, b, c));
            vec4 value(m.color, 1);
            if (!mesh.colors.empty())
                value *= vec4(vec3(mesh.colors[t.x] * w.x + mesh.colors[t.y] * w.y + mesh.colors[t.z] * w.z), 1);
            const auto texel = [&](const HostTexture& texture) {
                const bool second = texture.uv_set() == 1 && !mesh.second_uvs.empty();
                const std::vector<vec2>& uvs = second ? mesh.second_uvs : mesh.uvs;
                if (uvs.empty()) return texture.at(vec2(0), 0);
                const vec2 ua = uvs[t.x], ub = uvs[t.y], uc = uvs[t.z];
                const double area = glm::length(glm::cross(b - a, c - a));  // in faces of cells, twice
                const vec2 d1 = ub - ua, d2 = uc - ua;
                const double uv_area = std::abs(double(d1.x) * d2.y - double(d1.y) * d2.x);
                const float footprint = area > 0 ? float(std::sqrt(uv_area / area)) : 0;
                return texture.at(ua * w.x + ub * w.y + uc * w.z, footprint);
            };
            if (slot.color) value *= vec4(vec3(texel(*slot.color)), 1);
            if (slot.opacity) value.w = texel(*slot.opacity).w;
            return value;
        };

        Layer layer;
        std::vector<std::vector<ColoredCell>> found(voxel_slab_count(frame_.size));
        visit_surface_cells(
            frame_.size, positions, mesh.triangles,
            [&](std::size_t slab, ivec3 cell, std::span<const std::uint32_t> triangles) {
                const auto slot_of = [&](std::uint32_t t) -> const Slot& {
                    return slots[mesh.slots.empty() ? 0 : mesh.slots[t]];
                };
                // The last triangle that is to be seen decides on the look; all of that look share in the colour.
                const Slot* shown = nullptr;
                vec3 sum(0);
                float count = 0;
                for (auto t = triangles.rbegin(); t != triangles.rend(); ++t) {
                    const Slot& slot = slot_of(*t);
                    if (slot.material < 0 || (shown && slot.look != shown->look)) continue;
                    if (!slot.colored && !slot.opacity) {
                        shown = &slot;
                        break;
                    }
                    const vec4 value = sample_at(slot, mesh.triangles[*t], cell);
                    if (value.w < 0.5f) continue;
                    shown = &slot;
                    sum += vec3(value);
                    count += 1;
                }
                if (shown) found[slab].push_back({cell, shown->look, shown->colored ? srgb8(sum / count) : no_color});
            });
        for (std::vector<ColoredCell>& part : found) {
            layer.cells.insert(layer.cells.end(), part.begin(), part.end());
            part = {};
        }
        if (options_.solid) {
            layer.inside = std::make_shared<MeshInside>(frame_.size, positions, mesh.triangles);
            layer.inner_look = inner_look(object, slots[0].material, layer.cells);
        }
        layers_.push_back(std::move(layer));
        return {};
    }

    // The inside in one entry: the first slot's material, in the mean of the colours where that is coloured.
    std::uint32_t inner_look(const Object& object, int material, const std::vector<ColoredCell>& cells) {
        vec3 sum(0);
        float count = 0;
        for (const ColoredCell& c : cells) {
            if (c.color == no_color) continue;
            sum += oklab_of_linear(linear_of_srgb8(c.color));
            count += 1;
        }
        if (count == 0 || material < 0) return look_of(object, 0);
        Material mean = scene_.materials[std::size_t(material)];
        mean.values = without_textures(mean.values);
        mean.values.color = linear_of_srgb8(srgb8(linear_of_oklab(sum / count)));
        return looks_.add(mean, false);
    }

    const HostTexture* texture(std::uint32_t index) {
        if (index == NONE) return nullptr;
        auto& made = textures_[index];
        if (!made) made = std::make_unique<HostTexture>(scene_.textures[index]);
        return made.get();
    }

    // Plain looks get an entry each; coloured ones share what is left, by their numbers of cells.
    Result<void> make_palette() {
        std::vector<std::vector<std::uint32_t>> colors(looks_.rows.size());
        std::vector<bool> used(looks_.rows.size(), false);
        double total = 0;
        for (const Layer& layer : layers_)
            for (const ColoredCell& c : layer.cells)
                if (c.color != no_color) colors[c.look].push_back(c.color), total += 1;
        std::size_t plain = 0, colored = 0;
        for (std::size_t i = 0; i < looks_.rows.size(); ++i) {
            plain += !looks_.rows[i].colored;
            colored += !colors[i].empty();
        }
        if (plain + colored > std::size_t(options_.max_colors))
            return Error{fmt::format("{} materials do not fit a palette of {}", plain + colored, options_.max_colors)};
        const double spare = double(options_.max_colors) - double(plain + colored);
        palette_of_look_.assign(looks_.rows.size(), 0);
        std::vector<std::vector<std::uint16_t>> index(looks_.rows.size());
        for (std::size_t i = 0; i < looks_.rows.size(); ++i) {
            const Looks::Look& look = looks_.rows[i];
            palette_of_look_[i] = std::uint16_t(palette_.size() + 1);
            if (!look.colored) {
                palette_.push_back({look.name, look.material});
                continue;
            }
            if (colors[i].empty()) continue;
            const int share = 1 + int(spare * double(colors[i].size()) / total);
            ColorPalette chosen = quantise_colors(colors[i], share);
            for (const std::uint32_t color : chosen.colors) {
                palette_.push_back({fmt::format("{} {:06x}", look.name, color), look.material});
                palette_.back().values.color = linear_of_srgb8(color);
            }
            index[i] = std::move(chosen.index);
            colors[i] = {};
        }
        std::vector<std::size_t> next(looks_.rows.size(), 0);
        for (Layer& layer : layers_) {
            if (layer.field) {
                layer.function = layer.field(palette_of_look_);
                continue;
            }
            std::vector<VoxelPoint> points;
            points.reserve(layer.cells.size());
            for (const ColoredCell& c : layer.cells) {
                std::uint16_t p = palette_of_look_[c.look];
                if (c.color != no_color) p = std::uint16_t(p + index[c.look][next[c.look]++]);
                points.push_back({c.cell, p});
            }
            layer.cells = {};
            Result<VoxelTreePointer> shell = build_voxel_tree(frame_.size, std::move(points));
            if (!shell) return shell.error();
            layer.function = filled(*shell, layer.inside, palette_of_look_[layer.inner_look]);
        }
        return {};
    }

    // The shell, and behind it what it encloses.
    static VoxelFunction filled(const VoxelTreePointer& shell, const std::shared_ptr<const MeshInside>& inside,
                                std::uint16_t fill) {
        const auto at = [=](ivec3 cell) {
            const std::uint16_t p = shell->at(cell);
            return p != 0 || !inside || !inside->at(cell) ? p : fill;
        };
        const auto box = [=](ivec3 lower, ivec3 upper) -> std::optional<std::uint16_t> {
            const ivec3 extent = upper - lower;
            int edge = 1;  // cubes that the set's end cuts are asked for as if they were smaller
            while (edge < std::max({extent.x, extent.y, extent.z})) edge *= 4;
            const std::optional<std::uint16_t> p = shell->cube(lower, edge);
            if (!p || *p != 0 || !inside) return p;
            const std::optional<bool> in = inside->box(lower, upper);
            if (!in) return std::nullopt;
            return *in ? fill : std::uint16_t(0);
        };
        return {at, box};
    }

    Result<Scene> finish() {
        VoxelFunction all;
        all.palette = [this](ivec3 cell) {
            for (auto layer = layers_.rbegin(); layer != layers_.rend(); ++layer)
                if (const std::uint16_t p = layer->function.palette(cell)) return p;
            return std::uint16_t(0);
        };
        all.box = [this](ivec3 lower, ivec3 upper) -> std::optional<std::uint16_t> {
            for (auto layer = layers_.rbegin(); layer != layers_.rend(); ++layer) {
                const auto p = layer->function.box ? layer->function.box(lower, upper) : std::nullopt;
                if (!p || *p != 0) return p;
            }
            return std::uint16_t(0);
        };
        Result<VoxelTreePointer> tree = build_voxel_tree(frame_.size, all);
        if (!tree) return tree.error();
        if ((*tree)->voxel_count() == 0) return Error{"not a single voxel is solid"};
        Scene out;
        out.notes = std::move(notes_);
        out.materials = std::move(palette_);
        const bool holds_media = std::any_of(out.materials.begin(), out.materials.end(),
                                             [](const Material& m) { return m.values.interior != NONE; });
        if (holds_media) {
            out.media = scene_.media;
            out.grids = scene_.grids;
        }
        out.geometries.push_back({"voxels", VoxelGeometry{*tree}});
        Object object;
        object.name = "voxels";
        object.geometry = 0;
        object.transform = frame_.transform();
        object.materials.resize((*tree)->palette_maximum());
        std::iota(object.materials.begin(), object.materials.end(), 0);
        out.objects.push_back(std::move(object));
        return out;
    }

    const Scene& scene_;
    const VoxeliseOptions& options_;
    VoxelFrame frame_;
    Looks looks_;
    std::map<std::uint32_t, std::unique_ptr<HostTexture>> textures_;
    std::vector<Layer> layers_;
    std::vector<std::string> notes_;
    std::vector<std::uint16_t> palette_of_look_;  // the first, of coloured ones
    std::vector<Material> palette_;
};

}  // namespace

Result<Scene> voxelise_scene(const Scene& scene, const VoxeliseOptions& options) {
    return Voxeliser(scene, options).run();
}

}  // namespace spinel
