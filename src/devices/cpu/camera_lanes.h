#pragma once
// The sampler of kernels/random.h, the same bits, and the rays of kernels/camera.h, the same to rounding, for eight
// samples at once.

#include "devices/cpu/noise_lanes.h"
#include "kernels/camera.h"
#include "kernels/random.h"

namespace spinel {

struct RayLanes {
    Vec8 origin, direction;

    Vec8 at(Float8 t) const {
        return {origin.x + t * direction.x, origin.y + t * direction.y, origin.z + t * direction.z};
    }
};

struct SamplerLanes {
    Uint8 pixel_hash, reversed_index;
    std::uint32_t dimension = 0;
};

inline Uint8 splat(std::uint32_t x) { return Uint8{x, x, x, x, x, x, x, x}; }

inline Uint8 reverse_bits8(Uint8 x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

inline Uint8 hash_combine8(Uint8 hash, Uint8 value) {
    return hash8(hash ^ (value + 0x9e3779b9u + (hash << 6) + (hash >> 2)));
}

inline Uint8 laine_karras8(Uint8 x, Uint8 seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

inline Uint8 sobol_reversed_8(Uint8 index) {
    index ^= (index >> 1) & 0x55555555u;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 8) & 0x00ff00ffu;
    index ^= (index >> 16) & 0x0000ffffu;
    return index;
}

inline Float8 unit_float8(Uint8 x) { return to_float(Int8(x >> 8)) * 5.9604644775390625e-8f; }

inline SamplerLanes make_sampler8(Uint8 x, Uint8 y, Uint8 index, std::uint32_t seed) {
    const Uint8 hash = splat(kernels::hash_uint(seed ^ 0x5f356495u));
    return {hash_combine8(hash_combine8(hash, x), y), reverse_bits8(index)};
}

inline Float8 sampler_1d8(SamplerLanes& s) {
    const Uint8 hash = hash8(s.pixel_hash + s.dimension++ * 0x9e3779b9u);
    const Uint8 index = reverse_bits8(laine_karras8(s.reversed_index, hash));
    return unit_float8(reverse_bits8(laine_karras8(index, hash * 0x85ebca6bu + 0x68bc21ebu)));
}

struct Pair8 {
    Float8 x, y;
};
inline Pair8 sampler_2d8(SamplerLanes& s) {
    const Uint8 hash = hash8(s.pixel_hash + s.dimension++ * 0x9e3779b9u);
    const Uint8 index = reverse_bits8(laine_karras8(s.reversed_index, hash));
    const Uint8 x = laine_karras8(index, hash * 0x85ebca6bu + 0x68bc21ebu);
    const Uint8 y = laine_karras8(sobol_reversed_8(index), hash * 0xc2b2ae35u + 0x02e5be93u);
    return {unit_float8(reverse_bits8(x)), unit_float8(reverse_bits8(y))};
}

// Of a camera without a lens; the caller has seen to that.
inline RayLanes camera_rays8(const kernels::Camera& camera, Uint8 x, Uint8 y, Pair8 u) {
    const auto offset = [&](Float8 at) {
        if (camera.filter_kind == kernels::PIXEL_FILTER_BOX) return camera.filter_radius * (2.0f * at - 1.0f);
        for (int i = 0; i < 8; ++i)
            at[i] = kernels::sample_pixel_filter(camera.filter_kind, camera.filter_radius, at[i]);
        return at;
    };
    const Float8 film_x = to_float(Int8(x)) + 0.5f + offset(u.x), film_y = to_float(Int8(y)) + 0.5f + offset(u.y);
    const float width = float(camera.resolution.x), height = float(camera.resolution.y);
    const Float8 px = (film_x * (2.0f / width) - 1.0f) * (width / height * camera.half_height);
    const Float8 py = (1.0f - film_y * (2.0f / height)) * camera.half_height;
    const bool flat = camera.kind == kernels::CAMERA_ORTHOGRAPHIC;
    const glm::vec3 a = camera.camera_to_world[0], b = camera.camera_to_world[1], c = camera.camera_to_world[2],
                    o = camera.camera_to_world[3];
    const auto across = [&](int axis) { return px * a[axis] + py * b[axis]; };
    const auto origin = [&](int axis) { return flat ? across(axis) + o[axis] : splat(o[axis]); };
    const auto direction = [&](int axis) { return flat ? splat(-c[axis]) : across(axis) - c[axis]; };
    RayLanes rays = {{origin(0), origin(1), origin(2)}, {direction(0), direction(1), direction(2)}};
    Vec8& d = rays.direction;
    const Float8 scale = 1.0f / square_root(d.x * d.x + d.y * d.y + d.z * d.z);
    d = {d.x * scale, d.y * scale, d.z * scale};
    return rays;
}

}  // namespace spinel
