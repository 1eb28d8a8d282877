#include "scene/complete.h"

#include <algorithm>
#include <cmath>

#include "geometry/sdf/sdf_builder.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel {
namespace {

constexpr std::size_t points_per_geometry = 20000;

void add_corners(std::vector<vec3>& points, const mat4x3& m, vec3 lower, vec3 upper) {
    for (int i = 0; i < 8; ++i)
        points.push_back(m * vec4(i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z, 1));
}

struct OutlineOf {
    const Scene& scene;
    const mat4x3& m;
    std::vector<vec3>& points;

    void operator()(const MeshGeometry& mesh) const {
        const std::size_t step = std::max<std::size_t>(1, mesh.positions.size() / points_per_geometry);
        for (std::size_t i = 0; i < mesh.positions.size(); i += step) points.push_back(m * vec4(mesh.positions[i], 1));
        // What the stride leaves out must not leave the picture.
        vec3 lower = mesh.positions.front(), upper = lower;
        std::size_t extreme[6] = {};
        for (std::size_t i = 0; i < mesh.positions.size(); ++i)
            for (int a = 0; a < 3; ++a) {
                if (mesh.positions[i][a] < lower[a]) lower[a] = mesh.positions[i][a], extreme[a] = i;
                if (mesh.positions[i][a] > upper[a]) upper[a] = mesh.positions[i][a], extreme[a + 3] = i;
            }
        for (const std::size_t i : extreme) points.push_back(m * vec4(mesh.positions[i], 1));
    }
    void operator()(const VoxelGeometry& voxels) const {
        // The outermost voxels of every column: the outline without the inside. Columns are wider in large sets.
        const ivec3 size = voxels.tree->size();
        const int width = int(std::ceil(std::sqrt(double(size.x) * size.y / double(points_per_geometry))));
        const int across = (size.x + width - 1) / width;
        struct Column {
            ivec3 lower = ivec3(VoxelTree::max_edge), upper = ivec3(0);
        };
        std::vector<Column> columns(std::size_t(across) * std::size_t((size.y + width - 1) / width));
        voxels.tree->for_each_cube([&](ivec3 lower, int edge, std::uint16_t) {
            const ivec3 upper = lower + edge;
            for (int y = lower.y / width; y * width < upper.y; ++y)
                for (int x = lower.x / width; x * width < upper.x; ++x) {
                    Column& column = columns[std::size_t(x) + std::size_t(across) * std::size_t(y)];
                    const ivec3 corner(x * width, y * width, lower.z);
                    column.lower = glm::min(column.lower, glm::max(lower, corner));
                    column.upper = glm::max(column.upper, glm::min(upper, corner + ivec3(width, width, edge)));
                }
        });
        for (const Column& column : columns)
            if (column.upper.z > 0) add_corners(points, m, vec3(column.lower), vec3(column.upper));
    }
    void operator()(const VolumeGeometry& volume) const {
        const Grid& grid = scene.grids[std::size_t(volume.grid)];
        const glm::mat4 to_world = glm::mat4(m) * glm::mat4(grid.index_to_local);
        add_corners(points, mat4x3(to_world), vec3(0), vec3(grid.samples->size()));
    }
    void operator()(const SdfGeometry& sdf) const {
        // An expression that cannot be built is compile()'s to report.
        if (const Result<SdfData> data = build_sdf(sdf)) add_corners(points, m, data->sdf.lower, data->sdf.upper);
    }
    void operator()(const SdfVoxelGeometry& voxels) const { (*this)(voxels.sdf); }
    void operator()(const SphereGeometry& s) const { add_corners(points, m, vec3(-s.radius), vec3(s.radius)); }
    void operator()(const BoxGeometry& b) const { add_corners(points, m, -0.5f * b.size, 0.5f * b.size); }
    void operator()(const RectangleGeometry& r) const {
        const vec3 half(0.5f * r.size.x, 0, 0.5f * r.size.y);
        add_corners(points, m, -half, half);
    }
    void operator()(const PlaneGeometry&) const {}
};

bool has_light(const Scene& scene) {
    return !std::holds_alternative<std::monostate>(scene.environment) || !scene.lights.empty();
}

// Looks along a fixed direction and finds the nearest place from which every point is in the frame.
Camera framing_camera(const std::vector<vec3>& points, float aspect) {
    constexpr float azimuth = 0.61f, elevation = 0.33f, fov = 32, margin = 1.12f;  // radians, radians, degrees
    Camera camera;
    camera.name = "fitted";
    camera.fov = fov;
    const vec3 back(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                    std::cos(azimuth) * std::cos(elevation));
    const vec3 right = glm::normalize(glm::cross(vec3(0, 1, 0), back)), up = glm::cross(back, right);
    const float tan_y = std::tan(0.5f * glm::radians(fov)) / margin, tan_x = tan_y * aspect;
    vec3 lower(1e30f), upper(-1e30f);
    for (const vec3& p : points) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    vec3 target = 0.5f * (lower + upper);
    float distance = 0;
    for (int i = 0; i < 8; ++i) {  // alternate: far enough for all, then centre what is seen
        distance = 0;
        for (const vec3& p : points) {
            const vec3 q = p - target;
            const float depth = glm::dot(q, back);
            distance = std::max(
                distance, depth + std::max(std::abs(glm::dot(q, right)) / tan_x, std::abs(glm::dot(q, up)) / tan_y));
        }
        vec2 low(1e30f), high(-1e30f);
        for (const vec3& p : points) {
            const vec3 q = p - target;
            const vec2 seen =
                vec2(glm::dot(q, right), glm::dot(q, up)) / std::max(distance - glm::dot(q, back), 1e-6f * distance);
            low = glm::min(low, seen);
            high = glm::max(high, seen);
        }
        const vec2 shift = 0.5f * (low + high) * distance;
        target += right * shift.x + up * shift.y;
    }
    distance = std::max(distance, 1e-3f);
    camera.at = target;
    camera.from = target + distance * back;
    return camera;
}

void add_ground(Scene& scene, float height) {
    Material material{"ground", default_material(kernels::MATERIAL_DIFFUSE)};
    material.values.color = scene.surroundings.ground_color;
    scene.materials.push_back(material);
    scene.geometries.push_back({"ground", PlaneGeometry{}});
    Object ground;
    ground.name = "ground";
    ground.geometry = int(scene.geometries.size()) - 1;
    ground.transform[3] = vec3(0, height, 0);
    ground.materials = {int(scene.materials.size()) - 1};
    scene.objects.push_back(ground);
}

// A box of fog around all that is there, and above it.
void add_fog(Scene& scene, vec3 lower, vec3 upper) {
    const Surroundings& said = scene.surroundings;
    Medium medium;
    medium.name = "fog";
    medium.scattering = said.fog_density * said.fog_color;
    medium.absorption = said.fog_density * (1.0f - said.fog_color);
    medium.g = said.fog_g;
    scene.media.push_back(medium);
    const vec3 extent = upper - lower, margin = vec3(2.0f * std::max(extent.x, extent.z));
    scene.geometries.push_back({"fog", BoxGeometry{extent + 2.0f * margin}});
    Object fog;
    fog.name = "fog";
    fog.geometry = int(scene.geometries.size()) - 1;
    fog.transform[3] = 0.5f * (lower + upper);
    fog.materials = {-1};
    fog.interior = int(scene.media.size()) - 1;
    scene.objects.push_back(fog);
}

}  // namespace

std::vector<vec3> outline_points(const Scene& scene) {
    std::vector<vec3> points;
    for (const Object& object : scene.objects)
        std::visit(OutlineOf{scene, object.transform, points}, scene.geometries[std::size_t(object.geometry)].data);
    std::erase_if(points,
                  [](const vec3& p) { return !(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)); });
    return points;
}

void fit_camera(Scene& scene) {
    const std::vector<vec3> points = outline_points(scene);
    if (!points.empty())
        scene.cameras.push_back(
            framing_camera(points, float(scene.film.size.x) / float(std::max(scene.film.size.y, 1))));
}

void complete_model(Scene& scene) {
    const std::vector<vec3> points = outline_points(scene);
    if (points.empty()) return;
    if (scene.cameras.empty()) fit_camera(scene);
    scene.integrator.clamp = 10;  // a picture of a model is meant to be clean; a scene file decides for itself
    if (!has_light(scene)) {
        SkyEnvironment sky;
        sky.sun_elevation = 42;
        sky.sun_azimuth = -38;
        scene.environment = sky;
    }
    vec3 lower = points[0], upper = lower;
    for (const vec3& p : points) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    // A hair below, so that a flat bottom and the ground never fight for the same place.
    if (scene.surroundings.ground) add_ground(scene, lower.y - 1e-5f * std::max(upper.y - lower.y, 1e-3f));
    if (scene.surroundings.fog_density > 0.0f) add_fog(scene, lower, upper);
}

}  // namespace spinel
