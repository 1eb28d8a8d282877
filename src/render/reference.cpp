#include "render/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "kernels/sdf.h"
#include "kernels/voxels.h"

namespace spinel {
namespace {

using glm::dvec3;
using kernels::SceneView;

struct LocalRay {
    dvec3 origin;
    dvec3 direction;
    double t_min;
    double t_max;
    dvec3 at(double t) const { return origin + t * direction; }
    bool admits(double t) const { return t > t_min && t < t_max; }
};

// A surface met in an instance's local space.
struct LocalHit {
    double t;
    std::uint32_t primitive = 0;
    std::uint32_t face = 0;
    glm::dvec2 uv = {0, 0};
    glm::ivec3 cell = {0, 0, 0};
    dvec3 normal = {0, 0, 0};
};
using MaybeHit = std::optional<LocalHit>;

void keep_nearer(MaybeHit& best, const MaybeHit& other) {
    if (other && (!best || other->t < best->t)) best = other;
}

dvec3 unit_axis(int axis, double sign) {
    dvec3 v(0);
    v[axis] = sign;
    return v;
}

// Möller and Trumbore; both sides, edges included.
MaybeHit hit_triangle(const kernels::Triangle& triangle, const LocalRay& ray) {
    const dvec3 a(triangle.a), e1 = dvec3(triangle.b) - a, e2 = dvec3(triangle.c) - a;
    const dvec3 p = glm::cross(ray.direction, e2);
    const double determinant = glm::dot(e1, p);
    if (determinant == 0) return {};
    const dvec3 s = ray.origin - a;
    const double u = glm::dot(s, p) / determinant;
    const dvec3 q = glm::cross(s, e1);
    const double v = glm::dot(ray.direction, q) / determinant;
    if (!(u >= 0 && v >= 0 && u + v <= 1)) return {};
    const double t = glm::dot(e2, q) / determinant;
    if (!ray.admits(t)) return {};
    return LocalHit{.t = t, .uv = {u, v}, .normal = glm::cross(e1, e2)};
}

MaybeHit hit_mesh(const SceneView& scene, const kernels::Mesh& mesh, const LocalRay& ray) {
    MaybeHit best;
    for (std::uint32_t i = 0; i < mesh.triangle_count; ++i) {
        MaybeHit hit = hit_triangle(scene.triangles.at[mesh.triangle_first + i], ray);
        if (hit) hit->primitive = i;
        keep_nearer(best, hit);
    }
    return best;
}

// Whatever has no interior is opaque and stops a ray at once; equal interiors are one medium; 0 stands for
// air.
struct Matter {
    bool opaque = false;
    std::uint32_t interior = kernels::NONE;  // NONE and not opaque: air
    bool operator==(const Matter&) const = default;
    bool is_air() const { return *this == Matter{}; }
};

Matter matter_at(const SceneView& scene, const kernels::VoxelGrid& grid, std::uint32_t slot_first,
                 const glm::ivec3& cell) {
    const std::uint32_t palette = kernels::voxel_at(scene, grid, cell);
    if (palette == 0) return {};
    const kernels::Slot slot = scene.slots.at[slot_first + palette - 1];
    return {.opaque = slot.interior == kernels::NONE && slot.material != kernels::NONE, .interior = slot.interior};
}

// All planes x = i, y = j, z = k cut the ray into pieces, each within one cell. The hit is where two
// neighbouring pieces hold different matter.
MaybeHit hit_voxels(const SceneView& scene, const kernels::VoxelGrid& grid, std::uint32_t slot_first,
                    const LocalRay& ray) {
    struct Crossing {
        double t;
        int axis;
    };
    std::vector<Crossing> crossings;
    for (int axis = 0; axis < 3; ++axis) {
        if (ray.direction[axis] == 0) continue;
        for (int plane = 0; plane <= grid.size[axis]; ++plane) {
            const double t = (plane - ray.origin[axis]) / ray.direction[axis];
            if (ray.admits(t)) crossings.push_back({t, axis});
        }
    }
    std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
    const auto cell_between = [&](double t0, double t1) { return glm::ivec3(glm::floor(ray.at(0.5 * (t0 + t1)))); };
    const auto place = [&](double t, const glm::ivec3& owner, int axis, bool positive) {
        const glm::dvec3 p = glm::clamp(ray.at(t) - dvec3(owner), 0.0, 1.0);
        return LocalHit{.t = t,
                        .primitive = kernels::voxel_at(scene, grid, owner),
                        .face = std::uint32_t(2 * axis + (positive ? 1 : 0)),
                        .uv = {p[(axis + 1) % 3], p[(axis + 2) % 3]},
                        .cell = owner,
                        .normal = unit_axis(axis, positive ? 1 : -1)};
    };

    const double after_first = crossings.empty() ? ray.t_min + 1e-6 / glm::length(ray.direction) : crossings[0].t;
    glm::ivec3 cell = cell_between(ray.t_min, after_first);
    Matter matter = matter_at(scene, grid, slot_first, cell);
    if (matter.opaque) {
        const dvec3 m = glm::abs(ray.direction);
        const int axis = m.x >= m.y && m.x >= m.z ? 0 : (m.y >= m.z ? 1 : 2);
        return place(ray.t_min, cell, axis, ray.direction[axis] < 0);
    }
    for (std::size_t i = 0; i < crossings.size(); ++i) {
        const double t = crossings[i].t;
        const double t_next = i + 1 < crossings.size() ? crossings[i + 1].t : t + 1e-6 / glm::length(ray.direction);
        if (t_next == t) continue;  // an edge or a corner: the piece has no length
        const glm::ivec3 next_cell = cell_between(t, t_next);
        const Matter next = matter_at(scene, grid, slot_first, next_cell);
        if (next != matter) {
            const int axis = crossings[i].axis;
            const bool forward = ray.direction[axis] > 0;
            return next.is_air() ? place(t, cell, axis, forward) : place(t, next_cell, axis, !forward);
        }
        cell = next_cell;
        matter = next;
    }
    return {};
}

// How far a point of a cell is outside of the voxel there, below 0 within it: rounded edges, waves
// (kernels/voxel_shapes.h says what they are).
double outside_voxel(const SceneView& scene, const kernels::VoxelGrid& grid, std::uint32_t slot_first,
                     const glm::ivec3& cell, const dvec3& p) {
    const std::uint32_t palette = kernels::voxel_at(scene, grid, cell);
    const double shape = palette == 0 ? 0 : double(scene.floats.at[grid.shape_first + palette - 1]);
    const auto air = [&](int axis, int side) {
        glm::ivec3 there = cell;
        there[axis] += side;
        return matter_at(scene, grid, slot_first, there).is_air();
    };
    if (shape > 0) {
        dvec3 d(0);
        for (int axis = 0; axis < 3; ++axis) {
            const double x = p[axis] - cell[axis];
            if (x < shape && air(axis, -1)) d[axis] = x - shape;
            if (x > 1 - shape && air(axis, 1)) d[axis] = x - (1 - shape);
        }
        return glm::length(d) - shape;
    }
    if (!(shape < 0) || !air(1, 1)) return -1;
    const float* table = scene.floats.at + grid.wave_first;
    double height = double(table[0]);
    for (std::uint32_t i = 0; i < grid.wave_count; ++i) {
        const float* wave = table + 3 + 4 * i;
        height += double(wave[3]) * std::sin(double(wave[0]) * p.x + double(wave[1]) * p.z + double(wave[2]));
    }
    return p.y - cell.y - height;
}

// As hit_voxels, where voxels do not fill their cells: many small steps through each, bisection where matter changes.
MaybeHit hit_shaped_voxels(const SceneView& scene, const kernels::VoxelGrid& grid, std::uint32_t slot_first,
                           const LocalRay& ray) {
    constexpr int step_count = 200;
    std::vector<double> ends{ray.t_min};
    for (int axis = 0; axis < 3; ++axis)
        for (int plane = 0; plane <= grid.size[axis] && ray.direction[axis] != 0; ++plane) {
            const double t = (plane - ray.origin[axis]) / ray.direction[axis];
            if (ray.admits(t)) ends.push_back(t);
        }
    std::sort(ends.begin(), ends.end());
    const auto matter_in = [&](const glm::ivec3& cell, double t) {
        const Matter full = matter_at(scene, grid, slot_first, cell);
        return full.is_air() || outside_voxel(scene, grid, slot_first, cell, ray.at(t)) > 0 ? Matter{} : full;
    };
    const auto place = [&](double t, const glm::ivec3& owner, const dvec3& normal, std::uint32_t flags) {
        const dvec3 m = glm::abs(normal), p = glm::clamp(ray.at(t) - dvec3(owner), 0.0, 1.0);
        const int axis = m.x >= m.y && m.x >= m.z ? 0 : (m.y >= m.z ? 1 : 2);
        return LocalHit{.t = t,
                        .primitive = kernels::voxel_at(scene, grid, owner),
                        .face = std::uint32_t(2 * axis + (normal[axis] > 0 ? 1 : 0)) | flags,
                        .uv = {p[(axis + 1) % 3], p[(axis + 2) % 3]},
                        .cell = owner,
                        .normal = normal};
    };
    const auto entered_axis = [&](const glm::ivec3& from, const glm::ivec3& to) {
        return from.x != to.x ? 0 : from.y != to.y ? 1 : 2;
    };
    Matter matter;
    glm::ivec3 cell(0);
    bool begun = false;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const double begin = ends[i],
                     end = i + 1 < ends.size() ? ends[i + 1] : begin + 1e-6 / glm::length(ray.direction);
        if (!(end > begin)) continue;
        const glm::ivec3 next = glm::ivec3(glm::floor(ray.at(0.5 * (begin + end))));
        const double margin = 1e-7 * (end - begin);
        double t = begin + margin;
        const Matter entered = matter_in(next, t);
        if (!begun && entered.opaque) {
            const dvec3 m = glm::abs(ray.direction);
            const int axis = m.x >= m.y && m.x >= m.z ? 0 : (m.y >= m.z ? 1 : 2);
            return place(ray.t_min, next, unit_axis(axis, ray.direction[axis] < 0 ? 1 : -1), 0);
        }
        if (begun && entered != matter) {
            const int axis = entered_axis(cell, next);
            const double against = ray.direction[axis] > 0 ? -1 : 1;
            return entered.is_air() ? place(begin, cell, unit_axis(axis, -against), 0)
                                    : place(begin, next, unit_axis(axis, against), 0);
        }
        begun = true;
        matter = entered;
        cell = next;
        for (int k = 1; k <= step_count; ++k) {
            double there = begin + margin + (end - begin - 2 * margin) * k / step_count;
            if (matter_in(cell, there) == matter) {
                t = there;
                continue;
            }
            for (int j = 0; j < 60; ++j) {
                const double middle = 0.5 * (t + there);
                (matter_in(cell, middle) == matter ? t : there) = middle;
            }
            dvec3 normal;
            for (int axis = 0; axis < 3; ++axis)
                normal[axis] = outside_voxel(scene, grid, slot_first, cell, ray.at(there) + unit_axis(axis, 1e-6)) -
                               outside_voxel(scene, grid, slot_first, cell, ray.at(there) - unit_axis(axis, 1e-6));
            return place(there, cell, normal, kernels::VOXEL_FACE_INNER);
        }
    }
    return {};
}

MaybeHit hit_sphere(const LocalRay& ray) {
    const double a = glm::dot(ray.direction, ray.direction);
    const double b = glm::dot(ray.origin, ray.direction) / a;
    const dvec3 foot = ray.origin - b * ray.direction;
    const double discriminant = 1 - glm::dot(foot, foot);
    if (discriminant < 0) return {};
    const double half_chord = std::sqrt(discriminant / a);
    for (const double t : {-b - half_chord, -b + half_chord}) {
        if (ray.admits(t)) return LocalHit{.t = t, .normal = ray.at(t)};
    }
    return {};
}

// The six faces of [-1, 1]³, one by one.
MaybeHit hit_box(const LocalRay& ray) {
    MaybeHit best;
    for (int axis = 0; axis < 3; ++axis) {
        for (const int sign : {-1, 1}) {
            if (ray.direction[axis] == 0) continue;
            const double t = (sign - ray.origin[axis]) / ray.direction[axis];
            const double p = ray.at(t)[(axis + 1) % 3], q = ray.at(t)[(axis + 2) % 3];
            if (!ray.admits(t) || std::abs(p) > 1 || std::abs(q) > 1) continue;
            keep_nearer(best, LocalHit{.t = t,
                                       .primitive = std::uint32_t(2 * axis + (sign > 0 ? 1 : 0)),
                                       .uv = {0.5 + 0.5 * p, 0.5 + 0.5 * q},
                                       .normal = unit_axis(axis, sign)});
        }
    }
    return best;
}

MaybeHit hit_plane(const LocalRay& ray) {
    if (ray.direction.y == 0) return {};
    const double t = -ray.origin.y / ray.direction.y;
    if (!ray.admits(t)) return {};
    return LocalHit{.t = t, .normal = {0, 1, 0}};
}

MaybeHit hit_rectangle(const LocalRay& ray) {
    MaybeHit hit = hit_plane(ray);
    if (!hit) return {};
    const dvec3 p = ray.at(hit->t);
    if (std::abs(p.x) > 1 || std::abs(p.z) > 1) return {};
    hit->uv = {0.5 + 0.5 * p.x, 0.5 - 0.5 * p.z};
    return hit;
}

// Many small fixed steps across the bounds, then bisection where the sign changes. Misses what is thinner
// than a step.
MaybeHit hit_sdf(const SceneView& scene, std::uint32_t sdf, const LocalRay& ray) {
    constexpr int step_count = 4096;
    const dvec3 lower(scene.sdfs.at[sdf].lower), upper(scene.sdfs.at[sdf].upper);
    double enter = ray.t_min, leave = ray.t_max;
    for (int axis = 0; axis < 3; ++axis) {
        if (ray.direction[axis] == 0) {
            if (ray.origin[axis] < lower[axis] || ray.origin[axis] > upper[axis]) return {};
            continue;
        }
        const double t0 = (lower[axis] - ray.origin[axis]) / ray.direction[axis];
        const double t1 = (upper[axis] - ray.origin[axis]) / ray.direction[axis];
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1));
    }
    if (!(enter < leave)) return {};
    const auto inside = [&](double t) { return kernels::sdf_distance(scene, sdf, glm::vec3(ray.at(t))) < 0; };
    const bool start_inside = inside(enter);
    double previous = enter;
    for (int i = 1; i <= step_count; ++i) {
        double t = enter + (leave - enter) * i / step_count;
        if (inside(t) == start_inside) {
            previous = t;
            continue;
        }
        for (int j = 0; j < 60; ++j) {
            const double middle = 0.5 * (previous + t);
            (inside(middle) == start_inside ? previous : t) = middle;
        }
        if (!ray.admits(t)) return {};
        const dvec3 p = ray.at(t);
        const double h = 1e-3 * glm::length(upper - lower);  // central differences
        dvec3 normal;
        for (int axis = 0; axis < 3; ++axis) {
            const dvec3 d = unit_axis(axis, h);
            normal[axis] = double(kernels::sdf_distance(scene, sdf, glm::vec3(p + d))) -
                           double(kernels::sdf_distance(scene, sdf, glm::vec3(p - d)));
        }
        return LocalHit{.t = t, .normal = normal};
    }
    return {};
}

MaybeHit hit_instance(const SceneView& scene, const kernels::Instance& instance, const LocalRay& ray) {
    switch (instance.geometry_kind) {
        case kernels::GEOMETRY_MESH: return hit_mesh(scene, scene.meshes.at[instance.geometry], ray);
        case kernels::GEOMETRY_VOXELS:
            if (scene.voxel_grids.at[instance.geometry].walk == kernels::VOXEL_WALK_SHAPES)
                return hit_shaped_voxels(scene, scene.voxel_grids.at[instance.geometry], instance.slot_first, ray);
            return hit_voxels(scene, scene.voxel_grids.at[instance.geometry], instance.slot_first, ray);
        case kernels::GEOMETRY_SDF: return hit_sdf(scene, instance.geometry, ray);
        case kernels::GEOMETRY_SPHERE: return hit_sphere(ray);
        case kernels::GEOMETRY_BOX: return hit_box(ray);
        case kernels::GEOMETRY_PLANE: return hit_plane(ray);
        case kernels::GEOMETRY_RECTANGLE: return hit_rectangle(ray);
    }
    return {};
}

}  // namespace

ReferenceHit reference_hit(const SceneView& scene, const kernels::Ray& ray, kernels::uint mask) {
    ReferenceHit best{double(ray.t_max), kernels::no_hit(ray.t_max)};
    for (std::uint32_t i = 0; i < scene.instance_count; ++i) {
        const kernels::Instance& instance = scene.instances.at[i];
        const bool pass_through = (instance.flags & kernels::INSTANCE_PASS_THROUGH) != 0;
        if (!(mask & (pass_through ? kernels::TRACE_PASS_THROUGH : kernels::TRACE_SOLID))) continue;
        const glm::dmat4x3 to_local(instance.world_to_object);
        const LocalRay local{to_local * glm::dvec4(ray.origin, 1), to_local * glm::dvec4(ray.direction, 0),
                             double(ray.t_min), best.t};
        const MaybeHit hit = hit_instance(scene, instance, local);
        if (!hit) continue;
        best.t = hit->t;
        best.hit = {.t = float(hit->t),
                    .instance = i,
                    .primitive = hit->primitive,
                    .face = hit->face,
                    .uv = glm::vec2(hit->uv),
                    .cell = hit->cell,
                    .normal = glm::vec3(hit->normal)};
    }
    return best;
}

kernels::Hit brute_force_closest(const SceneView& scene, const kernels::Ray& ray, kernels::uint mask) {
    ReferenceHit found = reference_hit(scene, ray, mask);
    // Rounded up: a ray that goes on from there must not meet the same surface again.
    if (double(found.hit.t) < found.t) found.hit.t = std::nextafter(found.hit.t, kernels::INFINITE);
    return found.hit;
}

bool brute_force_any(const SceneView& scene, const kernels::Ray& ray, kernels::uint mask) {
    return reference_hit(scene, ray, mask).hit.instance != kernels::NONE;
}

}  // namespace spinel
