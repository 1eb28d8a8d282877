#ifndef SPINEL_KERNELS_SURFACE_H
#define SPINEL_KERNELS_SURFACE_H
// From a hit to what shading needs: position with its error, normals, texture coordinates, material, and which
// interiors the ray leaves and enters there.
#include "bsdf.h"
#include "contact.h"
#include "frame.h"
#include "interior.h"
#include "light.h"
#include "sdf.h"
#include "voxel_lines.h"
#include "voxel_shapes.h"
KERNELS_BEGIN

struct Surface {
    vec3 position;
    float error;            // bound of the position's rounding error: rays leave this far off
    vec3 geometric_normal;  // unit, outward
    vec3 normal;            // unit, for shading; on the outward side too
    vec3 tangent;           // unit or zero, along +u
    float bitangent_sign;   // of cross(normal, tangent)
    vec4 uvs;               // two sets of texture coordinates
    uint face;              // of a cube, for textures that differ by face; NONE: of none
    vec3 color;             // vertex colour
    vec4 line;              // colour and strength of an outline that is drawn here
    bool waves;             // of water in voxels (voxel_waves.h)
    uint material;          // NONE: a mere interface
    uint leaves;            // interiors on the side the ray comes from and goes to, as far as this surface decides them
    uint enters;
    bool entering;  // the ray runs against the outward normal
    bool contact;   // another surface may be in the same place: see boundary.h
    uint instance;
    uvec2 light_key;  // for light_of_primitive
};

FN vec3 rotate_normal(const_in(Instance) instance, vec3 n) { return n * mat3(instance.world_to_object); }

// Which of two voxels that are not opaque lends its material to the face between them, whatever side a ray comes from.
FN bool voxel_owns(const_in(SceneView) scene, uint slot_first, uint palette, uint other) {
    if (voxel_class(scene, slot_first, other) == VOXEL_AIR) return true;  // a slot of nothing is no neighbour
    if (voxel_class(scene, slot_first, palette) == VOXEL_AIR) return false;
    uint a = scene.slots.at[slot_first + palette - 1u].interior;
    uint b = scene.slots.at[slot_first + other - 1u].interior;
    if (a == NONE || b == NONE) return a == NONE;
    int difference = scene.interiors.at[a].priority - scene.interiors.at[b].priority;
    return difference != 0 ? difference > 0 : palette < other;
}

FN Surface surface_at(const_in(SceneView) scene, Ray ray, const_in(Hit) hit) {
    RECORD(Instance) instance = scene.instances.at[hit.instance];
    Surface s;
    s.instance = hit.instance;
    s.color = vec3(1.0f);
    s.tangent = vec3(0.0f);
    s.bitangent_sign = 1.0f;
    s.uvs = both_uvs(hit.uv);
    s.face = NONE;
    s.line = vec4(0.0f);
    s.waves = false;
    s.light_key = uvec2(hit.primitive, 0u);
    vec3 local = instance.world_to_object * vec4(ray_at(ray, hit.t), 1.0f);
    vec3 local_direction = instance.world_to_object * vec4(ray.direction, 0.0f);
    vec3 outward = hit.normal;
    vec3 shading = outward;
    bool smooth_normal = false;
    vec3 tangent = vec3(0.0f);
    uint slot = instance.slot_first;
    float extent = 0.0f;  // magnitude of the local coordinates that the position was computed from
    uint other = 0u;      // voxels: palette index across the face

    if (instance.geometry_kind == GEOMETRY_MESH) {
        RECORD(Mesh) mesh = scene.meshes.at[instance.geometry];
        RECORD(Triangle) t = scene.triangles.at[mesh.triangle_first + hit.primitive];
        RECORD(TriangleInfo) info = scene.triangle_infos.at[mesh.triangle_first + hit.primitive];
        float w = 1.0f - hit.uv.x - hit.uv.y;
        local = w * t.a + hit.uv.x * t.b + hit.uv.y * t.c;
        extent = max_component(max(abs(t.a), max(abs(t.b), abs(t.c))));
        vec3 weights = vec3(w, hit.uv.x, hit.uv.y);
        if (mesh.normal_first != NONE) {
            uvec3 i = info.vertices + mesh.normal_first;
            vec3 n = mat3(scene.normals.at[i.x], scene.normals.at[i.y], scene.normals.at[i.z]) * weights;
            if (dot(n, n) > 1.0e-12f) {
                shading = n;
                smooth_normal = true;
            }
        }
        s.uvs = mesh_uvs(scene, mesh, info.vertices, weights);
        if (mesh.tangent_first != NONE) {
            uvec3 i = info.vertices + mesh.tangent_first;
            vec4 t = mat3x4(scene.tangents.at[i.x], scene.tangents.at[i.y], scene.tangents.at[i.z]) * weights;
            tangent = vec3(t.x, t.y, t.z);
            if (t.w < 0.0f) s.bitangent_sign = -1.0f;
        }
        if (mesh.color_first != NONE) {
            uvec3 i = info.vertices + mesh.color_first;
            vec4 color = mat3x4(scene.colors.at[i.x], scene.colors.at[i.y], scene.colors.at[i.z]) * weights;
            s.color = vec3(color.x, color.y, color.z);
        }
        slot += info.slot;
    } else if (instance.geometry_kind == GEOMETRY_VOXELS) {
        RECORD(VoxelGrid) grid = scene.voxel_grids.at[instance.geometry];
        uint axis = (hit.face >> 1u) & 3u;
        bool positive = (hit.face & 1u) != 0u;
        bool inner = (hit.face & VOXEL_FACE_INNER) != 0u;
        s.face = hit.face & 7u;
        extent = max_component(vec3(grid.size));
        ivec3 neighbour = hit.cell;
        neighbour[axis] += positive ? 1 : -1;
        uint owner = hit.primitive;
        if (inner) {
            local = voxel_inner_position(scene, grid, hit, local);
            s.waves = voxel_shape(scene, grid, owner) < 0.0f;
            s.light_key = uvec2(NONE);  // no light is sampled on it
        } else {
            local[axis] = float(hit.cell[axis]) + (positive ? 1.0f : 0.0f);
            s.light_key = voxel_light_key(hit.cell, s.face);
            if ((hit.face & VOXEL_FACE_TO_AIR) == 0u) other = voxel_at(scene, grid, neighbour);
        }
        if (grid.line_first != NONE) s.line = voxel_line(scene, grid, hit.cell, axis, positive, hit.uv);
        if (other != 0u && !voxel_owns(scene, instance.slot_first, owner, other)) {
            uint exchanged = owner;
            owner = other;
            other = exchanged;
            outward = -outward;
            s.face ^= 1u;
            s.light_key = voxel_light_key(neighbour, s.face);
        }
        slot += owner - 1u;
    } else if (instance.geometry_kind == GEOMETRY_SDF) {
        RECORD(Sdf) sdf = scene.sdfs.at[instance.geometry];
        extent = max_component(max(abs(sdf.lower), abs(sdf.upper)));
        s.light_key = uvec2(NONE);
    } else if (instance.geometry_kind == GEOMETRY_SPHERE) {
        local = normalize(local);
        extent = 1.0f;
        s.uvs = both_uvs(
            vec2(atan(local.x, local.z) * (0.5f * INV_PI) + 0.5f, 1.0f - acos(clamp(local.y, -1.0f, 1.0f)) * INV_PI));
        tangent = vec3(local.z, 0.0f, -local.x);
    } else if (instance.geometry_kind == GEOMETRY_BOX) {
        uint axis = hit.primitive >> 1u;
        s.face = hit.primitive;
        local[axis] = (hit.primitive & 1u) != 0u ? 1.0f : -1.0f;
        extent = 1.0f;
    } else if (instance.geometry_kind == GEOMETRY_PLANE) {
        local.y = 0.0f;
        extent = max(abs(local.x), abs(local.z));
        s.uvs = both_uvs(vec2(local.x, -local.z));
        tangent = vec3(1.0f, 0.0f, 0.0f);
    } else {
        local.y = 0.0f;
        extent = 1.0f;
        tangent = vec3(1.0f, 0.0f, 0.0f);
    }

    mat3 linear = mat3(instance.object_to_world);
    s.position = instance.object_to_world * vec4(local, 1.0f);
    vec3 column_sum = abs(linear[0]) + abs(linear[1]) + abs(linear[2]);
    float magnitude = max(max_component(column_sum) * extent + max_component(abs(instance.object_to_world[3])),
                          max_component(abs(s.position)));
    s.error = magnitude * ROUNDING_ERROR;
    float touching = contact_error(scene, instance, s.position);
    s.contact = touching > 0.0f;
    s.error = max(s.error, touching);

    s.entering = dot(local_direction, outward) < 0.0f;
    s.geometric_normal = normalize_any(rotate_normal(instance, normalize_any(outward)));
    s.normal = smooth_normal ? normalize_any(rotate_normal(instance, normalize_any(shading))) : s.geometric_normal;
    if (dot(s.normal, s.geometric_normal) < 0.0f) s.normal = -s.normal;
    if (!is_black(tangent)) {
        vec3 world_tangent = linear * tangent;
        if (dot(world_tangent, world_tangent) > 1.0e-20f) s.tangent = normalize(world_tangent);
    }

    RECORD(Slot) here = scene.slots.at[slot];
    s.material = here.material;
    s.leaves = NONE;
    s.enters = NONE;
    if (s.entering) s.enters = here.interior;
    else s.leaves = here.interior;
    if (other != 0u) {  // a face between two voxels that are not air: the other side counts too
        RECORD(Slot) across = scene.slots.at[instance.slot_first + other - 1u];
        if (s.entering) s.leaves = across.interior;
        else s.enters = across.interior;
    }
    return s;
}

// Where a ray that leaves the surface towards `direction` begins: far enough on that side that rounding cannot put it
// on the other, and no farther.
FN vec3 leave_surface(const_in(SceneView) scene, const_in(Surface) s, vec3 direction) {
    float side = dot(direction, s.geometric_normal) >= 0.0f ? 1.0f : -1.0f;
    RECORD(Instance) instance = scene.instances.at[s.instance];
    if (instance.geometry_kind == GEOMETRY_SDF) {
        // An SDF's inside is a sign: step until the sign is the wanted one.
        vec3 p = instance.world_to_object * vec4(s.position, 1.0f);
        vec3 n = s.geometric_normal * mat3(instance.object_to_world);  // gradients transform by the transposed inverse
        float stretch = length(n);
        vec3 moved = sdf_offset_point(scene, instance.geometry, p, n / stretch, side, s.error * stretch);
        return instance.object_to_world * vec4(moved, 1.0f);
    }
    if (s.waves) {  // the sum of waves is rounded: step until the point is on the wanted side
        RECORD(VoxelGrid) grid = scene.voxel_grids.at[instance.geometry];
        float step = s.error;
        for (uint i = 0u; i < SDF_MAX_OFFSETS; ++i) {
            vec3 q = s.position + side * step * s.geometric_normal;
            vec3 p = instance.world_to_object * vec4(q, 1.0f);
            if ((voxel_at_point(scene, grid, instance.slot_first, p) == 0u) == (side > 0.0f)) return q;
            step *= 2.0f;
        }
    }
    return s.position + side * s.error * s.geometric_normal;
}

// The BSDF at a surface, textures applied. n_ratio: index of refraction across the surface over that on wo's side.
FN Bsdf surface_bsdf(const_in(SceneView) scene, const_in(Surface) s, float n_ratio) {
    RECORD(Material) m = scene.materials.at[s.material];
    vec3 color = m.color * s.color;
    float roughness = m.roughness;
    float metallic = m.metallic;
    if (m.color_texture != NONE) {
        vec4 t = texture_at(scene, m.color_texture, s.uvs, s.face);
        color *= vec3(t.x, t.y, t.z);
    }
    color = mix(color, vec3(s.line.x, s.line.y, s.line.z), s.line.w);
    if (m.roughness_texture != NONE) roughness *= texture_at(scene, m.roughness_texture, s.uvs, s.face).y;
    if (m.metallic_texture != NONE) metallic *= texture_at(scene, m.metallic_texture, s.uvs, s.face).z;
    microfacet_begin(scene);
    if (m.coat_texture == NONE && m.coat_roughness_texture == NONE && m.transmission_texture == NONE)
        return make_bsdf(m, color, roughness, metallic, n_ratio);
    Material textured = m;
    if (m.coat_texture != NONE) textured.coat *= texture_at(scene, m.coat_texture, s.uvs, s.face).x;
    if (m.coat_roughness_texture != NONE)
        textured.coat_roughness *= texture_at(scene, m.coat_roughness_texture, s.uvs, s.face).y;
    if (m.transmission_texture != NONE)
        textured.transmission *= texture_at(scene, m.transmission_texture, s.uvs, s.face).x;
    return make_bsdf(textured, color, roughness, metallic, n_ratio);
}

FN float surface_opacity(const_in(SceneView) scene, const_in(Surface) s) {
    if (s.material == NONE) return 0.0f;
    return material_opacity(scene, s.material, s.uvs, s.face);
}

// Radiance that the surface itself sends towards wo.
FN vec3 surface_emission(const_in(SceneView) scene, const_in(Surface) s) {
    if (s.material == NONE) return vec3(0.0f);
    if (is_black(scene.materials.at[s.material].emission)) return vec3(0.0f);
    if (!s.entering && scene.materials.at[s.material].emission_two_sided == 0u) return vec3(0.0f);
    return material_emission(scene, s.material, s.uvs, s.face);
}

// Shading frame whose z is on wo's side, the normal map applied; z is bent until wo stays above it.
FN Frame shading_frame(const_in(SceneView) scene, const_in(Surface) s, vec3 wo) {
    vec3 n = s.normal;
    uint map = scene.materials.at[s.material].normal_texture;
    if (map != NONE && !is_black(s.tangent)) {
        vec3 t = s.tangent - n * dot(n, s.tangent);
        if (dot(t, t) > 1.0e-12f) {
            t = normalize(t);
            vec3 b = s.bitangent_sign * cross(n, t);
            vec4 texel = texture_at(scene, map, s.uvs, s.face);
            float scale = scene.materials.at[s.material].normal_scale;
            vec3 m = vec3((2.0f * texel.x - 1.0f) * scale, (2.0f * texel.y - 1.0f) * scale,
                          max(2.0f * texel.z - 1.0f, 0.01f));
            n = normalize(m.x * t + m.y * b + m.z * n);
        }
    }
    vec3 ng = s.geometric_normal;
    if (dot(wo, ng) < 0.0f) {
        n = -n;
        ng = -ng;
    }
    float c = dot(wo, n);
    if (c < 0.01f) n = normalize(n + (0.01f - c) * wo);  // a normal seen from behind is turned to grazing
    return make_frame(n);
}

KERNELS_END
#endif
