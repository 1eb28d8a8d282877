#ifndef SPINEL_KERNELS_CONSTANTS_H
#define SPINEL_KERNELS_CONSTANTS_H
#include "portable.h"
KERNELS_BEGIN

const float PI = 3.14159265358979323846f;
const float INV_PI = 0.31830988618379067154f;
const float INFINITE = 3.0e38f;               // "no hit": finite, since infinities are not portable between devices
const float ONE_MINUS_EPSILON = 0.99999994f;  // the largest float below 1
const float ROUNDING_ERROR = 9.5367432e-7f;  // of a position, relative to its largest term: 2⁻²⁰, 16 units of rounding
const uint NONE = 0xffffffffu;               // no index

FN float luminance(vec3 c) { return dot(c, vec3(0.2126f, 0.7152f, 0.0722f)); }  // Rec.709
FN float max_component(vec3 v) { return max(v.x, max(v.y, v.z)); }
FN float min_component(vec3 v) { return min(v.x, min(v.y, v.z)); }
FN float average(vec3 v) { return (v.x + v.y + v.z) * (1.0f / 3.0f); }
FN bool is_black(vec3 v) { return v.x == 0.0f && v.y == 0.0f && v.z == 0.0f; }
FN float sqr(float x) { return x * x; }
// Unit vector of a nonzero one whose square may leave a float's range.
FN vec3 normalize_any(vec3 v) {
    float square = dot(v, v);
    if (square > 1.0e-30f && square < 1.0e30f) return v * inversesqrt(square);
    return normalize(v / max(max(abs(v.x), max(abs(v.y), abs(v.z))), 1.0e-37f));
}
FN float safe_sqrt(float x) { return sqrt(max(x, 0.0f)); }
// Component by index; GLSL and C++ both index vectors, but a constant path is kinder to registers.
FN float component(vec3 v, uint i) { return i == 0u ? v.x : (i == 1u ? v.y : v.z); }

KERNELS_END
#endif
