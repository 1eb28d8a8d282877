#ifndef SPINEL_KERNELS_PREVIEW_GLOW_H
#define SPINEL_KERNELS_PREVIEW_GLOW_H
// A halo about voxels that emit, for the preview integrators.
//
// Every emitting voxel lends the space around it a glow that falls off as (1 − r²/R²)² up to the radius R; what a ray
// gathers on its way from the camera to what it sees is the integral of that, in closed form for each voxel. So it does
// not depend on how any walk steps through the set, has no grain, and is continuous everywhere. Nodes whose edge is
// below a quarter of the radius count as one (voxel_mip.h). A halo knows no shadows: what is behind a wall thinner than
// the radius glows through it.
//
// In units: within a large body of radiance L a way as long as the radius gathers strength · L.
#include "preview_shade.h"
#include "voxel_mip.h"
KERNELS_BEGIN

const uint MAX_GLOW_VISITS = 1048576u;  // children looked at for one ray and set

// ∫ (1 − (b² + s²)/R²)² ds over the part of [from, to] where the base is positive; s counts from the point of the line
// that is nearest to the centre, at a squared distance of b².
FN float glow_integral(float b2, float radius, float from, float to) {
    float u = 1.0f - b2 / (radius * radius);
    if (!(u > 0.0f)) return 0.0f;
    float half_chord = radius * sqrt(u);
    float a = clamp(from, -half_chord, half_chord) / radius;
    float b = clamp(to, -half_chord, half_chord) / radius;
    float at_a = a * (u * u - a * a * (2.0f / 3.0f * u - 0.2f * a * a));
    float at_b = b * (u * u - b * b * (2.0f / 3.0f * u - 0.2f * b * b));
    return radius * (at_b - at_a);
}

// A line in the local space of a set, in cells.
struct GlowLine {
    vec3 origin;
    vec3 direction;  // unit
    float end;
    float radius;
};

// What a ball of radiance and volume (cells) at `center` adds; the kernel's integral over its ball is R³ · 32π/105.
FN vec3 glow_of_blob(const_in(GlowLine) line, vec3 center, vec3 emission, float volume) {
    vec3 to = center - line.origin;
    float s = dot(to, line.direction);
    vec3 across = to - s * line.direction;
    float r2 = line.radius * line.radius;
    float density = volume * (105.0f / (32.0f * PI)) / (r2 * line.radius);
    return emission * (density * glow_integral(dot(across, across), line.radius, -s, line.end - s) / line.radius);
}

// Whether anything of a cube can be within the radius of the line.
FN bool glow_reaches(const_in(GlowLine) line, vec3 center, float edge) {
    vec3 to = center - line.origin;
    float s = clamp(dot(to, line.direction), 0.0f, line.end);
    vec3 away = to - s * line.direction;
    float reach = line.radius + 0.8660255f * edge;
    return dot(away, away) < reach * reach;
}

struct GlowStack {
    VoxelNode node[VOXEL_MAX_LEVELS];
    ivec3 lower[VOXEL_MAX_LEVELS];
    uint next[VOXEL_MAX_LEVELS];  // the first child that was not looked at
};

FN vec3 set_glow(const_in(SceneView) scene, const_in(VoxelGrid) grid, const_in(InstanceMips) mips,
                 const_in(GlowLine) line, inout(bool) bound_reached) {
    vec3 sum = vec3(0.0f);
    if (scene.voxel_mips.at[mips.palette_first].emitting == 0.0f) return sum;
    GlowStack stack;
    uint level = grid.level_count - 1u;
    stack.node[level] = grid.root;
    stack.lower[level] = ivec3(0);
    stack.next[level] = 0u;
    for (uint i = 0u; i < MAX_GLOW_VISITS; ++i) {
        VoxelNode node = stack.node[level];
        mask64 mask = make_mask64(node.mask_low, node.mask_high);
        uint child = stack.next[level];
        if (child < 64u) child += trailing_zeros64(mask64_shift_right(mask, child));
        if (child >= 64u) {
            ++level;
            if (level >= grid.level_count) return sum;
            continue;
        }
        stack.next[level] = child + 1u;
        int edge = 1 << (2u * level);
        ivec3 lower = stack.lower[level] + ivec3(child & 3u, (child >> 2u) & 3u, child >> 4u) * edge;
        vec3 center = vec3(lower) + 0.5f * float(edge);
        if (!glow_reaches(line, center, float(edge))) continue;
        uint rank = popcount64(mask64_below(mask, child));
        bool divided = (node.link & VOXEL_LINK_KIND) == VOXEL_LINK_CHILDREN;
        VoxelNode inside = VoxelNode(0xffffffffu, 0xffffffffu, 0u);
        uint mip;
        if (divided) {
            uint at = node.link + rank;
            if (grid.reference_first != NONE) at = scene.words.at[grid.reference_first + at];
            inside = scene.voxel_nodes.at[grid.node_first + at];
            mip = mips.node_first + at;
        } else {
            uint palette = voxel_palette(scene, grid, node, rank);
            inside.link = VOXEL_LINK_SOLID | palette;
            mip = mips.palette_first + palette;
        }
        float emitting = scene.voxel_mips.at[mip].emitting;
        if (emitting == 0.0f) continue;
        if (level == 0u || 4.0f * float(edge) <= line.radius) {
            sum += glow_of_blob(line, center, scene.voxel_mips.at[mip].emission,
                                emitting * float(edge) * float(edge) * float(edge));
            continue;
        }
        --level;
        stack.node[level] = inside;
        stack.lower[level] = lower;
        stack.next[level] = 0u;
    }
    bound_reached = true;
    return sum;
}

// The glow along the first `end` units of a ray of unit direction.
FN vec3 glow_along(const_in(SceneView) scene, const_in(PreviewSettings) settings, Ray ray, float end,
                   inout(bool) bound_reached) {
    vec3 sum = vec3(0.0f);
    for (uint i = 0u; i < scene.instance_count; ++i) {
        InstanceMips mips = instance_mips(scene, i);
        if (mips.palette_first == NONE) continue;
        RECORD(Instance) placed = scene.instances.at[i];
        RECORD(VoxelGrid) grid = scene.voxel_grids.at[placed.geometry];
        vec3 direction = placed.world_to_object * vec4(ray.direction, 0.0f);
        float stretch = length(direction);
        // Under a transform that stretches, the radius is the mean of the three.
        float scale = pow(abs(determinant(mat3(placed.world_to_object))), 1.0f / 3.0f);
        float radius = settings.glow_radius > 0.0f ? settings.glow_radius * scale : 4.0f;
        vec3 origin = placed.world_to_object * vec4(ray.origin, 1.0f);
        GlowLine line = GlowLine(origin, direction / stretch, min(end * stretch, 1.0e30f), radius);
        sum += set_glow(scene, grid, mips, line, bound_reached);
    }
    return settings.glow * sum;
}

FN PixelSample preview_with_glow(const_in(SceneView) scene, const_in(PreviewSettings) settings,
                                 const_in(PreviewView) view, PixelSample seen) {
    if (!(settings.glow > 0.0f)) return seen;
    bool bound_reached = seen.bound_reached;
    float end = view.found ? view.distance : 1.0e15f;
    seen.radiance += glow_along(scene, settings, view.first, end, bound_reached);
    seen.bound_reached = bound_reached;
    return seen;
}

KERNELS_END
#endif
