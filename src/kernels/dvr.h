#ifndef SPINEL_KERNELS_DVR_H
#define SPINEL_KERNELS_DVR_H
// `dvr`: direct volume rendering: the values of one grid through a transfer function, front to back in even steps;
// besides, the greatest or the mean value along a ray, and the surface of one value. Surfaces of the scene are seen
// where rays reach them, plainly lit.
//
// Here every step is taken; what leaps over emptiness and takes eight rays at once stands in devices/cpu/dvr_*.cpp and
// is tested against this.
#include "density.h"
#include "device.h"
#include "preview_shade.h"
#include "transfer.h"
KERNELS_BEGIN

const uint MAX_DVR_STEPS = 65536u;
const float DVR_OPAQUE = 1.0f / 1024.0f;  // what is left of the light behind which nothing is asked
const float DVR_FAINT = 1.0f / 4096.0f;   // a step with less opacity is not shaded, nor looked at
const uint DVR_BISECTIONS = 16u;

// The part of a ray that lies in what is shown; empty if begin ≥ end. In units of the ray, whose direction is unit.
struct DvrSpan {
    float begin;
    float end;
    vec3 origin;  // in index space
    vec3 direction;
};

FN DvrSpan dvr_span(const_in(SceneView) scene, const_in(DvrSettings) s, Ray ray, float t_end) {
    RECORD(Medium) m = scene.media.at[s.medium];
    DvrSpan span;
    span.origin = m.world_to_grid * vec4(ray.origin, 1.0f);
    span.direction = m.world_to_grid * vec4(ray.direction, 0.0f);
    span.begin = 0.0f;
    span.end = t_end;
    for (int a = 0; a < 3; ++a) {
        float o = span.origin[a];
        float d = span.direction[a];
        if (d == 0.0f) {
            if (o < s.clip_lower[a] || o > s.clip_upper[a]) span.end = -1.0f;
        } else {
            float t0 = (s.clip_lower[a] - o) / d;
            float t1 = (s.clip_upper[a] - o) / d;
            span.begin = max(span.begin, min(t0, t1));
            span.end = min(span.end, max(t0, t1));
        }
    }
    for (uint i = 0u; i < s.plane_count; ++i) {
        vec3 n = vec3(s.planes[i].x, s.planes[i].y, s.planes[i].z);
        float height = dot(n, ray.origin) - s.planes[i].w;  // > 0: cut away
        float rate = dot(n, ray.direction);
        if (rate == 0.0f) {
            if (height > 0.0f) span.end = -1.0f;
        } else if (rate > 0.0f) {
            span.end = min(span.end, -height / rate);
        } else {
            span.begin = max(span.begin, -height / rate);
        }
    }
    return span;
}

// p in index space.
FN float dvr_value(const_in(SceneView) scene, const_in(Medium) m, vec3 p) {
    RECORD(DensityGrid) grid = scene.grids.at[m.grid];
    // Within the box also by the last bit, outside of which there is nothing.
    vec3 inside = clamp(p, vec3(0.0f), vec3(grid.size) * ONE_MINUS_EPSILON);
    return grid_density(scene, grid, inside);
}

// Towards greater values, world space; central differences of a voxel to each side.
FN vec3 dvr_gradient(const_in(SceneView) scene, const_in(Medium) m, vec3 p) {
    vec3 g = vec3(dvr_value(scene, m, p + vec3(1.0f, 0.0f, 0.0f)) - dvr_value(scene, m, p - vec3(1.0f, 0.0f, 0.0f)),
                  dvr_value(scene, m, p + vec3(0.0f, 1.0f, 0.0f)) - dvr_value(scene, m, p - vec3(0.0f, 1.0f, 0.0f)),
                  dvr_value(scene, m, p + vec3(0.0f, 0.0f, 1.0f)) - dvr_value(scene, m, p - vec3(0.0f, 0.0f, 1.0f)));
    return g * mat3(m.world_to_grid);
}

// Factor of the colour, and the highlight that is added to it: Blinn 1977, lit on both sides.
FN vec2 dvr_light(const_in(DvrSettings) s, vec3 gradient, vec3 direction) {
    float square = dot(gradient, gradient);
    if (s.shaded == 0u || !(square > 1.0e-30f)) return vec2(1.0f, 0.0f);
    vec3 n = gradient * inversesqrt(square);
    vec3 l = s.headlight != 0u ? -direction : s.to_light;
    vec3 h = l - direction;
    float diffuse = abs(dot(n, l));
    float half_square = dot(h, h);
    float highlight = half_square > 0.0f ? abs(dot(n, h)) * inversesqrt(half_square) : 0.0f;
    return vec2(s.ambient + s.diffuse * diffuse, s.specular * pow(highlight, s.shininess));
}

// How far towards the light the volume is looked at from a place in world space: what planes cut away casts no shadow.
FN float dvr_light_way(const_in(DvrSettings) s, vec3 world, vec3 to_light) {
    float way = s.shadow_reach;
    for (uint i = 0u; i < s.plane_count; ++i) {
        vec3 n = vec3(s.planes[i].x, s.planes[i].y, s.planes[i].z);
        float rate = dot(n, to_light);
        if (rate > 0.0f) way = min(way, (s.planes[i].w - dot(n, world)) / rate);
    }
    return way;
}

// Part of the light that reaches p, the same place in index space, through the volume, as far as the settings let it
// take any.
FN float dvr_shadow(const_in(SceneView) scene, const_in(DvrSettings) s, const_in(Medium) m, vec3 world, vec3 p,
                    vec3 direction) {
    if (!(s.shadow > 0.0f)) return 1.0f;
    vec3 l = s.headlight != 0u ? -direction : s.to_light;
    vec3 along = m.world_to_grid * vec4(l, 0.0f);
    float way = dvr_light_way(s, world, l);
    float step = 2.0f * s.voxel;
    float depth = 0.0f;
    for (uint i = 1u; i < MAX_DVR_STEPS; ++i) {  // begins two voxels away: the sample's own layer is no shadow
        float t = float(i) * step;
        if (t > way || depth > 8.0f) break;
        vec3 q = p + t * along;
        bool inside = true;
        for (int a = 0; a < 3; ++a)
            if (q[a] < s.clip_lower[a] || q[a] > s.clip_upper[a]) inside = false;
        if (!inside) break;
        depth += transfer_at(scene, s, transfer_place(s, dvr_value(scene, m, q))).w * step;
    }
    return 1.0f - s.shadow * (1.0f - exp(-depth));
}

// Light that the volume sends, and what is left of the light from behind.
struct DvrSeen {
    vec3 color;
    float left;
    float depth;  // where it is first seen well: half of the light is gone; 0: nowhere
    vec3 normal;
    bool bound_reached;
};

// The colour of a place along the ray as it is lit there.
FN vec3 dvr_lit(const_in(SceneView) scene, const_in(DvrSettings) s, const_in(Medium) m, Ray ray, const_in(DvrSpan) span,
                float t, vec3 color, inout(vec3) gradient) {
    vec3 p = span.origin + t * span.direction;
    float shadow = dvr_shadow(scene, s, m, ray_at(ray, t), p, ray.direction);
    if (s.shaded == 0u) return color * shadow;
    gradient = dvr_gradient(scene, m, p);
    vec2 light = dvr_light(s, gradient, ray.direction);
    return (color * light.x + vec3(light.y)) * shadow;
}

FN DvrSeen dvr_nothing() { return DvrSeen(vec3(0.0f), 1.0f, 0.0f, vec3(0.0f), false); }

FN DvrSeen dvr_composite(const_in(SceneView) scene, const_in(DvrSettings) s, Ray ray, const_in(DvrSpan) span,
                         float start) {
    RECORD(Medium) m = scene.media.at[s.medium];
    DvrSeen seen = dvr_nothing();
    // Samples stand at whole steps from the camera, so neighbouring rays look at like depths.
    float first = ceil(span.begin / s.step - start);
    float x0 = 0.0f;
    for (uint i = 0u; i < MAX_DVR_STEPS; ++i) {
        float t = (first + float(i) + start) * s.step;
        if (t > span.end) return seen;
        float x1 = transfer_place(s, dvr_value(scene, m, span.origin + t * span.direction));
        if (i > 0u) {
            vec4 mean = transfer_between(scene, s, x0, x1);
            float opacity = 1.0f - exp(-mean.w * s.step);
            if (opacity > DVR_FAINT) {
                vec3 gradient = vec3(0.0f);
                vec3 color =
                    dvr_lit(scene, s, m, ray, span, t - 0.5f * s.step, vec3(mean.x, mean.y, mean.z) / mean.w, gradient);
                seen.color += seen.left * opacity * color;
                float before = seen.left;
                seen.left *= 1.0f - opacity;
                if (before > 0.5f && seen.left <= 0.5f) {
                    seen.depth = t;
                    seen.normal = normalize_any(-gradient);
                }
                if (seen.left < DVR_OPAQUE) {
                    seen.left = 0.0f;
                    return seen;
                }
            }
        }
        x0 = x1;
    }
    seen.bound_reached = true;
    return seen;
}

// The greatest or the mean value, shown in the colour of its entry as far as it is opaque.
FN DvrSeen dvr_projection(const_in(SceneView) scene, const_in(DvrSettings) s, const_in(DvrSpan) span, float start) {
    RECORD(Medium) m = scene.media.at[s.medium];
    DvrSeen seen = dvr_nothing();
    float first = ceil(span.begin / s.step - start);
    float greatest = -INFINITE;
    float sum = 0.0f;
    uint count = 0u;
    seen.bound_reached = true;
    for (uint i = 0u; i < MAX_DVR_STEPS; ++i) {
        float t = (first + float(i) + start) * s.step;
        if (t > span.end) {
            seen.bound_reached = false;
            break;
        }
        float value = dvr_value(scene, m, span.origin + t * span.direction);
        if (value > greatest) {
            greatest = value;
            if (s.mode == DVR_MAXIMUM) seen.depth = t;
        }
        sum += value;
        count += 1u;
    }
    if (count == 0u) return seen;
    vec4 row = transfer_at(scene, s, transfer_place(s, s.mode == DVR_MAXIMUM ? greatest : sum / float(count)));
    if (!(row.w > 0.0f)) {
        seen.depth = 0.0f;
        return seen;
    }
    seen.left = 0.0f;
    seen.color = vec3(row.x, row.y, row.z) / row.w;
    return seen;
}

// The first place where the value crosses `iso`: between two samples on either side of it, halved until it is a point.
FN DvrSeen dvr_isosurface(const_in(SceneView) scene, const_in(DvrSettings) s, Ray ray, const_in(DvrSpan) span,
                          float start) {
    RECORD(Medium) m = scene.media.at[s.medium];
    DvrSeen seen = dvr_nothing();
    float first = ceil(span.begin / s.step - start);
    float t0 = span.begin;
    bool above0 = false;
    for (uint i = 0u; i < MAX_DVR_STEPS; ++i) {
        float t1 = i == 0u ? span.begin : min((first + float(i - 1u) + start) * s.step, span.end);
        bool above1 = dvr_value(scene, m, span.origin + t1 * span.direction) >= s.iso;
        if (i == 0u ? above1 : above1 != above0) {
            if (i > 0u)
                for (uint k = 0u; k < DVR_BISECTIONS; ++k) {
                    float t = 0.5f * (t0 + t1);
                    if ((dvr_value(scene, m, span.origin + t * span.direction) >= s.iso) == above0) t0 = t;
                    else t1 = t;
                }
            vec3 gradient = vec3(0.0f);
            seen.color = dvr_lit(scene, s, m, ray, span, t1, s.iso_color, gradient);
            seen.left = 0.0f;
            seen.depth = t1;
            seen.normal = normalize_any(-gradient);
            return seen;
        }
        if (t1 >= span.end) return seen;
        t0 = t1;
        above0 = above1;
    }
    seen.bound_reached = true;
    return seen;
}

// A surface of the scene in the light that the volume has.
FN vec3 dvr_surface(const_in(SceneView) scene, const_in(DvrSettings) s, const_in(PreviewView) view) {
    vec3 l = s.headlight != 0u ? -view.ray.direction : s.to_light;
    return surface_emission(scene, view.surface) +
           view.albedo * (s.ambient + s.diffuse * max(dot(view.frame.z, l), 0.0f));
}

// What a pixel shows of the volume and of what lies behind it.
FN PixelSample dvr_sample(const_in(SceneView) scene, const_in(DvrSettings) s, const_in(PreviewView) view,
                          const_in(DvrSeen) seen) {
    vec3 behind = view.found ? dvr_surface(scene, s, view) : s.background;
    FirstHit first = FirstHit(vec3(0.0f), 0.0f, vec3(0.0f), NONE);
    if (seen.depth > 0.0f) {
        first.normal = seen.normal;
        first.depth = seen.depth;
        first.albedo = clamp(seen.color, vec3(0.0f), vec3(1.0f));
    } else if (view.found) {
        first = FirstHit(view.frame.z, view.distance, view.albedo, scene.instances.at[view.surface.instance].object);
    }
    return PixelSample(seen.color + seen.left * behind, first, seen.bound_reached || view.bound_reached);
}

FN PixelSample dvr(const_in(SceneView) scene, const_in(DvrSettings) s, Ray ray, const_in(Hit) hit, Sampler numbers) {
    PreviewView view = preview_view(scene, ray, hit);
    DvrSeen seen = dvr_nothing();
    if (s.medium != NONE) {
        DvrSpan span = dvr_span(scene, s, ray, view.found ? view.distance : INFINITE);
        float start = s.jitter != 0u ? sampler_1d(numbers) : 0.0f;
        if (span.begin < span.end) {
            if (s.mode == DVR_COMPOSITE) seen = dvr_composite(scene, s, ray, span, start);
            else if (s.mode == DVR_ISOSURFACE) seen = dvr_isosurface(scene, s, ray, span, start);
            else seen = dvr_projection(scene, s, span, start);
        }
    }
    return dvr_sample(scene, s, view, seen);
}

KERNELS_END
#endif
