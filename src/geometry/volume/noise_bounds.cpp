// Value noise is a product of linear functions of its weights within a cell of the lattice, and weights rise with the
// coordinate: its extremes over a box are at the corners, and the bound is exact but for rounding. Perlin's and simplex
// noise are evaluated in intervals, cell by cell. An octave whose box spans more than a few cells is only known to lie
// in [−1, 1].
#include "geometry/volume/noise_bounds.h"

#include <algorithm>
#include <cmath>

namespace spinel {
namespace {

using glm::ivec3;
using glm::vec3;
using kernels::uint;

constexpr int MAX_CELLS = 3;            // along an axis, beyond which an octave is not looked into
constexpr float ROUNDING = 2e-6f;       // of a sum of a few dozen terms no greater than 2
constexpr float MAX_COORDINATE = 1e6f;  // beyond which floats are too coarse for cells to be told

Interval join(Interval a, Interval b) { return {std::min(a.low, b.low), std::max(a.high, b.high)}; }
Interval sum(Interval a, Interval b) { return {a.low + b.low, a.high + b.high}; }
Interval times(float s, Interval a) {
    return s >= 0 ? Interval{s * a.low, s * a.high} : Interval{s * a.high, s * a.low};
}
Interval product(Interval a, Interval b) {
    const float p[4] = {a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high};
    return {*std::min_element(p, p + 4), *std::max_element(p, p + 4)};
}
Interval square(Interval a) {
    const float l = a.low * a.low, h = a.high * a.high;
    return {a.low <= 0 && a.high >= 0 ? 0.0f : std::min(l, h), std::max(l, h)};
}
// a + w·(b − a) is linear in w: its bounds are those at both ends.
Interval mixed(Interval a, Interval b, Interval w) {
    const auto at = [&](float s) { return sum(times(1 - s, a), times(s, b)); };
    return join(at(w.low), at(w.high));
}

// The gradient's product with offsets from `low` to `high`.
Interval slope(ivec3 corner, vec3 low, vec3 high) {
    const vec3 g = kernels::lattice_gradient(corner);
    Interval total = {0, 0};
    for (int a = 0; a < 3; ++a) total = sum(total, times(g[a], {low[a], high[a]}));
    return total;
}

// Of the lattice noises within one cell, over offsets from `low` to `high` in it. corner(c, offset) bounds what the
// corner adds.
template <class Corner>
Interval blended(vec3 low, vec3 high, const Corner& corner) {
    const vec3 w0 = glm::clamp(kernels::quintic_weights(low), vec3(0), vec3(1));
    const vec3 w1 = glm::clamp(kernels::quintic_weights(high), vec3(0), vec3(1));
    const Interval wx{w0.x, w1.x}, wy{w0.y, w1.y}, wz{w0.z, w1.z};
    const auto row = [&](int y, int z) { return mixed(corner(ivec3(0, y, z)), corner(ivec3(1, y, z)), wx); };
    return mixed(mixed(row(0, 0), row(1, 0), wy), mixed(row(0, 1), row(1, 1), wy), wz);
}

// Over offsets from `low` to `high` in a cell. The corners' slopes share the offset, which intervals do not know of:
// what that costs halves with the box's edges, so Perlin's noise is looked at in eighths.
Interval cell_bounds(uint kind, ivec3 cell, vec3 low, vec3 high) {
    if (kind != kernels::NOISE_PERLIN)
        return blended(low, high, [&](ivec3 c) {
            const float v = kernels::lattice_value(cell + c);
            return Interval{v, v};
        });
    Interval bounds{1, -1};
    const vec3 middle = 0.5f * (low + high);
    for (int part = 0; part < 8; ++part) {
        const glm::bvec3 upper(part & 1, part & 2, part & 4);
        const vec3 from = glm::mix(low, middle, upper), to = glm::mix(middle, high, upper);
        bounds =
            join(bounds, blended(from, to, [&](ivec3 c) { return slope(cell + c, from - vec3(c), to - vec3(c)); }));
    }
    return bounds;
}

Interval lattice_bounds(uint kind, vec3 lower, vec3 upper) {
    const ivec3 first(glm::floor(lower)), last(glm::floor(upper));
    Interval bounds{1, -1};
    for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x) {
                const ivec3 cell(x, y, z);
                const vec3 low = glm::clamp(lower - vec3(cell), 0.0f, 1.0f),
                           high = glm::clamp(upper - vec3(cell), 0.0f, 1.0f);
                const Interval here = cell_bounds(kind, cell, low, high);
                bounds = join(bounds, here);
            }
    return bounds;
}

// Each corner of the skewed lattice that is near enough to the box adds its kernel's interval times its gradient's.
Interval simplex_bounds(vec3 lower, vec3 upper) {
    const float reach = std::sqrt(kernels::SIMPLEX_REACH);
    // In skewed coordinates every corner within reach lies in the box of the skewed, widened box.
    const vec3 low = lower - reach, high = upper + reach;
    const float low_sum = (low.x + low.y + low.z) * kernels::SIMPLEX_SKEW,
                high_sum = (high.x + high.y + high.z) * kernels::SIMPLEX_SKEW;
    const ivec3 first(glm::floor(low + low_sum)), last(glm::ceil(high + high_sum));
    Interval total{0, 0};
    for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x) {
                const ivec3 corner(x, y, z);
                const vec3 at = vec3(corner) - float(x + y + z) * kernels::SIMPLEX_UNSKEW;
                const vec3 d0 = lower - at, d1 = upper - at;
                Interval distance{0, 0};
                for (int a = 0; a < 3; ++a) distance = sum(distance, square({d0[a], d1[a]}));
                const Interval t{std::max(0.0f, kernels::SIMPLEX_REACH - distance.high),
                                 std::max(0.0f, kernels::SIMPLEX_REACH - distance.low)};
                if (t.high <= 0) continue;
                const Interval weight = square(square(t));
                total = sum(total, product(weight, slope(corner, d0, d1)));
            }
    return times(kernels::SIMPLEX_SCALE, total);
}

Interval octave_bounds(uint kind, vec3 lower, vec3 upper) {
    const vec3 width = upper - lower;
    if (!(std::max({width.x, width.y, width.z}) <= float(MAX_CELLS - 1)) ||
        !(glm::length(glm::max(glm::abs(lower), glm::abs(upper))) < MAX_COORDINATE))
        return {-1, 1};
    const Interval b =
        kind == kernels::NOISE_SIMPLEX ? simplex_bounds(lower, upper) : lattice_bounds(kind, lower, upper);
    const float slack = kind == kernels::NOISE_SIMPLEX ? 20 * ROUNDING : ROUNDING;
    return {std::max(-1.0f, b.low - slack), std::min(1.0f, b.high + slack)};
}

}  // namespace

Interval noise_bounds(uint kind, vec3 lower, vec3 upper, uint octaves, float gain, float lacunarity) {
    Interval total{0, 0};
    float amplitude = 1, amplitudes = 0;
    const uint count = std::clamp(octaves, 1u, kernels::FBM_MAX_OCTAVES);
    for (uint i = 0; i < count; ++i) {
        // The coordinate's rounding, which later octaves magnify along with the coordinate.
        const vec3 slack = 4e-7f * (glm::max(glm::abs(lower), glm::abs(upper)) + 1.0f);
        total = sum(total, times(amplitude, octave_bounds(kind, lower - slack, upper + slack)));
        amplitudes += amplitude;
        amplitude *= gain;
        lower = lacunarity * lower + kernels::octave_shift();
        upper = lacunarity * upper + kernels::octave_shift();
    }
    return {std::max(-1.0f, total.low / amplitudes - ROUNDING), std::min(1.0f, total.high / amplitudes + ROUNDING)};
}

}  // namespace spinel
