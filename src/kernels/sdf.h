#ifndef SPINEL_KERNELS_SDF_H
#define SPINEL_KERNELS_SDF_H
// Implicit surfaces: the solid is where f < 0, its surface where the sign of f changes.
//
// Evaluation: a tape of SdfOp (sdf_ops.h) over two small register files; gradients by forward-mode
// differentiation, a Jacobian beside every point and a gradient beside every value (Griewank, Walther,
// "Evaluating Derivatives", 2008).
//
// Tracing: sphere tracing (Hart 1996). A step of |f|/L, with L a Lipschitz constant of f, crosses no surface.
// Steps are relaxed beyond that as long as consecutive spheres overlap, so none is skipped (Keinert et al.,
// "Enhanced Sphere Tracing", STAG 2014). A hit is a change of sign, bracketed and refined to the precision of
// floats; how small |f| is decides nothing. So a ray that starts just inside of a glass solid walks to its
// exit, and one that starts just outside does not stick to the surface that it left.
#include "scene_view.h"
#include "sdf_grid.h"
#include "sdf_ops.h"
KERNELS_BEGIN

const uint SDF_MAX_STEPS = 8192u;      // of one march; what happens at the bound: see sdf_crossing
const uint SDF_MAX_REFINEMENTS = 48u;  // of one bracket
const uint SDF_MAX_OFFSETS = 16u;      // doublings (and halvings) of sdf_offset_point
const float SDF_RESOLUTION = 1.0e-6f;  // smallest step, relative to the size and position of the bounds
const float SDF_RELAXATION = 1.2f;

struct SdfPoints {
    vec3 at[SDF_POINT_REGISTERS];
};
struct SdfValues {
    float at[SDF_VALUE_REGISTERS];
};

// f at p, in local space. Sound as a distance after division by Sdf::lipschitz, inside Sdf's bounds.
FN float sdf_distance(const_in(SceneView) scene, uint sdf, vec3 p) {
    SdfPoints points;
    SdfValues values;
    points.at[0] = p;
    uint first = scene.sdfs.at[sdf].op_first;
    uint end = first + scene.sdfs.at[sdf].op_count;
    float value = 0.0f;  // of the latest value instruction: the last one writes the result
    for (uint i = first; i < end; i++) {
        SdfOp op = scene.sdf_ops.at[i];
        vec4 d = op.data0;
        vec3 e = vec3(op.data1.x, op.data1.y, op.data1.z);
        if (op.op <= SDF_OP_REPEAT) {
            vec3 q = points.at[op.a];
            switch (op.op) {
                case SDF_OP_SIMILARITY: q = op.data1.w * sdf_rotate(d, q) + e; break;
                case SDF_OP_TWIST: q = sdf_twist(q, d.x); break;
                case SDF_OP_ELONGATE: q = q - clamp(q, -vec3(d.x, d.y, d.z), vec3(d.x, d.y, d.z)); break;
                case SDF_OP_REPEAT: q = sdf_repeat(q, d, e); break;
            }
            points.at[op.target] = q;
            continue;
        }
        switch (op.op) {
            case SDF_OP_SPHERE: value = length(points.at[op.a] - e) - d.x; break;
            case SDF_OP_BOX: value = sdf_box(points.at[op.a] - e, vec3(d.x, d.y, d.z)) - d.w; break;
            case SDF_OP_TORUS: value = sdf_torus(points.at[op.a] - e, d.x, d.y); break;
            case SDF_OP_CYLINDER: value = sdf_cylinder(points.at[op.a] - e, d.x, d.y); break;
            case SDF_OP_PLANE: value = dot(vec3(d.x, d.y, d.z), points.at[op.a] - e) - d.w; break;
            case SDF_OP_GYROID: value = sdf_gyroid(points.at[op.a] - e, d); break;
            case SDF_OP_GRID: value = sdf_grid(scene, op.b, points.at[op.a], vec2(d.x, d.y)); break;
            case SDF_OP_MIN: value = min(values.at[op.a], values.at[op.b]); break;
            case SDF_OP_MAX: value = max(values.at[op.a], values.at[op.b]); break;
            case SDF_OP_SUBTRACT: value = max(values.at[op.a], -values.at[op.b]); break;
            case SDF_OP_SMOOTH_MIN: value = sdf_smooth_min(values.at[op.a], values.at[op.b], d.x); break;
            case SDF_OP_SMOOTH_MAX: value = -sdf_smooth_min(-values.at[op.a], -values.at[op.b], d.x); break;
            case SDF_OP_SMOOTH_SUBTRACT: value = -sdf_smooth_min(-values.at[op.a], values.at[op.b], d.x); break;
            case SDF_OP_MULTIPLY: value = values.at[op.a] * d.x; break;
            case SDF_OP_OFFSET: value = values.at[op.a] - d.x; break;
            case SDF_OP_SHELL: value = abs(values.at[op.a]) - d.x; break;
            case SDF_OP_DISPLACE: {
                vec3 s = sin(d.y * points.at[op.b]);
                value = values.at[op.a] + d.x * s.x * s.y * s.z;
                break;
            }
            case SDF_OP_FAR: {
                float away = sdf_box(points.at[op.b] - vec3(d.x, d.y, d.z), e);
                value = min(values.at[op.a], max(d.w, op.data1.w * away));
                break;
            }
            case SDF_OP_SKIP_UNION:
            case SDF_OP_SKIP_SUBTRACT: {
                value = values.at[op.a];
                float away = sdf_box(points.at[op.b] - vec3(d.x, d.y, d.z), e);
                float enough = d.w + (op.op == SDF_OP_SKIP_UNION ? value : -value);
                if (away > 0.0f && away * op.data1.w >= enough) i += op.target;
                continue;
            }
        }
        values.at[op.target] = value;
    }
    return value;
}

struct SdfDualPoints {
    vec3 at[SDF_POINT_REGISTERS];
    mat3 jacobian[SDF_POINT_REGISTERS];  // column i: derivative by component i of the point that was asked for
};
struct SdfDualValues {
    vec4 at[SDF_VALUE_REGISTERS];  // gradient, value
};

// (gradient of f, f) at p. At creases, where f has no gradient, that of one side.
FN vec4 sdf_distance_gradient(const_in(SceneView) scene, uint sdf, vec3 p) {
    SdfDualPoints points;
    SdfDualValues values;
    points.at[0] = p;
    points.jacobian[0] = mat3(1.0f);
    uint first = scene.sdfs.at[sdf].op_first;
    uint end = first + scene.sdfs.at[sdf].op_count;
    vec4 value = vec4(0.0f);
    for (uint i = first; i < end; i++) {
        SdfOp op = scene.sdf_ops.at[i];
        vec4 d = op.data0;
        vec3 d3 = vec3(d.x, d.y, d.z);
        vec3 e = vec3(op.data1.x, op.data1.y, op.data1.z);
        if (op.op <= SDF_OP_REPEAT) {
            vec3 q = points.at[op.a];
            mat3 j = points.jacobian[op.a];
            switch (op.op) {
                case SDF_OP_SIMILARITY:
                    q = op.data1.w * sdf_rotate(d, q) + e;
                    j = op.data1.w * mat3(sdf_rotate(d, j[0]), sdf_rotate(d, j[1]), sdf_rotate(d, j[2]));
                    break;
                case SDF_OP_TWIST: {
                    float c = cos(d.x * q.y);
                    float s = sin(d.x * q.y);
                    q = sdf_twist(q, d.x);
                    // Columns: by x, by y (the angle changes too), by z.
                    j = mat3(vec3(c, 0.0f, s), vec3(-d.x * q.z, 1.0f, d.x * q.x), vec3(-s, 0.0f, c)) * j;
                    break;
                }
                case SDF_OP_ELONGATE: {
                    vec3 moves =
                        vec3(abs(q.x) > d.x ? 1.0f : 0.0f, abs(q.y) > d.y ? 1.0f : 0.0f, abs(q.z) > d.z ? 1.0f : 0.0f);
                    q = q - clamp(q, -d3, d3);
                    j = mat3(j[0] * moves, j[1] * moves, j[2] * moves);
                    break;
                }
                case SDF_OP_REPEAT: q = sdf_repeat(q, d, e); break;
            }
            points.at[op.target] = q;
            points.jacobian[op.target] = j;
            continue;
        }
        if (op.op <= SDF_OP_GYROID) {
            vec3 q = points.at[op.a] - e;
            switch (op.op) {
                case SDF_OP_SPHERE: value = vec4(sdf_unit(q), length(q) - d.x); break;
                case SDF_OP_BOX: value = sdf_box_gradient(q, d3) - vec4(0.0f, 0.0f, 0.0f, d.w); break;
                case SDF_OP_TORUS: value = sdf_torus_gradient(q, d.x, d.y); break;
                case SDF_OP_CYLINDER: value = sdf_cylinder_gradient(q, d.x, d.y); break;
                case SDF_OP_PLANE: value = vec4(d3, dot(d3, q) - d.w); break;
                case SDF_OP_GYROID: value = sdf_gyroid_gradient(q, d); break;
            }
            vec3 g = vec3(value.x, value.y, value.z) * points.jacobian[op.a];
            values.at[op.target] = vec4(g, value.w);
            value = values.at[op.target];
            continue;
        }
        if (op.op == SDF_OP_GRID) {
            value = sdf_grid_gradient(scene, op.b, points.at[op.a], vec2(d.x, d.y));
            value = vec4(vec3(value.x, value.y, value.z) * points.jacobian[op.a], value.w);
            values.at[op.target] = value;
            continue;
        }
        vec4 a = values.at[op.a];
        switch (op.op) {
            case SDF_OP_MIN: value = a.w < values.at[op.b].w ? a : values.at[op.b]; break;
            case SDF_OP_MAX: value = a.w > values.at[op.b].w ? a : values.at[op.b]; break;
            case SDF_OP_SUBTRACT: value = a.w > -values.at[op.b].w ? a : -values.at[op.b]; break;
            case SDF_OP_SMOOTH_MIN: value = sdf_smooth_min_gradient(a, values.at[op.b], d.x); break;
            case SDF_OP_SMOOTH_MAX: value = -sdf_smooth_min_gradient(-a, -values.at[op.b], d.x); break;
            case SDF_OP_SMOOTH_SUBTRACT: value = -sdf_smooth_min_gradient(-a, values.at[op.b], d.x); break;
            case SDF_OP_MULTIPLY: value = a * d.x; break;
            case SDF_OP_OFFSET: value = a - vec4(0.0f, 0.0f, 0.0f, d.x); break;
            case SDF_OP_SHELL: value = sdf_sign(a.w) * a - vec4(0.0f, 0.0f, 0.0f, d.x); break;
            case SDF_OP_DISPLACE: {
                vec3 s = sin(d.y * points.at[op.b]);
                vec3 c = cos(d.y * points.at[op.b]);
                vec3 g = d.x * d.y * vec3(c.x * s.y * s.z, s.x * c.y * s.z, s.x * s.y * c.z);
                value = a + vec4(g * points.jacobian[op.b], d.x * s.x * s.y * s.z);
                break;
            }
            case SDF_OP_FAR: {
                vec4 away = op.data1.w * sdf_box_gradient(points.at[op.b] - d3, e);
                if (away.w > d.w) {
                    away = vec4(vec3(away.x, away.y, away.z) * points.jacobian[op.b], away.w);
                } else {
                    away = vec4(0.0f, 0.0f, 0.0f, d.w);
                }
                value = a.w < away.w ? a : away;
                break;
            }
            case SDF_OP_SKIP_UNION:
            case SDF_OP_SKIP_SUBTRACT: {
                value = a;
                float away = sdf_box(points.at[op.b] - d3, e);
                float enough = d.w + (op.op == SDF_OP_SKIP_UNION ? a.w : -a.w);
                if (away > 0.0f && away * op.data1.w >= enough) i += op.target;
                continue;
            }
        }
        values.at[op.target] = value;
    }
    return value;
}

// A ray cut to the bounds of a solid and measured in local length from where it enters: far origins cost no
// precision.
struct SdfSegment {
    vec3 origin;
    vec3 direction;    // unit
    float extent;      // local length; not positive: the ray misses the bounds
    float t_first;     // the ray's t at origin …
    float t_scale;     // … and per unit of length
    float resolution;  // what is thinner than this is below the precision of f
    float longest_crawl;
};

// The part of the ray in (t_min, t_max) inside of the bounds.
FN SdfSegment sdf_clip(const_in(Sdf) sdf, Ray ray, float t_max) {
    SdfSegment segment = SdfSegment(ray.origin, ray.direction, -1.0f, 0.0f, 0.0f, 0.0f, 0.0f);
    float speed = length(ray.direction);
    if (!(speed > 1.0e-18f)) return segment;
    vec3 d = ray.direction;
    float least = 1.0e-12f * speed;  // a zero component, replaced, moves the clip by far less than the bounds' margin
    d.x = abs(d.x) > least ? d.x : least;
    d.y = abs(d.y) > least ? d.y : least;
    d.z = abs(d.z) > least ? d.z : least;
    vec3 to_lower = (sdf.lower - ray.origin) / d;
    vec3 to_upper = (sdf.upper - ray.origin) / d;
    float enter = max_component(min(to_lower, to_upper));
    float leave = min_component(max(to_lower, to_upper));
    // Rounded outwards: 2γ₃, Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013. Outside of its bounds f is
    // positive.
    enter -= 4.0e-7f * abs(enter);
    leave += 4.0e-7f * abs(leave);
    enter = max(enter, ray.t_min);
    leave = min(leave, t_max);
    if (!(enter < leave)) return segment;
    segment.origin = ray_at(ray, enter);
    segment.direction = ray.direction / speed;
    segment.extent = (leave - enter) * speed;
    segment.t_first = enter;
    segment.t_scale = 1.0f / speed;
    float scale = length(sdf.upper - sdf.lower) + max_component(max(abs(sdf.lower), abs(sdf.upper)));
    segment.resolution = SDF_RESOLUTION * scale;
    segment.longest_crawl = max(segment.resolution, min(sdf.longest_crawl, 1000.0f * segment.resolution));
    return segment;
}

// Where a segment first crosses the surface.
struct SdfCrossing {
    float s;  // in the segment's length; of what is not refined: behind it, by less than a step
    bool found;
    bool inside;  // the segment begins inside of the solid
};

// Walks from the segment's start to the first change of sign, and narrows that down if it shall be `refined`.
//  * No step is shorter than the segment's resolution, and a ray that crawls along a surface lengthens its
//  steps
//    slowly. What may be stepped over that way is a pair of crossings nearer to each other than that: in and
//    out again.
//  * A change of sign that is undone within one resolution is noise, as where coplanar faces of a difference
//  cancel.
//  * At the bound on steps the segment's end is asked: if its sign differs, the surface lies between and will
//  be found.
//    So a march finds a crossing exactly if start and end differ, or it passed one on its way: parity never
//    breaks, and a ray inside of a solid always finds its exit, because the bounds lie outside.
//  * It is refined to the precision of the point that f is asked at: regula falsi in the Illinois variant (Dowell,
//    Jarratt, BIT 11, 1971), every third step a bisection so that the bracket shrinks in any case.
//
// f is asked in one place, whatever for: shaders hold a copy of all that f may be for each place where it is asked.
FN_ANEW SdfCrossing sdf_crossing(const_in(SceneView) scene, uint sdf, const_in(SdfSegment) segment, bool refined) {
    float inverse_lipschitz = 1.0f / scene.sdfs.at[sdf].lipschitz;
    float shortest = segment.resolution;
    float relaxation = SDF_RELAXATION;
    bool inside = false;
    float near = 0.0f;  // the sign is that of the start up to here
    float near_value = 0.0f;
    float far = 0.0f;  // and may have changed here
    float far_value = 0.0f;
    float next = 0.0f;  // where f is asked
    uint steps = 0u;
    float radius = 0.0f;
    bool relaxed = false;   // a step farther than is known to be safe
    bool beyond = false;    // a look whether a change of sign lasts
    bool refining = false;  // the surface lies between near and far
    uint refinements = 0u;
    float tolerance = 0.0f;
    int side = 0;
    for (;;) {
        float value = sdf_distance(scene, sdf, segment.origin + next * segment.direction);
        if (refining) {
            if ((value < 0.0f) == inside) {
                near = next;
                near_value = value;
                if (side == 1) far_value *= 0.5f;
                side = 1;
            } else {
                far = next;
                far_value = value;
                if (side == -1) near_value *= 0.5f;
                side = -1;
            }
            ++refinements;
        } else {
            if (steps == 0u) inside = value < 0.0f;
            bool across = (value < 0.0f) != inside;
            // Relaxed too far: the two spheres do not cover the way between their centres.
            if (relaxed && (across || radius + abs(value) * inverse_lipschitz < next - near)) {
                relaxed = false;
                relaxation = 1.0f;
                next = min(near + radius, segment.extent);
                continue;
            }
            if (!beyond) {
                far = next;
                far_value = value;
                beyond = across && next < segment.extent && !(abs(value) * inverse_lipschitz >= segment.resolution);
                if (beyond) {
                    next = min(next + segment.resolution, segment.extent);
                    continue;
                }
            }
            if (!across) {
                near = next;
                near_value = value;
                beyond = false;
                if (near >= segment.extent) return SdfCrossing(near, false, inside);
                ++steps;
                if (steps > SDF_MAX_STEPS) {
                    relaxed = false;
                    next = segment.extent;
                    continue;
                }
                radius = abs(value) * inverse_lipschitz;
                bool crawling = radius < shortest;
                relaxed = !crawling && relaxation > 1.0f;
                next = min(near + (crawling ? shortest : radius * relaxation), segment.extent);
                if (radius < max(shortest, 32.0f * segment.resolution)) {
                    shortest = min(shortest * 1.05f, segment.longest_crawl);
                } else if (radius > 16.0f * shortest) {
                    shortest = segment.resolution;
                }
                continue;
            }
            if (!refined) return SdfCrossing(far, true, inside);
            refining = true;
            vec3 p = segment.origin + far * segment.direction;
            tolerance = 1.2e-7f * (max_component(abs(p)) + far);
        }
        if (refinements == SDF_MAX_REFINEMENTS || !(far - near > tolerance)) break;
        float middle = 0.5f * (near + far);
        next = refinements % 3u == 2u ? middle : near - near_value * ((far - near) / (far_value - near_value));
        if (!(next > near && next < far)) next = middle;
        if (!(next > near && next < far)) break;  // neighbouring floats
    }
    return SdfCrossing(0.5f * (near + far), true, inside);
}

// The nearest surface of the solid in (t_min, min(t_max, hit.t)) replaces the hit, except for hit.instance,
// which is the caller's. The ray is in local space, its direction of any length. The normal points out of the
// solid, and against the ray exactly if the ray enters.
FN void sdf_closest(const_in(SceneView) scene, uint sdf, Ray ray, inout(Hit) hit) {
    float t_max = min(ray.t_max, hit.t);
    SdfSegment segment = sdf_clip(scene.sdfs.at[sdf], ray, t_max);
    if (!(segment.extent > 0.0f)) return;
    SdfCrossing crossing = sdf_crossing(scene, sdf, segment, true);
    if (!crossing.found) return;
    float s = crossing.s;
    // A crossing is not lost because t rounds to t_min.
    float t = max(segment.t_first + s * segment.t_scale, ray.t_min + (1.5e-7f * abs(ray.t_min) + 1.0e-35f));
    if (!(t < t_max)) return;
    vec4 gradient = sdf_distance_gradient(scene, sdf, segment.origin + s * segment.direction);
    vec3 normal = vec3(gradient.x, gradient.y, gradient.z);
    float size = length(normal);
    float towards = crossing.inside ? 1.0f : -1.0f;  // sign of dot(outward normal, direction)
    if (size > 0.0f) {
        normal = normal / size;
        // At grazing incidence and on creases the gradient may disagree with the crossing; mirrored, it
        // agrees.
        float cosine = dot(normal, segment.direction);
        if (cosine * towards < 0.0f) normal = normal - 2.0f * cosine * segment.direction;
    } else {
        normal = towards * segment.direction;
    }
    hit.t = t;
    hit.primitive = 0u;
    hit.face = 0u;
    hit.uv = vec2(0.0f);
    hit.cell = ivec3(0);
    hit.normal = normal;
}

// Whether the surface is crossed anywhere in (t_min, t_max).
FN bool sdf_any(const_in(SceneView) scene, uint sdf, Ray ray) {
    SdfSegment segment = sdf_clip(scene.sdfs.at[sdf], ray, ray.t_max);
    if (!(segment.extent > 0.0f)) return false;
    return sdf_crossing(scene, sdf, segment, false).found;
}

// Where a ray that leaves p should start: p moved along the normal, outwards (side +1) or inwards (side −1),
// by `distance`, or by as many times that (a power of two) as it takes for f to have that side's sign there.
// Where the solid or the gap is thinner than that: by a fraction of it. p moved by `distance` if even that
// fails.
FN vec3 sdf_offset_point(const_in(SceneView) scene, uint sdf, vec3 p, vec3 normal, float side, float distance) {
    vec3 direction = side * sdf_unit(normal);
    float further = distance;
    float nearer = distance;
    for (uint i = 0u; i < SDF_MAX_OFFSETS; i++) {
        vec3 q = p + further * direction;
        if (sdf_distance(scene, sdf, q) * side > 0.0f) return q;
        further *= 2.0f;
        nearer *= 0.5f;
        q = p + nearer * direction;
        if (sdf_distance(scene, sdf, q) * side > 0.0f) return q;
    }
    return p + distance * direction;
}

KERNELS_END
#endif
