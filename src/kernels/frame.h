#ifndef SPINEL_KERNELS_FRAME_H
#define SPINEL_KERNELS_FRAME_H
// Orthonormal frames, to carry directions between the world and the local space of a surface (z is its
// normal).
#include "constants.h"
KERNELS_BEGIN

struct Frame {
    vec3 x;
    vec3 y;
    vec3 z;
};

// Any frame about a unit vector, without a branch and without a singular direction.
// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
FN Frame make_frame(vec3 z) {
    float s = z.z < 0.0f ? -1.0f : 1.0f;
    float a = -1.0f / (s + z.z);
    float b = z.x * z.y * a;
    return Frame(vec3(1.0f + s * z.x * z.x * a, s * b, -s * z.x), vec3(b, s + z.y * z.y * a, -z.y), z);
}

// A frame whose x lies along the tangent as far as it is perpendicular to z; any frame where the tangent is
// useless.
FN Frame make_frame_along(vec3 z, vec3 tangent) {
    vec3 x = tangent - dot(tangent, z) * z;
    float length_squared = dot(x, x);
    if (!(length_squared > 1e-8f * dot(tangent, tangent))) return make_frame(z);
    x *= inversesqrt(length_squared);
    x = normalize(x - dot(x, z) * z);  // again: a tangent close to z left few digits
    return Frame(x, cross(z, x), z);
}

FN vec3 to_local(const_in(Frame) frame, vec3 v) { return vec3(dot(v, frame.x), dot(v, frame.y), dot(v, frame.z)); }
FN vec3 to_world(const_in(Frame) frame, vec3 v) { return v.x * frame.x + v.y * frame.y + v.z * frame.z; }

KERNELS_END
#endif
