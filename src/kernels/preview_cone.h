#ifndef SPINEL_KERNELS_PREVIEW_CONE_H
#define SPINEL_KERNELS_PREVIEW_CONE_H
// `cone`: light by cones through voxel sets. Crassin, Neyret, Sainz, Green, Eisemann, "Interactive Indirect
// Illumination Using Voxel Cone Tracing", Pacific Graphics 2011.
//
// A cone is marched with steps as long as it is wide, and looks at each into the voxels as they are seen at that size
// (voxel_mip.h). From what is seen six cones go out for the sky and the light that other voxels throw back, one for
// what the surface mirrors, as wide as it is rough, and one to the sun. Where in the footprint a step looks is random:
// the mean over samples is the smooth look-up between cells, at the price of one.
//
// Cones see voxel sets and the sky, nothing else: other geometry is lit by them, but neither shadows nor lights by
// them. What voxels throw back is one bounce of sun, with a shadow ray to one of the places that a cone saw, and half
// the sky.
#include "bvh.h"
#include "preview_glow.h"
#include "preview_shade.h"
#include "voxel_mip.h"
#include "warp.h"
KERNELS_BEGIN

const uint MAX_CONE_STEPS = 2048u;
const float CONE_OPAQUE = 1.0f / 256.0f;  // what is left of the light behind which nothing is asked
const float CONE_DIFFUSE_TAN = 0.25f;     // narrower than a sixth of the hemisphere: the six move from sample to sample
const float CONE_SHADOW_TAN = 0.02f;      // the narrowest to the sun
const float CONE_MIRROR_TAN = 0.01f;      // the narrowest of a reflection

// What a cone has gathered.
struct ConeSeen {
    float left;    // part of the light from behind that still arrives
    vec3 emitted;  // radiance
    // One of the places that cover the cone, picked by how much they do.
    float covered;
    vec3 place;
    float size;  // of the cone there
    vec3 albedo;
};

// Voxels of one instance at a point of a cone; size: of the footprint and of the step.
FN void cone_meets_set(const_in(SceneView) scene, uint instance, const_in(InstanceMips) mips, vec3 p, vec3 direction,
                       float size, inout(ConeSeen) seen, inout(Rng) rng) {
    RECORD(Instance) placed = scene.instances.at[instance];
    RECORD(VoxelGrid) grid = scene.voxel_grids.at[placed.geometry];
    vec3 q = placed.world_to_object * vec4(p, 1.0f);
    if (!(q.x >= 0.0f && q.y >= 0.0f && q.z >= 0.0f)) return;
    if (!(q.x < float(grid.size.x) && q.y < float(grid.size.y) && q.z < float(grid.size.z))) return;
    vec3 d = placed.world_to_object * vec4(direction, 0.0f);
    float stretch = length(d);  // cells per world unit along the cone
    d /= stretch;
    float cells = size * stretch;
    uint level = 0u;
    float level_edge = 4.0f;
    while (level < grid.level_count && level_edge <= cells) {  // ends: level_count is at most VOXEL_MAX_LEVELS
        ++level;
        level_edge *= 4.0f;
    }
    float edge;
    VoxelLook look = voxel_look_at(scene, grid, mips, ivec3(q), level, edge);
    float cover = dot(look.coverage, d * d);
    if (!(cover > 0.0f)) return;
    float taken = seen.left * (cover >= 1.0f ? 1.0f : 1.0f - pow(1.0f - cover, cells / edge));
    seen.emitted += (taken * look.share) * look.emission;
    seen.left -= taken;
    seen.covered += taken;
    if (rng_1d(rng) * seen.covered >= taken) return;
    seen.place = p;
    seen.size = size;
    seen.albedo = look.albedo;
}

FN bool box_holds(vec3 lower, vec3 upper, vec3 p) {
    return p.x >= lower.x && p.y >= lower.y && p.z >= lower.z && p.x <= upper.x && p.y <= upper.y && p.z <= upper.z;
}

// All voxel sets at a point of a cone.
FN void cone_meets(const_in(SceneView) scene, vec3 p, vec3 direction, float size, inout(ConeSeen) seen,
                   inout(Rng) rng) {
    BvhStack stack;
    uint stack_size = 1u;
    stack.entry[0] = 0u;       // nodes, not entries: their boxes are asked for when they are taken
    while (stack_size > 0u) {  // ends: every node is pushed once
        --stack_size;
        BvhNode node = scene.instance_nodes.at[stack.entry[stack_size]];
        if (!box_holds(node.lower, node.upper, p)) continue;
        if (node.count == 0u) {
            stack.entry[stack_size] = node.first;
            stack.entry[stack_size + 1u] = node.first + 1u;
            stack_size += 2u;
            continue;
        }
        for (uint i = node.first; i < node.first + node.count; ++i) {
            uint instance = scene.instance_order.at[i];
            InstanceMips mips = instance_mips(scene, instance);
            if (mips.palette_first != NONE) cone_meets_set(scene, instance, mips, p, direction, size, seen, rng);
        }
    }
}

// Marches a cone whose radius grows by `tangent` per unit of length, to the end of all that is bounded.
FN ConeSeen trace_cone(const_in(SceneView) scene, vec3 origin, vec3 direction, float tangent, inout(Rng) rng,
                       inout(bool) bound_reached) {
    ConeSeen seen = ConeSeen(1.0f, vec3(0.0f), 0.0f, origin, 0.0f, vec3(0.0f));
    if (scene.bounded_count == 0u || !(scene.mip_edge > 0.0f)) return seen;
    vec3 lower = scene.instance_nodes.at[0].lower;
    vec3 upper = scene.instance_nodes.at[0].upper;
    float far = distance(origin, 0.5f * (lower + upper)) + 0.5f * distance(lower, upper);
    float t = scene.mip_edge * rng_1d(rng);
    for (uint i = 0u; i < MAX_CONE_STEPS; ++i) {
        float size = max(scene.mip_edge, 2.0f * tangent * t);
        if (t > far) return seen;
        float x = rng_1d(rng);
        float y = rng_1d(rng);
        float z = rng_1d(rng);
        // Half the width: the cells that are looked into are themselves as wide as the cone.
        vec3 p = origin + t * direction + (0.5f * size) * (vec3(x, y, z) - 0.5f);
        cone_meets(scene, p, direction, size, seen, rng);
        if (seen.left < CONE_OPAQUE) {
            seen.left = 0.0f;
            return seen;
        }
        t += size;
    }
    bound_reached = true;
    return seen;
}

// Irradiance over π by the sun at the place that a cone picked. A short ray finds the surface there: the mips know
// neither where in their cube it lies nor how it stands.
FN vec3 bounced_sun(const_in(SceneView) scene, const_in(ConeSeen) seen, vec3 origin, vec3 direction) {
    if (is_black(scene.preview_light.sun)) return vec3(0.0f);
    float before = min(2.0f * seen.size, distance(seen.place, origin));
    Ray look = Ray(seen.place - before * direction, 0.0f, direction, before + 2.0f * seen.size);
    Hit hit = trace_closest(scene, look, TRACE_SOLID);
    if (!is_hit(hit)) return vec3(0.0f);
    Surface s = surface_at(scene, look, hit);
    vec3 n = s.entering ? s.geometric_normal : -s.geometric_normal;
    vec3 to_sun = scene.preview_light.to_sun;
    if (!(dot(n, to_sun) > 0.0f)) return vec3(0.0f);
    if (trace_occluded(scene, Ray(leave_surface(scene, s, to_sun), 0.0f, to_sun, INFINITE))) return vec3(0.0f);
    return preview_sun(scene, n);
}

// Radiance along a cone: what emits, what throws back light, and the sky behind.
FN vec3 cone_radiance(const_in(SceneView) scene, vec3 origin, vec3 direction, float tangent, inout(Rng) rng,
                      inout(bool) bound_reached) {
    ConeSeen seen = trace_cone(scene, origin, direction, tangent, rng, bound_reached);
    vec3 radiance = seen.emitted + seen.left * environment_radiance(scene, direction);
    if (!(seen.covered > 0.0f)) return radiance;
    vec3 light = 0.25f * (scene.preview_light.sky_above + scene.preview_light.sky_below);  // half of their mean
    light += bounced_sun(scene, seen, origin, direction);
    return radiance + seen.covered * seen.albedo * light;
}

// How much of the light is mirrored and how wide, by material: .w is the tangent of the cone; black: nothing is.
FN vec4 mirrored_part(const_in(Bsdf) b, vec3 albedo, float cosine) {
    float schlick = pow(1.0f - clamp(cosine, 0.0f, 1.0f), 5.0f);
    float f0 = sqr((b.ior - 1.0f) / (b.ior + 1.0f));
    vec3 coat = vec3(f0 + (1.0f - f0) * schlick);
    // Half of a GGX lobe lies within about α of its axis, twice that after reflection.
    float tangent = max(2.0f * sqr(b.roughness), CONE_MIRROR_TAN);
    if (b.kind == MATERIAL_METAL) return vec4(albedo, tangent);
    if (b.kind == MATERIAL_PLASTIC) return vec4(coat, tangent);
    if (b.kind == MATERIAL_PRINCIPLED) return vec4(mix(coat, albedo, b.metallic), tangent);
    return vec4(0.0f);
}

FN vec3 cone_shaded(const_in(SceneView) scene, const_in(PreviewView) view, inout(Sampler) numbers, inout(Rng) rng,
                    inout(bool) bound_reached) {
    vec3 wo = -view.ray.direction;
    vec3 n = view.surface.entering ? view.surface.geometric_normal : -view.surface.geometric_normal;
    // Off the surface by a little more than the first look-ups scatter, so that they do not fall into the voxel itself.
    vec3 origin = preview_origin(scene, view) + (0.3f * scene.mip_edge) * n;
    Bsdf bsdf = surface_bsdf(scene, view.surface, 1.0f);
    vec3 wo_local = to_local(view.frame, wo);
    vec4 mirrored = mirrored_part(bsdf, view.albedo, wo_local.z);
    vec3 mirror = vec3(mirrored.x, mirrored.y, mirrored.z);
    vec3 diffuse = max(view.albedo - mirror, vec3(0.0f));
    vec3 shaded = vec3(0.0f);

    vec2 u = sampler_2d(numbers);
    if (!is_black(diffuse)) {
        vec3 sky = vec3(0.0f);
        for (uint i = 0u; i < 6u; ++i) {
            // Six parts of the hemisphere of equal weight under the cosine.
            uint column = i % 3u;
            uint row = i / 3u;
            vec2 part = vec2((float(column) + u.x) * (1.0f / 3.0f), (float(row) + u.y) * 0.5f);
            vec3 direction = normalize(to_world(view.frame, square_to_cosine_hemisphere(part)));
            if (dot(direction, n) > 0.0f)
                sky += cone_radiance(scene, origin, direction, CONE_DIFFUSE_TAN, rng, bound_reached);
        }
        shaded += diffuse * sky * (1.0f / 6.0f);
    }
    if (!is_black(mirror)) {
        vec3 direction = normalize(reflect(view.ray.direction, view.frame.z));
        if (dot(direction, n) > 0.0f)
            shaded += mirror * cone_radiance(scene, origin, direction, mirrored.w, rng, bound_reached);
    }
    vec3 sun_local = to_local(view.frame, scene.preview_light.to_sun);
    if (sun_local.z > 0.0f && dot(scene.preview_light.to_sun, n) > 0.0f && !is_black(scene.preview_light.sun)) {
        vec3 f = bsdf_eval(bsdf, wo_local, sun_local);
        float tangent = max(scene.preview_light.sun_tan, CONE_SHADOW_TAN);
        if (!is_black(f)) {
            ConeSeen shadow = trace_cone(scene, origin, scene.preview_light.to_sun, tangent, rng, bound_reached);
            shaded += f * scene.preview_light.sun * shadow.left;
        }
    }
    return shaded;
}

FN PixelSample preview_cone(const_in(SceneView) scene, const_in(PreviewSettings) settings, Ray ray, const_in(Hit) first,
                            Sampler numbers) {
    PreviewView view = preview_view(scene, ray, first);
    Rng rng = make_rng(numbers, 0u);
    vec3 shaded = vec3(0.0f);
    if (view.found) {
        bool bound_reached = view.bound_reached;
        shaded = cone_shaded(scene, view, numbers, rng, bound_reached);
        view.bound_reached = bound_reached;
    }
    return preview_with_glow(scene, settings, view, preview_sample(scene, view, shaded));
}

KERNELS_END
#endif
