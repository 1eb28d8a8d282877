#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/light.h"
#include "kernels/surface.h"
#include "scene/compilation.h"

namespace spinel {
namespace {

using kernels::NONE;
using kernels::uint;

kernels::Light blank_light(uint kind) {
    kernels::Light light = {};
    light.kind = kind;
    light.instance = light.material = NONE;
    light.key = kernels::uvec2(NONE);
    return light;
}

vec3 point(const mat4x3& m, vec3 p) { return m * vec4(p, 1); }
vec3 direction(const mat4x3& m, vec3 d) { return m * vec4(d, 0); }

bool emits(const CompiledScene& out, uint material) {
    return material != NONE && !kernels::is_black(out.materials[material].emission);
}

// A flat emitter from its corner and edges in local space; `outward` is its normal there.
kernels::Light flat_light(const CompiledScene& out, uint kind, uint instance, kernels::uvec2 key, uint material,
                          vec3 corner, vec3 u, vec3 v, vec3 outward) {
    const kernels::Instance& placed = out.instances[instance];
    kernels::Light light = blank_light(kind);
    light.instance = instance;
    light.key = key;
    light.material = material;
    light.position = point(placed.object_to_world, corner);
    light.u = direction(placed.object_to_world, u);
    light.v = direction(placed.object_to_world, v);
    const vec3 normal = glm::cross(light.u, light.v);
    const float length = glm::length(normal);
    light.area = kind == kernels::LIGHT_TRIANGLE ? 0.5f * length : length;
    light.direction = length > 0 ? glm::normalize(kernels::rotate_normal(placed, outward)) : vec3(0);
    light.two_sided = out.materials[material].emission_two_sided;
    return light;
}

void add_mesh_lights(CompiledScene& out, const kernels::SceneView& view, uint instance) {
    const kernels::Instance placed = out.instances[instance];
    const kernels::Mesh& mesh = out.meshes[placed.geometry];
    for (uint i = 0; i < mesh.triangle_count; ++i) {
        const uint material = out.slots[placed.slot_first + out.triangle_infos[mesh.triangle_first + i].slot].material;
        if (!emits(out, material)) continue;
        const kernels::Triangle& t = out.triangles[mesh.triangle_first + i];
        kernels::Light light = flat_light(out, kernels::LIGHT_TRIANGLE, instance, {i, 0}, material, t.a, t.b - t.a,
                                          t.c - t.a, glm::cross(t.b - t.a, t.c - t.a));
        if (!(light.area > 0)) continue;
        if (out.materials[material].emission_texture != NONE) {
            // Most of a textured emitter is often black: a triangle that is black all over needs no light.
            vec3 sum(0);
            for (int a = 0; a <= 4; ++a)
                for (int b = 0; a + b <= 4; ++b)
                    sum += kernels::material_emission(
                        view, material, kernels::light_uvs(view, light, vec2(float(a), float(b)) / 4.0f), NONE);
            if (kernels::is_black(sum)) continue;
            light.radiance = sum / 15.0f;
        }
        out.lights.push_back(light);
    }
}

void add_voxel_lights(CompiledScene& out, const kernels::SceneView& view, const VoxelTree& tree, uint instance) {
    const kernels::Instance placed = out.instances[instance];
    const auto slot_of = [&](uint palette) { return out.slots[placed.slot_first + palette - 1]; };
    // What is round or has waves is found by following paths alone: its faces are no parallelograms.
    const kernels::VoxelGrid& grid = out.voxel_grids[placed.geometry];
    const auto shaped = [&](uint palette) {
        return grid.walk == kernels::VOXEL_WALK_SHAPES && out.floats[grid.shape_first + palette - 1] != 0;
    };
    const std::size_t first = out.lights.size();
    const auto add_faces = [&](ivec3 cell, std::uint16_t palette) {
        for (uint face = 0; face < 6; ++face) {
            const int axis = int(face >> 1);
            ivec3 neighbour = cell;
            neighbour[axis] += (face & 1) ? 1 : -1;
            const uint across = tree.at(neighbour);
            // Nothing reaches a face between two opaque cells, and equal media have none.
            const uint there = kernels::voxel_class(view, placed.slot_first, across);
            if (there == kernels::VOXEL_OPAQUE || there == kernels::voxel_class(view, placed.slot_first, palette))
                continue;
            if (across != 0 && !kernels::voxel_owns(view, placed.slot_first, palette, across)) continue;
            vec3 corner(cell), u(0), v(0), normal(0);
            if (face & 1) corner[axis] += 1;
            u[(axis + 1) % 3] = 1;
            v[(axis + 2) % 3] = 1;
            normal[axis] = (face & 1) ? 1.0f : -1.0f;
            out.lights.push_back(flat_light(out, kernels::LIGHT_PARALLELOGRAM, instance,
                                            kernels::voxel_light_key(cell, face), slot_of(palette).material, corner, u,
                                            v, normal));
        }
    };
    tree.for_each_cube([&](ivec3 lower, int edge, std::uint16_t palette) {
        if (!emits(out, slot_of(palette).material) || shaped(palette)) return;
        // Cells within the cube have no neighbour of another kind.
        const auto outer = [edge](int i) { return i == 0 || i == edge - 1; };
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y)
                for (int x = 0; x < edge; x += outer(z) || outer(y) ? 1 : std::max(1, edge - 1))
                    add_faces(lower + ivec3(x, y, z), palette);
    });
    std::sort(out.lights.begin() + std::ptrdiff_t(first), out.lights.end(),
              [](const kernels::Light& a, const kernels::Light& b) {
                  return std::pair(a.key.y, a.key.x) < std::pair(b.key.y, b.key.x);
              });
}

void add_box_lights(CompiledScene& out, uint instance, uint material) {
    for (uint face = 0; face < 6; ++face) {
        const int axis = int(face >> 1);
        vec3 corner(-1), u(0), v(0), normal(0);
        if (face & 1) corner[axis] = 1;
        u[(axis + 1) % 3] = 2;
        v[(axis + 2) % 3] = 2;
        normal[axis] = (face & 1) ? 1.0f : -1.0f;
        out.lights.push_back(
            flat_light(out, kernels::LIGHT_PARALLELOGRAM, instance, {face, 0}, material, corner, u, v, normal));
    }
}

void add_sphere_light(CompiledScene& out, uint instance, uint material) {
    const kernels::Instance& placed = out.instances[instance];
    kernels::Light light = blank_light(kernels::LIGHT_SPHERE);
    light.instance = instance;
    light.key = kernels::uvec2(0);
    light.material = material;
    light.position = placed.object_to_world[3];
    light.radius = glm::length(placed.object_to_world[0]);
    light.area = 4 * kernels::PI * light.radius * light.radius;
    light.two_sided = out.materials[material].emission_two_sided;
    out.lights.push_back(light);
}

// Emitted or delivered power as the alias table sees it; only sampling depends on it.
double power_of(const CompiledScene& out, const kernels::Light& light) {
    const double radius = 0.5 * double(glm::length(out.upper - out.lower));
    const double disc = M_PI * std::max(radius * radius, 1e-6);
    vec3 radiance = light.radiance;
    if (light.material != NONE) {
        const kernels::Material& m = out.materials[light.material];
        if (m.emission_texture == NONE) radiance = m.emission;
        else if (light.kind != kernels::LIGHT_TRIANGLE)
            radiance = m.emission * mean_color(out, m.emission_texture, kernels::light_face(out.view(), light));
    }
    const double l = kernels::luminance(radiance);
    switch (light.kind) {
        case kernels::LIGHT_POINT: return 4 * M_PI * l;
        case kernels::LIGHT_SPOT: return 2 * M_PI * (1 - 0.5 * double(light.cos_inner + light.cos_outer)) * l;
        case kernels::LIGHT_ENVIRONMENT: return 4 * M_PI * disc * l;
        case kernels::LIGHT_DIRECTIONAL:
            return disc * l * (light.radius > 0 ? M_PI * double(kernels::sqr(std::sin(light.radius))) : 1.0);
        default: return M_PI * double(light.area) * l * (light.two_sided ? 2 : 1);
    }
}

// How far the environment is from equally bright all around, 0 … 1: the part of its light that sampling by brightness
// would have to move for that (total variation distance).
double environment_unevenness(const CompiledScene& out) {
    const kernels::Environment& e = out.environment;
    double moved = 0;
    for (uint y = 0; y < e.height; ++y) {
        const double row = double(out.floats[e.marginal_first + y + 1]) - double(out.floats[e.marginal_first + y]);
        const double upper = std::cos(M_PI * y / e.height), lower = std::cos(M_PI * (y + 1) / e.height);
        const float* columns = &out.floats[e.conditional_first + y * (e.width + 1)];
        for (uint x = 0; x < e.width; ++x)
            moved += std::abs(row * (double(columns[x + 1]) - double(columns[x])) - 0.5 * (upper - lower) / e.width);
    }
    return 0.5 * moved;
}

// By power; but power alone would nearly forget the sky beside the sun, and in the sun's shadow the sky is all there
// is. So a quarter of the samples is shared evenly between the infinite lights, each by itself, and all others
// together. Scattering itself finds an environment as well as sampling does, but for what stands out in it: so it
// counts by its unevenness, and one of a single colour is left to scattering where there is any other light.
std::vector<double> light_probabilities(const CompiledScene& out) {
    const std::size_t n = out.lights.size(), infinite = out.infinite_light_count;
    const double unevenness = out.environment.light == NONE ? 1 : environment_unevenness(out);
    std::vector<double> power(n), share(n);
    double total = 0, finite = 0, groups = 0;
    for (std::size_t i = 0; i < n; ++i) {
        share[i] = i == out.environment.light ? unevenness : 1;
        total += power[i] = share[i] * power_of(out, out.lights[i]);
        (i < infinite ? groups : finite) += i < infinite ? share[i] : power[i];
    }
    if (!(total > 0)) return std::vector<double>(n, 1.0 / double(n));
    if (finite > 0) groups += 1;
    std::vector<double> p(n);
    for (std::size_t i = 0; i < n; ++i)
        p[i] = 0.75 * power[i] / total + 0.25 / groups *
                                             (i < infinite ? share[i]
                                              : finite > 0 ? power[i] / finite
                                                           : 0.0);
    return p;
}

}  // namespace

void add_infinite_and_point_lights(Compilation& c) {
    for (const Light& light : c.scene.lights)
        if (const auto* d = std::get_if<DirectionalLight>(&light.data)) {
            kernels::Light k = blank_light(kernels::LIGHT_DIRECTIONAL);
            k.direction = glm::normalize(d->direction);
            k.radius = glm::radians(d->angular_radius);
            k.radiance =
                k.radius > 0 ? d->irradiance / (kernels::PI * kernels::sqr(std::sin(k.radius))) : d->irradiance;
            c.out.lights.push_back(k);
        }
    c.out.infinite_light_count = uint(c.out.lights.size());
    for (const Light& light : c.scene.lights) {
        if (const auto* p = std::get_if<PointLight>(&light.data)) {
            kernels::Light k = blank_light(kernels::LIGHT_POINT);
            k.position = p->position;
            k.radiance = p->intensity;
            c.out.lights.push_back(k);
        } else if (const auto* s = std::get_if<SpotLight>(&light.data)) {
            kernels::Light k = blank_light(kernels::LIGHT_SPOT);
            k.position = s->position;
            k.direction = glm::normalize(s->direction);
            k.radiance = s->intensity;
            k.cos_inner = std::cos(glm::radians(s->inner_angle));
            k.cos_outer = std::cos(glm::radians(s->outer_angle));
            c.out.lights.push_back(k);
        }
    }
}

Result<void> add_surface_lights(Compilation& c) {
    CompiledScene& out = c.out;
    const kernels::SceneView view = out.view();  // of what emits; the lights, which grow, are not looked at
    for (uint i = 0; i < out.instances.size(); ++i) {
        const Compilation::Shape& shape = c.shapes[std::size_t(c.scene.objects[i].geometry)];
        bool any = false;
        for (std::size_t s = 0; s < shape.slot_count; ++s)
            any |= emits(out, out.slots[out.instances[i].slot_first + s].material);
        if (!any) continue;
        const uint first = uint(out.lights.size());
        const kernels::Instance placed = out.instances[i];
        const uint material = out.slots[placed.slot_first].material;
        switch (placed.geometry_kind) {
            case kernels::GEOMETRY_MESH: add_mesh_lights(out, view, i); break;
            case kernels::GEOMETRY_VOXELS:
                if (const VoxelTreePointer& tree = c.trees[std::size_t(c.scene.objects[i].geometry)])
                    add_voxel_lights(out, view, *tree, i);
                break;
            case kernels::GEOMETRY_SPHERE:
                // A sphere that is stretched or textured is found by following paths alone.
                if (is_similarity(placed.object_to_world) && out.materials[material].emission_texture == NONE &&
                    out.materials[material].opacity_texture == NONE)
                    add_sphere_light(out, i, material);
                break;
            case kernels::GEOMETRY_BOX: add_box_lights(out, i, material); break;
            case kernels::GEOMETRY_RECTANGLE:
                out.lights.push_back(flat_light(out, kernels::LIGHT_PARALLELOGRAM, i, {0, 0}, material, {-1, 0, 1},
                                                {2, 0, 0}, {0, 0, -2}, {0, 1, 0}));
                break;
            default: break;  // planes have no area, SDFs no parametrisation: found by following paths
        }
        if (const Result<uint> place = pool_place(out.lights.size(), 0, "lights"); !place) return place.error();
        const uint count = uint(out.lights.size()) - first;
        out.instances[i].light_first = count > 0 ? first : NONE;
        out.instances[i].light_count = count;
    }
    return {};
}

// Vose, "A Linear Algorithm for Generating Random Numbers with a Given Distribution", 1991.
void build_light_table(CompiledScene& out) {
    const std::size_t n = out.lights.size();
    out.light_table.assign(n, {1.0f, 0, 0.0f});
    const std::vector<double> p = light_probabilities(out);
    std::vector<double> scaled(n);
    std::vector<uint> small, large;
    for (std::size_t i = 0; i < n; ++i) {
        out.light_table[i].probability = float(p[i]);
        scaled[i] = p[i] * double(n);
        (scaled[i] < 1 ? small : large).push_back(uint(i));
    }
    while (!small.empty() && !large.empty()) {
        const uint s = small.back(), l = large.back();
        small.pop_back();
        out.light_table[s].threshold = float(scaled[s]);
        out.light_table[s].alias = l;
        scaled[l] -= 1 - scaled[s];
        if (scaled[l] < 1) {
            large.pop_back();
            small.push_back(l);
        }
    }
    // What is left is 1 but for rounding.
    for (const uint i : small) out.light_table[i].alias = i;
    for (const uint i : large) out.light_table[i].alias = i;
}

}  // namespace spinel
