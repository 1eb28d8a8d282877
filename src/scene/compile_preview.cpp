// What the preview integrators need beyond the rest: the sun and sky taken together, and voxels as they look from afar.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "geometry/voxels/voxel_mips.h"
#include "kernels/bsdf.h"
#include "kernels/environment.h"
#include "kernels/integrator_table.h"
#include "scene/compilation.h"

namespace spinel {
namespace {

using kernels::NONE;
using kernels::uint;
using kernels::VoxelLook;

int needs_of(std::string_view integrator) {
#define SPINEL_INTEGRATOR_NEEDS(number, name, text, needs, doc) \
    if (integrator == (text)) return needs;
    SPINEL_INTEGRATORS(SPINEL_INTEGRATOR_NEEDS)
#undef SPINEL_INTEGRATOR_NEEDS
    return SPINEL_NEEDS_NOTHING;
}

// Irradiance over π of surfaces that face up and down, by the environment.
void add_sky_means(const CompiledScene& out, const kernels::SceneView& view, kernels::PreviewLight& light) {
    const kernels::Environment& e = out.environment;
    glm::dvec3 sum[2] = {glm::dvec3(0), glm::dvec3(0)};
    double weights[2] = {0, 0};
    const int width = int(e.width), height = std::max(int(e.height), 2);  // a constant one has a single texel
    for (int y = 0; y < height; ++y) {
        const double theta = M_PI * (y + 0.5) / height, cosine = std::cos(theta);
        const double weight = std::abs(cosine) * std::sin(theta);
        for (int x = 0; x < width; ++x) {
            const vec3 texel = kernels::environment_texel(view, e, x, std::min(y, int(e.height) - 1));
            sum[cosine < 0] += weight * glm::dvec3(texel);
            weights[cosine < 0] += weight;
        }
    }
    if (weights[0] > 0) light.sky_above = vec3(sum[0] / weights[0]);
    if (weights[1] > 0) light.sky_below = vec3(sum[1] / weights[1]);
}

void add_sun(const CompiledScene& out, kernels::PreviewLight& light) {
    for (uint i = 0; i < out.infinite_light_count; ++i) {
        const kernels::Light& l = out.lights[i];
        if (l.kind != kernels::LIGHT_DIRECTIONAL) continue;
        const float disc = l.radius > 0 ? kernels::PI * kernels::sqr(std::sin(l.radius)) : 1.0f;
        if (kernels::luminance(disc * l.radiance) <= kernels::luminance(light.sun)) continue;
        light.sun = disc * l.radiance;
        light.to_sun = -l.direction;
        light.sun_tan = std::tan(l.radius);
    }
}

// A scene without sun and sky is looked at in this light.
kernels::PreviewLight studio_light() {
    kernels::PreviewLight light = {};
    light.to_sun = glm::normalize(vec3(0.4f, 0.8f, 0.5f));
    light.sun = vec3(2);
    light.sun_tan = std::tan(glm::radians(2.0f));
    light.sky_above = vec3(0.5f);
    light.sky_below = vec3(0.2f);
    return light;
}

// Of all faces alike: from afar nobody knows which one is seen.
vec3 mean_color_of_cube(const CompiledScene& out, uint texture) {
    if (texture == NONE || out.textures[texture].face_first == NONE) return mean_color(out, texture, 0);
    vec3 sum(0);
    for (uint face = 0; face < 6; ++face) sum += mean_color(out, texture, face);
    return sum / 6.0f;
}

VoxelLook look_of_material(const CompiledScene& out, const kernels::SceneView& view, uint material) {
    VoxelLook look = kernels::no_voxel_look();
    if (material == NONE) return look;
    const kernels::Material& m = out.materials[material];
    const vec3 emission = m.emission * mean_color_of_cube(out, m.emission_texture);
    const bool emits = !kernels::is_black(emission);
    if (m.kind == kernels::MATERIAL_DIELECTRIC && !emits) return look;  // cones see through glass
    look.coverage = vec3(glm::clamp(m.opacity, 0.0f, 1.0f));
    kernels::microfacet_begin(view);
    const kernels::Bsdf bsdf =
        kernels::make_bsdf(m, m.color * mean_color_of_cube(out, m.color_texture), m.roughness, m.metallic, 1.0f);
    look.albedo = glm::clamp(kernels::bsdf_albedo(bsdf, vec3(0, 0, 1)), vec3(0), vec3(1));
    if (emits) {
        look.share = look.emitting = 1;
        look.emission = emission;
    }
    return look;
}

}  // namespace

void add_preview_light(Compilation& c) {
    CompiledScene& out = c.out;
    out.preview_light.to_sun = vec3(0, 1, 0);
    add_sky_means(out, out.view(), out.preview_light);
    add_sun(out, out.preview_light);
    const kernels::PreviewLight& l = out.preview_light;
    if (kernels::is_black(l.sun) && kernels::is_black(l.sky_above) && kernels::is_black(l.sky_below))
        out.preview_light = studio_light();
}

bool wants_voxel_mips(const IntegratorSettings& settings, const std::string& integrator) {
    const int needs = needs_of(integrator.empty() ? settings.name : integrator);
    return needs == SPINEL_NEEDS_MIPS || (needs == SPINEL_NEEDS_GLOW_MIPS && settings.glow > 0);
}

Result<void> add_voxel_mips(Compilation& c) {
    CompiledScene& out = c.out;
    out.mip_edge = 0;
    std::vector<kernels::InstanceMips> of_instance;
    for (std::size_t i = 0; i < out.instances.size(); ++i) {
        of_instance.push_back({NONE, NONE});
        const kernels::Instance& placed = out.instances[i];
        if (placed.geometry_kind != kernels::GEOMETRY_VOXELS) continue;
        const std::size_t geometry = std::size_t(c.scene.objects[i].geometry), slots = c.shapes[geometry].slot_count;
        if (!c.trees[geometry]) continue;  // voxels of an SDF, which are nowhere kept: cones do not see them
        for (int axis = 0; axis < 3; ++axis) {
            const float edge = glm::length(placed.object_to_world[axis]);
            out.mip_edge = out.mip_edge > 0 ? std::min(out.mip_edge, edge) : edge;
        }
        // The same set in the same materials was there before?
        for (std::size_t j = 0; j < i && of_instance[i].palette_first == NONE; ++j) {
            if (c.scene.objects[j].geometry != c.scene.objects[i].geometry) continue;
            const auto material_of = [&](std::size_t instance, std::size_t slot) {
                return out.slots[out.instances[instance].slot_first + slot].material;
            };
            bool equal = true;
            for (std::size_t s = 0; s < slots && equal; ++s) equal = material_of(i, s) == material_of(j, s);
            if (equal) of_instance[i] = of_instance[j];
        }
        if (of_instance[i].palette_first != NONE) continue;
        const kernels::SceneView view = out.view();
        std::vector<VoxelLook> looks;
        for (std::size_t s = 0; s < slots; ++s)
            looks.push_back(look_of_material(out, view, out.slots[placed.slot_first + s].material));
        const VoxelMips mips = build_voxel_mips(*c.trees[geometry], looks);
        const Result<uint> palette = append_pool(out.voxel_mips, mips.palette, "coarser voxels for previews");
        if (!palette) return palette.error();
        const Result<uint> nodes = append_pool(out.voxel_mips, mips.nodes, "coarser voxels for previews");
        if (!nodes) return nodes.error();
        of_instance[i] = {*palette, *nodes};
    }
    std::vector<uint> places;
    for (const kernels::InstanceMips& mips : of_instance)
        places.insert(places.end(), {mips.palette_first, mips.node_first});
    const Result<uint> first = append_pool(out.words, places, WORDS);
    if (!first) return first.error();
    out.mip_first = *first;
    return {};
}

}  // namespace spinel
