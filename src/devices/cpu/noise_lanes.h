#pragma once
// kernels/noise.h for eight points at once; the same values to rounding.

#include "devices/cpu/lanes.h"
#include "kernels/noise.h"

namespace spinel {

struct Vec8 {
    Float8 x, y, z;
};

inline Uint8 hash8(Uint8 x) {
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0x735a2d97u;
    x ^= x >> 15;
    return x;
}

inline Float8 lattice8(Uint8 key) { return to_float(Int8(hash8(key) >> 8)) * 1.1920928955078125e-7f - 1.0f; }

inline Float8 quintic8(Float8 t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }

// Coordinates have to fit an int.
inline Float8 value_noise8(const Vec8& p) {
    const Float8 bx = floor8(p.x), by = floor8(p.y), bz = floor8(p.z);
    const Float8 wx = quintic8(p.x - bx), wy = quintic8(p.y - by), wz = quintic8(p.z - bz);
    const Uint8 x0 = Uint8(to_int(bx)) * 0x8da6b343u, x1 = x0 + 0x8da6b343u;
    const Uint8 y0 = Uint8(to_int(by)) * 0xd8163841u, y1 = y0 + 0xd8163841u;
    const Uint8 z0 = Uint8(to_int(bz)) * 0xcb1ab31fu, z1 = z0 + 0xcb1ab31fu;
    const Uint8 y0z0 = y0 + z0, y1z0 = y1 + z0, y0z1 = y0 + z1, y1z1 = y1 + z1;
    const Float8 x00 = mix8(lattice8(x0 + y0z0), lattice8(x1 + y0z0), wx);
    const Float8 x10 = mix8(lattice8(x0 + y1z0), lattice8(x1 + y1z0), wx);
    const Float8 x01 = mix8(lattice8(x0 + y0z1), lattice8(x1 + y0z1), wx);
    const Float8 x11 = mix8(lattice8(x0 + y1z1), lattice8(x1 + y1z1), wx);
    return mix8(mix8(x00, x10, wy), mix8(x01, x11, wy), wz);
}

inline Float8 fbm_noise8(Vec8 p, std::uint32_t octaves) {
    const std::uint32_t count = octaves < 1                          ? 1
                                : octaves > kernels::FBM_MAX_OCTAVES ? kernels::FBM_MAX_OCTAVES
                                                                     : octaves;
    Float8 sum = splat(0.0f);
    float amplitude = 1, total = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        sum += amplitude * value_noise8(p);
        total += amplitude;
        amplitude *= 0.5f;
        p = {2.0f * p.x + 17.17f, 2.0f * p.y + 31.73f, 2.0f * p.z + 5.39f};
    }
    return sum / total;
}

}  // namespace spinel
