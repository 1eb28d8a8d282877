#include "scene/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/mesh/mesh_builder.h"
#include "geometry/voxels/voxel_builder.h"
#include "image/pixels.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"
#include "scene/scene_fields.h"

namespace spinel {
namespace {

using Fault = std::optional<std::string>;

bool finite(float x) { return std::isfinite(x); }
bool finite(const vec2& v) { return finite(v.x) && finite(v.y); }
bool finite(const vec3& v) { return finite(v.x) && finite(v.y) && finite(v.z); }
bool finite(const vec4& v) { return finite(vec3(v)) && finite(v.w); }
bool finite(const mat4x3& m) { return finite(m[0]) && finite(m[1]) && finite(m[2]) && finite(m[3]); }
// Comparisons are written so that NaN fails them.
bool at_least_zero(float x) { return std::isfinite(x) && x >= 0; }
bool at_least_zero(const vec3& v) { return finite(v) && v.x >= 0 && v.y >= 0 && v.z >= 0; }
bool above_zero(float x) { return finite(x) && x > 0; }

template <class Vector>
bool all_finite(const std::vector<Vector>& values) {
    return std::all_of(values.begin(), values.end(), [](const Vector& v) { return finite(v); });
}

Fault pixels_fault(const std::shared_ptr<const PixelBuffer>& pixels) {
    if (!pixels) return "has no pixels";
    if (pixels->width <= 0 || pixels->height <= 0 || pixels->channels < 1 || pixels->channels > 4)
        return "has a picture of zero size or not of 1 to 4 channels";
    const std::size_t count = std::visit([](const auto& values) { return values.size(); }, pixels->data);
    if (count != pixels->value_count()) return "has a picture whose number of values does not match its size";
    return {};
}

Fault mesh_fault(const MeshGeometry& mesh) {
    const std::size_t vertex_count = mesh.positions.size();
    if (mesh.triangles.empty()) return "has no triangles";
    if (!all_finite(mesh.positions)) return "has a vertex that is not finite";
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (int corner = 0; corner < 3; ++corner)
            if (mesh.triangles[i][corner] >= vertex_count)
                return "has a triangle (" + std::to_string(i) + ") with vertex " +
                       std::to_string(mesh.triangles[i][corner]) + ", but there are " + std::to_string(vertex_count) +
                       " vertices";
    const auto miscounted = [&](const char* name, std::size_t count, std::size_t wanted) -> Fault {
        if (count == 0 || count == wanted) return {};
        return "has " + std::to_string(count) + " " + name + "; there must be none or " + std::to_string(wanted);
    };
    if (auto f = miscounted("normals", mesh.normals.size(), vertex_count)) return f;
    if (auto f = miscounted("uvs", mesh.uvs.size(), vertex_count)) return f;
    if (auto f = miscounted("second_uvs", mesh.second_uvs.size(), vertex_count)) return f;
    if (auto f = miscounted("tangents", mesh.tangents.size(), vertex_count)) return f;
    if (auto f = miscounted("colors", mesh.colors.size(), vertex_count)) return f;
    if (auto f = miscounted("slots", mesh.slots.size(), mesh.triangles.size())) return f;
    if (!all_finite(mesh.normals) || !all_finite(mesh.uvs) || !all_finite(mesh.second_uvs) ||
        !all_finite(mesh.tangents) || !all_finite(mesh.colors))
        return "has a normal, uv, tangent or colour that is not finite";
    return {};
}

Fault outlines_fault(const VoxelOutlines& outlines) {
    if (!(outlines.width > 0 && outlines.width < 1)) return "has outlines whose width is not between 0 and 1 cell";
    if (!(outlines.strength >= 0 && outlines.strength <= 1) || !at_least_zero(outlines.color))
        return "has outlines with a strength outside of 0 … 1 or a colour that is negative or not finite";
    return {};
}

Fault waves_fault(const VoxelWaves& waves) {
    if (waves.palette.empty()) return "has waves but names no palette index of water";
    for (const int palette : waves.palette)
        if (palette < 1 || palette > 65535) return "has waves on a palette index outside of 1 … 65535";
    if (!(waves.height > 0 && waves.height < 1)) return "has waves whose height is not between 0 and 1 cell";
    if (!(waves.length >= 0.1f && waves.length <= 1e6f) || waves.count < 1 || waves.count > 32)
        return "has waves with a length below 0.1 cells or a count outside of 1 … 32";
    if (!finite(waves.direction) || !finite(waves.spread) || !(std::abs(waves.time) <= 1e6f) ||
        !(waves.gravity >= 0 && waves.gravity <= 1e6f))
        return "has waves with a direction, spread, time or gravity out of range";
    return {};
}

Fault voxels_fault(const VoxelGeometry& voxels) {
    if (!voxels.tree) return "has no voxels";
    if (!at_least_zero(voxels.level_of_detail)) return "has a level of detail that is negative or not finite";
    for (const float radius : voxels.rounding)
        if (!(radius >= 0 && radius <= 0.5f)) return "has a rounding outside of 0 … 0.5 cells";
    if (voxels.outlines)
        if (auto f = outlines_fault(*voxels.outlines)) return f;
    if (voxels.waves) return waves_fault(*voxels.waves);
    return {};
}

Fault sdf_fault(const SdfGeometry& sdf) {
    if (sdf.root.op.empty()) return "has no expression";
    if (sdf.bounds) {
        const auto& [lower, upper] = *sdf.bounds;
        if (!finite(lower) || !finite(upper) || !(lower.x < upper.x && lower.y < upper.y && lower.z < upper.z))
            return "has bounds whose lower corner is not below the upper one";
    }
    return {};
}

Fault sdf_voxels_fault(const SdfVoxelGeometry& voxels) {
    if (auto f = sdf_fault(voxels.sdf)) return f;
    if (!above_zero(voxels.cell)) return "has a cell that is not above 0";
    for (std::size_t i = 0; i < voxels.strata.size(); ++i)
        if (!finite(voxels.strata[i]) || (i > 0 && !(voxels.strata[i] > voxels.strata[i - 1])))
            return "has strata that do not rise";
    if (voxels.strata.size() > 256) return "has more than 256 strata";
    if (voxels.outlines) return outlines_fault(*voxels.outlines);
    return {};
}

template <class... Functions>
struct overloaded : Functions... {
    using Functions::operator()...;
};
template <class... Functions>
overloaded(Functions...) -> overloaded<Functions...>;  // clang 16 does not deduce aggregates

// Of a material, by the sizes of what it refers to.
Fault material_fault(const kernels::Material& m, const Scene& scene) {
    if (!find_material_info(m.kind)) return "is of a kind that is not there";
    for (const auto member : material_texture_members)
        if (m.*member != kernels::NONE && m.*member >= scene.textures.size())
            return "refers to a texture that is not there";
    if (m.interior != kernels::NONE && m.interior >= scene.media.size()) return "refers to a medium that is not there";
    if (!at_least_zero(m.color) || !at_least_zero(m.absorption) || !at_least_zero(m.emission) ||
        !at_least_zero(m.eta) || !at_least_zero(m.k) || !at_least_zero(m.edge_color))
        return "has a colour, emission, absorption or complex index that is negative or not finite";
    if (!(m.roughness >= 0 && finite(m.roughness))) return "has a roughness that is negative or not finite";
    if (!(m.metallic >= 0 && m.metallic <= 1)) return "has metallic outside of 0 … 1";
    if (!(m.opacity >= 0 && m.opacity <= 1)) return "has opacity outside of 0 … 1";
    if (!above_zero(m.ior)) return "has an index of refraction that is not above 0";
    if (!(m.coat >= 0 && m.coat <= 1) || !(m.coat_roughness >= 0 && m.coat_roughness <= 1))
        return "has coat or coat_roughness outside of 0 … 1";
    if (!(m.transmission >= 0 && m.transmission <= 1)) return "has transmission outside of 0 … 1";
    if (!finite(m.normal_scale)) return "has a normal_scale that is not finite";
    return {};
}

// Whether a ray that meets the slot of an object always stops there.
bool is_opaque(const Scene& scene, int material) {
    if (material < 0) return false;
    const kernels::Material& m = scene.materials[std::size_t(material)].values;
    return m.kind != kernels::MATERIAL_DIELECTRIC && m.opacity >= 1 && m.opacity_texture == kernels::NONE;
}

// Shapes of voxels that a material does not allow, and textures that want faces where there are none.
Fault look_fault(const Object& object, const Scene& scene, std::uint32_t slots) {
    const Geometry& geometry = scene.geometries[std::size_t(object.geometry)];
    const auto* voxels = std::get_if<VoxelGeometry>(&geometry.data);
    const bool cubes = voxels || std::holds_alternative<SdfVoxelGeometry>(geometry.data) ||
                       std::holds_alternative<BoxGeometry>(geometry.data);
    for (std::uint32_t slot = 0; slot < slots; ++slot) {
        const int material = object.materials.size() == 1 ? object.materials[0] : object.materials[slot];
        const std::string called = material < 0 ? "nothing" : "\"" + scene.materials[std::size_t(material)].name + "\"";
        if (!cubes && material >= 0) {
            const kernels::Material& m = scene.materials[std::size_t(material)].values;
            for (const auto member : material_texture_members)
                if (m.*member != kernels::NONE && std::holds_alternative<FaceTexture>(scene.textures[m.*member].data))
                    return "is a " + std::string(kind_name(geometry)) + " of material " + called +
                           ", whose texture of type \"faces\" is for voxels and boxes only";
        }
        if (!voxels) continue;
        const std::string where = ", but its palette index " + std::to_string(slot + 1) + " is " + called;
        if (rounding_of(*voxels, slot + 1) > 0 && !is_opaque(scene, material))
            return "rounds the edges of voxels, which only what is opaque allows" + where;
        if (!voxels->waves) continue;
        for (const int palette : voxels->waves->palette) {
            if (palette != int(slot + 1)) continue;
            if (rounding_of(*voxels, slot + 1) > 0) return "has both rounding and waves" + where;
            if (material < 0 || scene.materials[std::size_t(material)].values.kind != kernels::MATERIAL_DIELECTRIC)
                return "has waves, which only a dielectric may have" + where;
        }
    }
    return {};
}

Fault object_fault(const Object& object, const Scene& scene, const std::vector<std::uint32_t>& slot_counts) {
    if (object.geometry < 0 || std::size_t(object.geometry) >= scene.geometries.size())
        return "refers to a geometry that is not there";
    for (const int material : object.materials)
        if (material < -1 || material >= int(scene.materials.size())) return "refers to a material that is not there";
    if (object.interior < -1 || object.interior >= int(scene.media.size()))
        return "refers to a medium that is not there";
    if (auto f = transform_fault(object.transform)) return f;

    const Geometry& geometry = scene.geometries[std::size_t(object.geometry)];
    const std::string kind(kind_name(geometry));
    const auto* volume = std::get_if<VolumeGeometry>(&geometry.data);
    if (volume && !volume->surface) {
        const bool vectors = volume->grid >= 0 && volume->grid < int(scene.grids.size()) &&
                             scene.grids[std::size_t(volume->grid)].samples->channels() > 1;
        if (object.interior < 0 && !vectors) return "is a volume without an interior medium";
        if (std::any_of(object.materials.begin(), object.materials.end(), [](int m) { return m >= 0; }))
            return "is a volume, which has no surface for a material";
        return {};
    }
    const bool closed = !std::holds_alternative<PlaneGeometry>(geometry.data) &&
                        !std::holds_alternative<RectangleGeometry>(geometry.data);
    if (object.interior >= 0 && !closed) return "is a " + kind + ", which has no inside for an interior medium";
    const std::uint32_t slots = slot_counts[std::size_t(object.geometry)];
    if (object.materials.empty()) return "has no material";
    if (object.materials.size() > 1 && object.materials.size() < slots)
        return "has " + std::to_string(object.materials.size()) + " materials, but its geometry uses " +
               std::to_string(slots) + " slots";
    return look_fault(object, scene, slots);
}

std::string called(const char* noun, const std::string& name, std::size_t index) {
    return noun + (name.empty() ? " " + std::to_string(index) : " \"" + name + "\"");
}

}  // namespace

std::string_view kind_name(const Geometry& geometry) { return geometry_family().records[geometry.data.index()].type; }

std::uint32_t slot_count(const Geometry& geometry) {
    if (const auto* mesh = std::get_if<MeshGeometry>(&geometry.data))
        return mesh->slots.empty() ? 1 : *std::max_element(mesh->slots.begin(), mesh->slots.end()) + 1;
    if (const auto* voxels = std::get_if<VoxelGeometry>(&geometry.data))
        return voxels->tree ? voxels->tree->palette_maximum() : 0;
    if (const auto* voxels = std::get_if<SdfVoxelGeometry>(&geometry.data))
        return std::uint32_t(voxels->strata.size() + 1);
    const auto* volume = std::get_if<VolumeGeometry>(&geometry.data);
    return volume && !volume->surface ? 0 : 1;
}

Fault transform_fault(const mat4x3& transform) {
    if (!finite(transform)) return "has a transform that is not finite";
    const glm::dvec3 x(transform[0]), y(transform[1]), z(transform[2]);
    // Lengths are squared in single precision on the way.
    for (const double scale : {glm::length(x), glm::length(y), glm::length(z)})
        if (scale > 0 && !(scale >= 1e-18 && scale <= 1e18))
            return fmt::format("has a transform that scales an axis by {:g}; 1e-18 to 1e18 is allowed", scale);
    const double volume = std::abs(glm::dot(glm::cross(x, y), z));
    const double edges = glm::length(x) * glm::length(y) * glm::length(z);
    if (!(volume > 1e-6 * edges)) return "has a singular transform: it flattens space";
    return {};
}

Fault fault(const Camera& camera) {
    if (!finite(camera.from) || !finite(camera.at) || !finite(camera.up)) return "has a point that is not finite";
    const glm::dvec3 view = glm::dvec3(camera.at) - glm::dvec3(camera.from), up(camera.up);
    if (!(glm::length(view) > 0)) return "looks at the point where it stands: \"from\" and \"at\" must differ";
    if (!(glm::length(glm::cross(view, up)) > 1e-6 * glm::length(view) * glm::length(up)))
        return "has \"up\" along its view";
    if (camera.kind == Camera::Kind::perspective && !(camera.fov > 0 && camera.fov < 180))
        return "has a fov that is not between 0 and 180 degrees";
    if (camera.kind == Camera::Kind::orthographic && !above_zero(camera.height))
        return "has a height that is not above 0";
    if (!(camera.lens_radius >= 0 && finite(camera.lens_radius))) return "has a negative lens_radius";
    if (!(camera.focus_distance >= 0 && finite(camera.focus_distance))) return "has a negative focus_distance";
    return {};
}

Fault fault(const Film& film) {
    if (film.size.x < 1 || film.size.y < 1) return "has a size of zero: width and height must be at least 1 pixel";
    if (film.size.x > 65536 || film.size.y > 65536) return "is more than 65536 pixels wide or high";
    if (!finite(film.exposure)) return "has an exposure that is not finite";
    if (!above_zero(film.filter_radius)) return "has a filter_radius that is not above 0";
    return {};
}

Fault fault(const Light& light) {
    return std::visit(
        overloaded{
            [](const PointLight& l) -> Fault {
                if (!finite(l.position)) return "has a position that is not finite";
                if (!at_least_zero(l.intensity)) return "has an intensity that is negative or not finite";
                return {};
            },
            [](const SpotLight& l) -> Fault {
                if (!finite(l.position)) return "has a position that is not finite";
                if (!finite(l.direction) || !(glm::length(l.direction) > 0)) return "has a direction of length 0";
                if (!at_least_zero(l.intensity)) return "has an intensity that is negative or not finite";
                if (!(l.inner_angle >= 0 && l.outer_angle <= 90 && l.inner_angle <= l.outer_angle && l.outer_angle > 0))
                    return "must have 0 ≤ inner_angle ≤ outer_angle ≤ 90 degrees, and outer_angle above 0";
                return {};
            },
            [](const DirectionalLight& l) -> Fault {
                if (!finite(l.direction) || !(glm::length(l.direction) > 0)) return "has a direction of length 0";
                if (!at_least_zero(l.irradiance)) return "has an irradiance that is negative or not finite";
                if (!(l.angular_radius >= 0 && l.angular_radius < 90))
                    return "must have an angular_radius from 0 to below 90 degrees";
                return {};
            },
        },
        light.data);
}

Fault fault(const DvrOptions& dvr) {
    for (const float x :
         {dvr.width, dvr.opacity, dvr.ambient, dvr.diffuse, dvr.specular, dvr.shininess, dvr.shadow, dvr.shadow_reach})
        if (!at_least_zero(x)) return "has a number that is negative or not finite";
    if (!finite(dvr.level) || !finite(dvr.iso)) return "has a level or an iso that is not finite";
    if (!(dvr.step >= 0.01f && dvr.step <= 100) || !above_zero(dvr.unit))
        return "has a step that is not from 0.01 to 100, or a unit that is not above 0";
    if (dvr.shadow > 1) return "has a shadow above 1";
    if (dvr.points.size() == 1) return "has one of \"points\": a transfer function needs two or more";
    for (std::size_t i = 0; i < dvr.points.size(); ++i) {
        const TransferPoint& p = dvr.points[i];
        if (!finite(p.value) || !at_least_zero(p.color) || !(p.opacity >= 0 && p.opacity <= 1))
            return "has a point with a value, colour or opacity out of range";
        if (i > 0 && p.value < dvr.points[i - 1].value) return "has points whose values do not rise";
    }
    for (int a = 0; a < 3; ++a)
        if (!(dvr.clip_lower[a] >= 0 && dvr.clip_lower[a] < dvr.clip_upper[a] && dvr.clip_upper[a] <= 1))
            return "has a clip_lower that is not below clip_upper, both from 0 to 1";
    if (dvr.clip_planes.size() > 4) return "has more than 4 clip_planes";
    for (const vec4& p : dvr.clip_planes)
        if (!finite(vec3(p)) || !std::isfinite(p.w) || vec3(p) == vec3(0))
            return "has a clip plane that is not finite or has no normal";
    return {};
}

Fault fault(const Medium& medium) {
    if (!at_least_zero(medium.scattering) || !at_least_zero(medium.absorption) || !at_least_zero(medium.emission))
        return "has a coefficient or emission that is negative or not finite";
    if (!(medium.g > -1 && medium.g < 1)) return "has g that is not between −1 and 1";
    const float span = medium.density_range.y - medium.density_range.x;
    if (!above_zero(span) || !finite(medium.density_range.x) || !finite(1.0f / span))
        return "has a density_range that does not rise";
    if (medium.grid < 0 && (medium.albedo >= 0 || medium.temperature >= 0))
        return "has an albedo or a temperature but no density that it could belong to";
    if (!above_zero(medium.temperature_reference) || !finite(medium.temperature_scale) ||
        !finite(medium.temperature_offset))
        return "has a temperature_reference, temperature_scale or temperature_offset out of range";
    const Erosion& erosion = medium.erosion;
    if (erosion.kind != Erosion::Kind::none) {
        if (medium.grid < 0) return "has erosion but no density that it could eat";
        if (!(erosion.strength >= 0 && finite(erosion.strength)) || !above_zero(erosion.frequency) ||
            erosion.octaves < 1 || erosion.octaves > 16 || !finite(erosion.drift) || !finite(erosion.velocity) ||
            !finite(erosion.time) || !finite(erosion.offset) || !(erosion.gain > 0 && erosion.gain <= 1) ||
            !(erosion.lacunarity >= 1 && erosion.lacunarity <= 8))
            return "has erosion with a strength, offset, frequency, number of octaves, gain, lacunarity, drift, "
                   "velocity "
                   "or time out of range";
    }
    return {};
}

Fault fault(const Grid& grid) {
    if (!grid.samples) return "has no samples";
    if (!finite(grid.samples->minimum()) || !finite(grid.samples->maximum()) || !finite(grid.background))
        return "has a value that is not finite";
    return transform_fault(grid.index_to_local);
}

Fault fault(const Geometry& geometry) {
    return std::visit(overloaded{
                          [](const MeshGeometry& mesh) { return mesh_fault(mesh); },
                          [](const VoxelGeometry& voxels) { return voxels_fault(voxels); },
                          [](const VolumeGeometry& volume) -> Fault {
                              if (!std::isfinite(volume.level)) return "has a level that is not finite";
                              return {};
                          },
                          [](const SdfGeometry& sdf) { return sdf_fault(sdf); },
                          [](const SdfVoxelGeometry& voxels) { return sdf_voxels_fault(voxels); },
                          [](const SphereGeometry& sphere) -> Fault {
                              if (!above_zero(sphere.radius)) return "has a radius that is not above 0";
                              return {};
                          },
                          [](const BoxGeometry& box) -> Fault {
                              if (!above_zero(box.size.x) || !above_zero(box.size.y) || !above_zero(box.size.z))
                                  return "has an edge that is not above 0";
                              return {};
                          },
                          [](const PlaneGeometry&) -> Fault { return {}; },
                          [](const RectangleGeometry& rectangle) -> Fault {
                              if (!above_zero(rectangle.size.x) || !above_zero(rectangle.size.y))
                                  return "has an edge that is not above 0";
                              return {};
                          },
                      },
                      geometry.data);
}

Fault fault(const EnvironmentData& environment) {
    return std::visit(overloaded{
                          [](std::monostate) -> Fault { return {}; },
                          [](const ConstantEnvironment& e) -> Fault {
                              if (!at_least_zero(e.radiance)) return "has a radiance that is negative or not finite";
                              return {};
                          },
                          [](const ImageEnvironment& e) -> Fault {
                              if (!at_least_zero(e.scale) || !finite(e.rotation))
                                  return "has a scale that is negative, or a rotation that is not finite";
                              return pixels_fault(e.pixels);
                          },
                          [](const SkyEnvironment& e) -> Fault {
                              if (!(e.sun_elevation >= -90 && e.sun_elevation <= 90))
                                  return "has a sun_elevation outside of −90 … 90 degrees";
                              if (!finite(e.sun_azimuth)) return "has a sun_azimuth that is not finite";
                              if (!(e.sun_angular_radius > 0 && e.sun_angular_radius < 90))
                                  return "has a sun_angular_radius that is not between 0 and 90 degrees";
                              if (!(e.haze >= 0 && finite(e.haze)) || !(e.scale >= 0 && finite(e.scale)))
                                  return "has haze or scale that is negative or not finite";
                              return {};
                          },
                      },
                      environment);
}

Fault fault(const Texture& texture) {
    return std::visit(overloaded{
                          [](const ImageTexture& image) -> Fault {
                              if (!finite(image.scale) || !finite(image.rotation) || !finite(image.offset))
                                  return "has a scale, rotation or offset that is not finite";
                              if (image.uv_set < 0 || image.uv_set > 1) return "has uv_set outside of 0 … 1";
                              return pixels_fault(image.pixels);
                          },
                          [](const CheckerTexture& checker) -> Fault {
                              if (!at_least_zero(checker.color_a) || !at_least_zero(checker.color_b))
                                  return "has a colour that is negative or not finite";
                              if (!finite(checker.scale) || !finite(checker.offset))
                                  return "has a scale or offset that is not finite";
                              return {};
                          },
                          [](const FaceTexture& faces) -> Fault {
                              if (auto f = pixels_fault(faces.pixels)) return f;
                              for (const glm::ivec4& r : faces.faces)
                                  if (r.x < 0 || r.y < 0 || r.z < 1 || r.w < 1 || r.z > faces.pixels->width - r.x ||
                                      r.w > faces.pixels->height - r.y)
                                      return "has a part that is empty or sticks out of the atlas";
                              return {};
                          },
                      },
                      texture.data);
}

namespace {

Fault medium_grids_fault(const Medium& medium, const Scene& scene) {
    for (const int grid : {medium.grid, medium.albedo, medium.temperature}) {
        if (grid < -1 || grid >= int(scene.grids.size())) return "refers to a grid that is not there";
        if (grid < 0) continue;
        const bool vectors = scene.grids[std::size_t(grid)].samples->channels() == 3;
        if (grid == medium.albedo && grid != medium.grid && !vectors) return "has an albedo that is not of colours";
        if (grid != medium.albedo && vectors) return "has a density or temperature that is of vectors, not of numbers";
    }
    return {};
}

}  // namespace

Result<void> validate(const Scene& scene) {
    const auto error = [](const std::string& thing, const Fault& f) { return Error{thing + " " + *f}; };
    const auto each = [&](const char* noun, const auto& things) -> Result<void> {
        for (std::size_t i = 0; i < things.size(); ++i)
            if (const Fault f = fault(things[i])) return error(called(noun, things[i].name, i), f);
        return {};
    };
    if (const Fault f = fault(scene.film)) return error("film", f);
    if (const auto found = choose_accelerator(scene.accelerator); !found) return found.error();
    if (scene.integrator.spp < 1) return Error{"integrator needs at least 1 sample per pixel"};
    if (scene.integrator.max_bounces < -1) return Error{"integrator has max_bounces below −1"};
    for (const float x : {scene.integrator.ao_radius, scene.integrator.ao_strength, scene.integrator.glow,
                          scene.integrator.glow_radius})
        if (!at_least_zero(x)) return Error{"integrator has a radius or a strength that is negative or not finite"};
    const MarchOptions& march = scene.integrator.march;
    for (const float x : {march.step, march.shadow_step, march.shadow_reach, march.surface_shadow_step,
                          march.surface_shadow_reach, march.light_reach})
        if (!at_least_zero(x)) return Error{"march of integrator has a step or a reach that is negative or not finite"};
    if (const Fault f = fault(scene.integrator.dvr)) return Error{"dvr of integrator " + *f};
    if (!at_least_zero(scene.integrator.depth_end) || !(scene.integrator.heat_most >= 1))
        return Error{"integrator has a depth_end below 0 or a heat_most below 1"};
    if (scene.integrator.heat_counter < 0 || scene.integrator.heat_counter > 3)
        return Error{"integrator has a heat_counter that is none of 0, 1, 2 and 3"};
    if (scene.integrator.ao_strength > 1) return Error{"integrator has ao_strength above 1"};
    if (const Fault f = fault(scene.environment)) return error("environment", f);
    if (auto result = each("camera", scene.cameras); !result) return result;
    if (auto result = each("texture", scene.textures); !result) return result;
    if (auto result = each("grid", scene.grids); !result) return result;
    if (auto result = each("medium", scene.media); !result) return result;
    if (auto result = each("geometry", scene.geometries); !result) return result;
    if (auto result = each("light", scene.lights); !result) return result;
    for (std::size_t i = 0; i < scene.media.size(); ++i)
        if (const Fault f = medium_grids_fault(scene.media[i], scene))
            return error(called("medium", scene.media[i].name, i), f);
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
        if (const Fault f = material_fault(scene.materials[i].values, scene))
            return error(called("material", scene.materials[i].name, i), f);

    std::vector<std::uint32_t> slot_counts;
    for (std::size_t i = 0; i < scene.geometries.size(); ++i) {
        const Geometry& geometry = scene.geometries[i];
        if (const auto* volume = std::get_if<VolumeGeometry>(&geometry.data)) {
            if (volume->grid < 0 || volume->grid >= int(scene.grids.size()))
                return Error{called("geometry", geometry.name, i) + " refers to a grid that is not there"};
            const Grid& grid = scene.grids[std::size_t(volume->grid)];
            if (volume->surface && grid.samples->channels() > 1)
                return Error{called("geometry", geometry.name, i) + " is a surface of vectors; it needs numbers"};
            if (volume->surface && grid.filter == Filter::nearest)
                return Error{called("geometry", geometry.name, i) +
                             " is a surface looked up by its nearest samples, which leaves steps: the filter has to be "
                             "linear or cubic"};
        }
        slot_counts.push_back(slot_count(geometry));
    }
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        if (const Fault f = object_fault(scene.objects[i], scene, slot_counts))
            return error(called("object", scene.objects[i].name, i), f);
    if (scene.expected && (!at_least_zero(scene.expected->mean) || !above_zero(scene.expected->tolerance)))
        return Error{"expected has a mean or a tolerance that is negative or not finite"};
    return {};
}

}  // namespace spinel
