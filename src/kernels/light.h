#ifndef SPINEL_KERNELS_LIGHT_H
#define SPINEL_KERNELS_LIGHT_H
// Next-event estimation: one light is picked by the alias table in proportion to its power, then a point on it.
// Every density is over solid angle at the receiver [1/sr], the light's own probability included.
#include "contact.h"
#include "environment.h"
#include "frame.h"
#include "texture.h"
#include "warp.h"
KERNELS_BEGIN

struct LightSample {
    vec3 direction;  // unit, from the receiver
    vec3 radiance;   // incident; of delta lights everything but the cosine
    float pdf;       // 0: nothing arrives; of delta lights the probability of the light alone
    bool delta;
    bool infinite;  // from infinitely far away: point means nothing
    vec3 point;     // where it comes from …
    vec3 normal;    // … the emitter's normal there (0: a point) …
    float error;    // … and the rounding error of the point
    float opacity;  // chance that a path which follows the direction meets the emitter; radiance holds it already
};

FN vec3 material_emission(const_in(SceneView) scene, uint material, vec4 uvs, uint face) {
    vec3 e = scene.materials.at[material].emission;
    uint t = scene.materials.at[material].emission_texture;
    if (t != NONE) {
        vec4 texel = texture_at(scene, t, uvs, face);
        e *= vec3(texel.x, texel.y, texel.z);
    }
    return e;
}

FN float material_opacity(const_in(SceneView) scene, uint material, vec4 uvs, uint face) {
    float opacity = scene.materials.at[material].opacity;
    uint t = scene.materials.at[material].opacity_texture;
    return t == NONE ? opacity : opacity * texture_at(scene, t, uvs, face).w;
}

FN vec2 mesh_uv(const_in(SceneView) scene, uint first, uvec3 vertices, vec3 weights) {
    uvec3 i = vertices + first;
    return mat3x2(scene.uvs.at[i.x], scene.uvs.at[i.y], scene.uvs.at[i.z]) * weights;
}

// Both sets of texture coordinates.
FN vec4 mesh_uvs(const_in(SceneView) scene, const_in(Mesh) mesh, uvec3 vertices, vec3 weights) {
    vec2 first = vec2(0.0f);
    if (mesh.uv_first != NONE) first = mesh_uv(scene, mesh.uv_first, vertices, weights);
    if (mesh.second_uv_first == NONE) return both_uvs(first);
    vec2 second = mesh_uv(scene, mesh.second_uv_first, vertices, weights);
    return vec4(first.x, first.y, second.x, second.y);
}

// Texture coordinates on a flat emitter; b are barycentric weights or the place on a parallelogram.
FN vec4 light_uvs(const_in(SceneView) scene, const_in(Light) light, vec2 b) {
    if (light.kind != LIGHT_TRIANGLE) return both_uvs(b);
    RECORD(Mesh) mesh = scene.meshes.at[scene.instances.at[light.instance].geometry];
    uvec3 v = scene.triangle_infos.at[mesh.triangle_first + light.key.x].vertices;
    return mesh_uvs(scene, mesh, v, vec3(1.0f - b.x - b.y, b.x, b.y));
}

// The face of a cube that a flat emitter is; NONE: it is none.
FN uint light_face(const_in(SceneView) scene, const_in(Light) light) {
    uint kind = scene.instances.at[light.instance].geometry_kind;
    if (kind == GEOMETRY_VOXELS) return light.key.y >> 28u;  // voxel_light_key()
    return kind == GEOMETRY_BOX ? light.key.x : NONE;
}

// 1 − cos of the half-angle under which a sphere is seen; stable for small and distant spheres.
FN float sphere_one_minus_cos(float radius, float distance_squared) {
    float sin2 = radius * radius / distance_squared;
    return sin2 < 1.0e-4f ? 0.5f * sin2 : 1.0f - safe_sqrt(1.0f - sin2);
}

FN float disc_one_minus_cos(float angle) { return 2.0f * sqr(sin(0.5f * angle)); }

// A direction within a cone about the unit vector `axis`, uniform over solid angle.
FN vec3 cone_direction(vec3 axis, float one_minus_cos, vec2 u) {
    return normalize(to_world(make_frame(axis), square_to_cone(u, one_minus_cos)));
}

FN LightSample no_light() {
    return LightSample(vec3(0.0f, 1.0f, 0.0f), vec3(0.0f), 0.0f, false, false, vec3(0.0f), vec3(0.0f), 0.0f, 1.0f);
}

FN LightSample infinite_light(vec3 direction, vec3 radiance, float pdf, bool delta) {
    return LightSample(direction, radiance, pdf, delta, true, vec3(0.0f), vec3(0.0f), 0.0f, 1.0f);
}

// Bound of a point's error on an emissive surface, or of what is in the same place as it.
FN float light_error(const_in(SceneView) scene, const_in(Light) light, vec3 point, float magnitude) {
    return max(magnitude * ROUNDING_ERROR, contact_error(scene, scene.instances.at[light.instance], point));
}

// A point on an emissive surface; `opacity` of its material there.
FN LightSample surface_light(vec3 direction, vec3 radiance, float pdf, vec3 point, vec3 normal, float error,
                             float opacity) {
    return LightSample(direction, radiance * opacity, pdf, false, false, point, normal, error, opacity);
}

FN LightSample sample_one_light(const_in(SceneView) scene, uint index, vec3 from, vec2 u) {
    RECORD(Light) light = scene.lights.at[index];
    float p = scene.light_table.at[index].probability;
    if (light.kind == LIGHT_ENVIRONMENT) {
        vec3 d = environment_sample(scene, u);
        return infinite_light(d, environment_radiance(scene, d), p * environment_pdf(scene, d), false);
    }
    if (light.kind == LIGHT_DIRECTIONAL) {
        vec3 axis = -light.direction;
        if (light.radius == 0.0f) return infinite_light(axis, light.radiance, p, true);
        float k = disc_one_minus_cos(light.radius);
        return infinite_light(cone_direction(axis, k, u), light.radiance, p / (2.0f * PI * k), false);
    }
    if (light.kind == LIGHT_POINT || light.kind == LIGHT_SPOT) {
        vec3 to = light.position - from;
        float d2 = dot(to, to);
        if (!(d2 > 0.0f)) return no_light();
        float d = sqrt(d2);
        vec3 direction = to / d;
        vec3 radiance = light.radiance / d2;
        if (light.kind == LIGHT_SPOT) {
            float c = -dot(direction, light.direction);
            if (c < light.cos_outer) return no_light();
            if (c < light.cos_inner) radiance *= smoothstep(light.cos_outer, light.cos_inner, c);
        }
        return LightSample(direction, radiance, p, true, false, light.position, vec3(0.0f), 0.0f, 1.0f);
    }
    if (light.kind == LIGHT_SPHERE) {
        vec3 to = light.position - from;
        float d2 = dot(to, to);
        vec3 radiance = scene.materials.at[light.material].emission;
        float opacity = scene.materials.at[light.material].opacity;
        float magnitude = max_component(abs(light.position)) + light.radius;
        if (d2 <= sqr(light.radius) * 1.00001f) {  // from inside: uniform over the surface
            if (light.two_sided == 0u) return no_light();
            vec3 n = square_to_sphere(u);
            vec3 v = to + light.radius * n;
            float l2 = dot(v, v);
            if (!(l2 > 0.0f)) return no_light();
            vec3 direction = v / sqrt(l2);
            float cosine = abs(dot(direction, n));
            if (cosine <= 0.0f) return no_light();
            vec3 point = light.position + light.radius * n;
            return surface_light(direction, radiance, p * l2 / (cosine * light.area), point, n,
                                 light_error(scene, light, point, magnitude), opacity);
        }
        float k = sphere_one_minus_cos(light.radius, d2);
        vec3 direction = cone_direction(to / sqrt(d2), k, u);
        // The near intersection of that direction with the sphere.
        float b = dot(to, direction);
        float disc = sqr(light.radius) - max(d2 - b * b, 0.0f);
        vec3 n = normalize((b - safe_sqrt(disc)) * direction - to);
        vec3 point = light.position + light.radius * n;
        return surface_light(direction, radiance, p / (2.0f * PI * k), point, n,
                             light_error(scene, light, point, magnitude), opacity);
    }
    // Flat emitters, uniform over the area.
    vec2 b = light.kind == LIGHT_TRIANGLE ? square_to_triangle(u) : u;
    vec3 point = light.position + b.x * light.u + b.y * light.v;
    vec3 to = point - from;
    float d2 = dot(to, to);
    if (!(d2 > 0.0f)) return no_light();
    float d = sqrt(d2);
    vec3 direction = to / d;
    float cosine = -dot(direction, light.direction);
    if (light.two_sided != 0u) cosine = abs(cosine);
    if (!(cosine > 1.0e-6f)) return no_light();
    float error = light_error(scene, light, point, max_component(abs(light.position) + abs(light.u) + abs(light.v)));
    vec4 uvs = light_uvs(scene, light, b);
    uint face = light_face(scene, light);
    return surface_light(direction, material_emission(scene, light.material, uvs, face), p * d2 / (cosine * light.area),
                         point, light.direction, error, material_opacity(scene, light.material, uvs, face));
}

FN bool is_point_light(const_in(Light) light) { return light.kind == LIGHT_POINT || light.kind == LIGHT_SPOT; }

// They stand behind the infinite ones.
FN bool has_point_lights(const_in(SceneView) scene) {
    return scene.infinite_light_count < scene.light_count &&
           is_point_light(scene.lights.at[scene.infinite_light_count]);
}

// One of at least one light. u_light and u_keep are independent: what u_light leaves below its index has too few bits
// where lights are many.
FN uint pick_light(const_in(SceneView) scene, float u_light, float u_keep) {
    uint index = min(uint(u_light * float(scene.light_count)), scene.light_count - 1u);
    return u_keep >= scene.light_table.at[index].threshold ? scene.light_table.at[index].alias : index;
}

FN LightSample sample_light(const_in(SceneView) scene, vec3 from, float u_light, float u_keep, vec2 u) {
    if (scene.light_count == 0u) return no_light();
    return sample_one_light(scene, pick_light(scene, u_light, u_keep), from, u);
}

// The light of an instance's emitting primitive; NONE if next-event estimation never chooses it. Lights of an instance
// are sorted by key, the second word first.
FN uint light_of_primitive(const_in(SceneView) scene, const_in(Instance) instance, uvec2 key) {
    if (instance.light_first == NONE || instance.light_count == 0u) return NONE;
    uint lo = 0u;
    uint hi = instance.light_count;
    while (hi - lo > 1u) {  // ends: the interval halves
        uint mid = (lo + hi) / 2u;
        uvec2 there = scene.lights.at[instance.light_first + mid].key;
        if (there.y < key.y || (there.y == key.y && there.x <= key.x)) lo = mid;
        else hi = mid;
    }
    uint index = instance.light_first + lo;
    return scene.lights.at[index].key == key ? index : NONE;
}

// Density with which sample_light(from) would have found a point of an emissive surface, `distance` along `direction`.
FN float light_pdf(const_in(SceneView) scene, uint index, vec3 from, vec3 direction, float distance) {
    if (index == NONE) return 0.0f;
    RECORD(Light) light = scene.lights.at[index];
    float p = scene.light_table.at[index].probability;
    if (light.kind == LIGHT_SPHERE) {
        vec3 to = light.position - from;
        float d2 = dot(to, to);
        if (d2 <= sqr(light.radius) * 1.00001f) {
            if (light.two_sided == 0u) return 0.0f;
            vec3 n = (distance * direction - to) / light.radius;
            return p * sqr(distance) / max(abs(dot(direction, n)) * light.area, 1.0e-20f);
        }
        return p / (2.0f * PI * sphere_one_minus_cos(light.radius, d2));
    }
    float cosine = -dot(direction, light.direction);
    if (light.two_sided != 0u) cosine = abs(cosine);
    if (!(cosine > 1.0e-6f)) return 0.0f;
    return p * sqr(distance) / (cosine * light.area);
}

// Whether a direction meets the disc of a directional light.
FN bool directional_seen(const_in(Light) light, vec3 direction) {
    vec3 axis = -light.direction;
    vec3 difference = direction - axis;  // chord: stable for small angles
    return light.radius > 0.0f && dot(difference, difference) <= 2.0f * disc_one_minus_cos(light.radius);
}

KERNELS_END
#endif
