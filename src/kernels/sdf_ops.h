#ifndef SPINEL_KERNELS_SDF_OPS_H
#define SPINEL_KERNELS_SDF_OPS_H
// The instructions of an SDF tape, and the shapes they evaluate: distances and their analytic gradients.
//
// A tape works on two register files: points (vec3) and values (float). Point register 0 holds the point that
// is asked for. An instruction writes register `target`; `a` and `b` are what it reads: P[i] is a point
// register, V[i] a value register. Shapes read P[a] − data1.xyz, so that a translated shape is one
// instruction.
//
// Distances of the shapes after Hart, "Sphere tracing: a geometric method for the antialiased ray tracing of
// implicit surfaces", The Visual Computer 12, 1996, and Quilez, "Distance functions", iquilezles.org.
// Negative inside.
#include "constants.h"
KERNELS_BEGIN

const uint SDF_POINT_REGISTERS = 16u;
const uint SDF_VALUE_REGISTERS = 32u;

// Points: P[target] from P[a].
const uint SDF_OP_SIMILARITY = 0u;  // data1.w · rotate(quaternion data0, P[a]) + data1.xyz
const uint SDF_OP_TWIST = 1u;       // about y by data0.x radians per unit of y
const uint SDF_OP_ELONGATE = 2u;    // P[a] − clamp(P[a], −data0.xyz, data0.xyz)
// Into a cell of a lattice: periods data0.xyz, cells −data1.xyz … data1.xyz. data0.w holds six bits: by axis
// (1, 2, 4) the upper of the two nearest cells, else the lower; or (8, 16, 32) simply the nearest.
const uint SDF_OP_REPEAT = 3u;

// Shapes: V[target] from P[a] − data1.xyz.
const uint SDF_OP_SPHERE = 4u;    // radius data0.x
const uint SDF_OP_BOX = 5u;       // half edges data0.xyz, grown all around by data0.w
const uint SDF_OP_TORUS = 6u;     // about y: radius data0.x of the ring, data0.y of the tube
const uint SDF_OP_CYLINDER = 7u;  // along y: radius data0.x, half height data0.y
const uint SDF_OP_PLANE = 8u;     // unit normal data0.xyz, solid where dot(normal, p) < data0.w
const uint SDF_OP_GYROID = 9u;    // |gyroid(data0.x · p)| · data0.y − data0.z

// Values: V[target] from V[a] and V[b].
const uint SDF_OP_MIN = 10u;         // union
const uint SDF_OP_MAX = 11u;         // intersection
const uint SDF_OP_SUBTRACT = 12u;    // max(V[a], −V[b])
const uint SDF_OP_SMOOTH_MIN = 13u;  // blended over |V[a] − V[b]| < data0.x
const uint SDF_OP_SMOOTH_MAX = 14u;
const uint SDF_OP_SMOOTH_SUBTRACT = 15u;  // smooth max(V[a], −V[b])
const uint SDF_OP_MULTIPLY = 16u;         // V[a] · data0.x
const uint SDF_OP_OFFSET = 17u;           // V[a] − data0.x
const uint SDF_OP_SHELL = 18u;            // |V[a]| − data0.x
const uint SDF_OP_DISPLACE = 19u;         // V[a] + data0.x · sin·sin·sin(data0.y · P[b])
// min(V[a], max(data0.w, data1.w · distance of P[b] to the box of centre data0.xyz and half edges
// data1.xyz)): what a part is worth at least outside of its bounds stands in for the part itself. See
// geometry/sdf/sdf_analysis.h.
const uint SDF_OP_FAR = 20u;

// Branch and bound. If P[b] is outside of a box (centre data0.xyz, half edges data1.xyz) and all that the
// next `target` instructions would fold into V[a] is worth too much to count, they are skipped: the result is
// the same, exactly.
const uint SDF_OP_SKIP_UNION = 21u;     // they fold by (smooth) minimum: distance · data1.w ≥ data0.w + V[a]
const uint SDF_OP_SKIP_SUBTRACT = 22u;  // they are subtracted: distance · data1.w ≥ data0.w − V[a]

// V[target] from P[a] in the index space of the grid whose number stands at `b` in SceneView::words (sdf_grid.h): near
// the surface data0.y · (its value − data0.x), elsewhere not more than the distance.
const uint SDF_OP_GRID = 23u;

FN vec3 sdf_rotate(vec4 q, vec3 p) {
    vec3 axis = vec3(q.x, q.y, q.z);
    return p + 2.0f * cross(axis, cross(axis, p) + q.w * p);
}

FN vec3 sdf_twist(vec3 p, float rate) {
    float angle = rate * p.y;
    float c = cos(angle);
    float s = sin(angle);
    return vec3(c * p.x - s * p.z, p.y, s * p.x + c * p.z);
}

// The lattice's cell indices lie in −extent … extent: whole numbers for an odd count of cells, halves for an
// even one.
FN vec3 sdf_repeat(vec3 p, vec4 period_bits, vec3 extent) {
    vec3 period = vec3(period_bits.x, period_bits.y, period_bits.z);
    uint bits = uint(period_bits.w);
    vec3 odd = extent - floor(extent);
    vec3 upper = vec3(float(bits & 1u), float((bits >> 1) & 1u), float((bits >> 2) & 1u));
    vec3 nearest = vec3(float((bits >> 3) & 1u), float((bits >> 4) & 1u), float((bits >> 5) & 1u));
    vec3 cell = floor(p / period + odd + 0.5f * nearest) + upper - odd;
    return p - period * clamp(cell, -extent, extent);
}

// v / |v|, zero where v is.
FN vec3 sdf_unit(vec3 v) {
    float l = length(v);
    return l > 0.0f ? v / l : vec3(0.0f);
}
FN float sdf_sign(float x) { return x < 0.0f ? -1.0f : 1.0f; }

// Each shape twice: the distance, and (gradient, distance).
FN float sdf_box(vec3 p, vec3 half_edges) {
    vec3 q = abs(p) - half_edges;
    return length(max(q, vec3(0.0f))) + min(max_component(q), 0.0f);
}
FN vec4 sdf_box_gradient(vec3 p, vec3 half_edges) {
    vec3 q = abs(p) - half_edges;
    vec3 outside = max(q, vec3(0.0f));
    vec3 g;
    if (outside.x + outside.y + outside.z > 0.0f) {
        g = sdf_unit(outside);
    } else {
        g = q.x >= q.y && q.x >= q.z ? vec3(1.0f, 0.0f, 0.0f)
                                     : (q.y >= q.z ? vec3(0.0f, 1.0f, 0.0f) : vec3(0.0f, 0.0f, 1.0f));
    }
    g = g * vec3(sdf_sign(p.x), sdf_sign(p.y), sdf_sign(p.z));
    return vec4(g, length(outside) + min(max_component(q), 0.0f));
}

FN float sdf_torus(vec3 p, float ring, float tube) { return length(vec2(length(vec2(p.x, p.z)) - ring, p.y)) - tube; }
FN vec4 sdf_torus_gradient(vec3 p, float ring, float tube) {
    float radius = length(vec2(p.x, p.z));
    vec3 g = sdf_unit(vec3(radius - ring, p.y, 0.0f));
    float slope = radius > 0.0f ? g.x / radius : 0.0f;
    return vec4(slope * p.x, g.y, slope * p.z, length(vec2(radius - ring, p.y)) - tube);
}

FN float sdf_cylinder(vec3 p, float radius, float half_height) {
    vec2 q = vec2(length(vec2(p.x, p.z)) - radius, abs(p.y) - half_height);
    return length(max(q, vec2(0.0f))) + min(max(q.x, q.y), 0.0f);
}
FN vec4 sdf_cylinder_gradient(vec3 p, float radius, float half_height) {
    float r = length(vec2(p.x, p.z));
    vec2 q = vec2(r - radius, abs(p.y) - half_height);
    vec2 outside = max(q, vec2(0.0f));
    float l = length(outside);
    vec2 g = l > 0.0f ? outside / l : (q.x >= q.y ? vec2(1.0f, 0.0f) : vec2(0.0f, 1.0f));
    float slope = r > 0.0f ? g.x / r : 0.0f;
    return vec4(slope * p.x, g.y * sdf_sign(p.y), slope * p.z, l + min(max(q.x, q.y), 0.0f));
}

// Schoen's gyroid (NASA TN D-5541, 1970) in its trigonometric form sin x cos y + sin y cos z + sin z cos x,
// whose gradient is at most √3 long: by Cauchy–Schwarz each component squared is at most cos² + sin² of two
// of the angles.
FN float sdf_gyroid(vec3 p, vec4 d) {
    vec3 q = d.x * p;
    vec3 s = sin(q);
    vec3 c = cos(q);
    return abs(s.x * c.y + s.y * c.z + s.z * c.x) * d.y - d.z;
}
FN vec4 sdf_gyroid_gradient(vec3 p, vec4 d) {
    vec3 q = d.x * p;
    vec3 s = sin(q);
    vec3 c = cos(q);
    float g = s.x * c.y + s.y * c.z + s.z * c.x;
    vec3 slope = vec3(c.x * c.y - s.z * s.x, c.y * c.z - s.x * s.y, c.z * c.x - s.y * s.z);
    return vec4(sdf_sign(g) * d.x * d.y * slope, abs(g) * d.y - d.z);
}

// Polynomial smooth minimum: Evans, "Learning from Failure", SIGGRAPH 2015 Advances in Real-Time Rendering;
// Quilez, "Smooth minimum", iquilezles.org. Never above the minimum, never more than k/4 below it; its
// gradient is a convex combination of the two, so a Lipschitz constant of both is one of the blend.
FN float sdf_smooth_min(float a, float b, float k) {
    float h = max(k - abs(a - b), 0.0f);
    return min(a, b) - h * h / (4.0f * k);
}
FN vec4 sdf_smooth_min_gradient(vec4 a, vec4 b, float k) {
    float h = max(k - abs(a.w - b.w), 0.0f);
    vec4 low = a.w < b.w ? a : b;
    vec4 high = a.w < b.w ? b : a;
    vec4 r = mix(low, high, h / (2.0f * k));
    r.w = low.w - h * h / (4.0f * k);
    return r;
}

KERNELS_END
#endif
