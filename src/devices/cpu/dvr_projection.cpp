// Greatest and mean values along rays, and the surfaces of one value.

#include <algorithm>

#include "devices/cpu/dvr_rays.h"
#include "kernels/dvr.h"
#include "kernels/traverse.h"

namespace spinel {

namespace {

// Steps from k on that stay in the cell of this edge at p, at least 1.
Int8 steps_within(const Vec8& p, const Vec8& direction, int edge, float step) {
    const auto along = [&](Float8 at, Float8 d) {
        const float scale = 1.0f / float(edge);
        const Float8 cell = floor8(at * scale);
        const Float8 to = (cell + (d > 0.0f ? splat(1.0f) : splat(0.0f))) * float(edge) - at;
        const Int8 still = absolute(d) < 1e-20f;
        return still ? splat(1e9f) : to / (still ? splat(1.0f) : d);
    };
    const Float8 way = minimum(along(p.x, direction.x), minimum(along(p.y, direction.y), along(p.z, direction.z)));
    return to_int(minimum(maximum(way * (1.0f / step), splat(0.0f)), splat(1e6f))) + 1;
}

}  // namespace

// dvr_projection() of the kernel. A brick cannot raise the greatest value if nothing in it is greater, and one of a
// single value is summed at once. Since how far rays leap depends on their company, what they come to must not: values
// are held to the range of their brick, and sums are of whole 256ths of a unit, which doubles add without rounding.
void DvrPackets::projection(const Rays& rays, Seen& seen) const {
    const bool greatest = settings_.mode == kernels::DVR_MAXIMUM;
    const float step = settings_.step;
    Float8 result = splat(-1.0f);
    Double8 sum = to_double(splat(0));
    int k = rays.begin;
    for (int bound = 0; k <= rays.end; ++bound) {
        const Int8 alive = (rays.first <= k) & (rays.last >= k);
        const Int8 waiting = (rays.first > k) & (rays.first <= rays.last);
        if (bound == int(kernels::MAX_DVR_STEPS)) {
            seen.bound_reached = alive | waiting;
            break;
        }
        const Float8 t = (float(k) + rays.start) * step;
        const Vec8 p = rays.at(t);
        const auto settled = [&](const DvrVolume::Range& r) { return greatest ? r.most <= result : r.least == r.most; };
        const DvrVolume::Range near = volume_.brick_range(p), wide = volume_.block_range(p);
        if (!any(alive & ~settled(near))) {
            const int edge = any(alive & ~settled(wide)) ? DvrVolume::brick : DvrVolume::block;
            const int leap = dvr_leap(alive, steps_within(p, rays.index.direction, edge, step), rays.first, waiting, k);
            const Int8 taken = minimum(splat(leap), rays.last - k + 1);
            if (!greatest) sum += to_double(alive ? to_int(near.most) : splat(0)) * to_double(taken) * 256.0;
            k += leap;
            continue;
        }
        const Float8 value = minimum(maximum(volume_.value(p), near.least), near.most);
        if (greatest) {
            const Int8 raised = alive & (value > result);
            result = raised ? value : result;
            seen.depth = raised ? t : seen.depth;
        } else {
            sum += to_double(alive ? to_int(value * 256.0f + 0.5f) : splat(0));
        }
        ++k;
    }
    const Int8 looked = rays.first <= rays.last;
    if (!greatest)
        result =
            __builtin_convertvector(sum / (256.0 * to_double(maximum(rays.last - rays.first + 1, splat(1)))), Float8);
    const Float8 place = volume_.place(result);
    for (int i = 0; i < width; ++i) {
        if (!looked[i]) continue;
        const vec4 row = kernels::transfer_at(view_, settings_, place[i]);
        if (!(row.w > 0)) {
            seen.depth[i] = 0;
            continue;
        }
        seen.left[i] = 0;
        seen.red[i] = row.x / row.w, seen.green[i] = row.y / row.w, seen.blue[i] = row.z / row.w;
    }
}

// dvr_isosurface() of the kernel: rays first find the step in which they come upon the surface, then all halve theirs
// together.
void DvrPackets::isosurface(const Rays& rays, Seen& seen) const {
    const float step = settings_.step, iso = volume_.value_of(settings_.iso);
    const auto above_at = [&](Float8 t) { return volume_.value(rays.at(t)) >= iso; };
    const Int8 valid = rays.span_begin < rays.span_end;
    // Where something is above at once, the end of the span is its surface.
    Int8 found = valid & above_at(rays.span_begin);
    Float8 below = rays.span_begin, above = rays.span_begin;
    int k = rays.begin;
    for (int bound = 0;; ++bound) {
        // Each ray looks at whole steps, and at last at the far end of its span.
        const Int8 alive = valid & ~found & (rays.first <= k) & (rays.last + 1 >= k);
        const Int8 waiting = valid & ~found & (rays.first > k);
        if (!any(alive | waiting)) break;
        if (bound == int(kernels::MAX_DVR_STEPS)) {
            seen.bound_reached = alive | waiting;
            break;
        }
        const Float8 t = minimum((float(k) + rays.start) * step, rays.span_end);
        const Vec8 p = rays.at(t);
        const Int8 distance = volume_.distance(p);
        if (!any(alive & (distance == 0))) {
            const Float8 rings = to_float(maximum(distance - 1, splat(0))) * float(DvrVolume::brick);
            k += dvr_leap(alive, minimum(to_int(rings * rays.per_index), rays.last + 1 - k), rays.first, waiting, k);
            continue;
        }
        const Int8 now = alive & (volume_.value(p) >= iso);
        below = now ? maximum((float(k - 1) + rays.start) * step, rays.span_begin) : below;
        above = now ? t : above;
        found |= now;
        ++k;
    }
    if (any(found & (below < above)))
        for (kernels::uint i = 0; i < kernels::DVR_BISECTIONS; ++i) {
            const Float8 t = 0.5f * (below + above);
            const Int8 now = above_at(t);
            below = now ? below : t;
            above = now ? t : above;
        }
    if (!any(found)) return;
    const DvrLights::Lit lit = lights_.at(volume_, rays.world, rays.index, above, found);
    const vec3 color = settings_.iso_color;
    seen.red = found ? color.x * lit.factor + lit.highlight : seen.red;
    seen.green = found ? color.y * lit.factor + lit.highlight : seen.green;
    seen.blue = found ? color.z * lit.factor + lit.highlight : seen.blue;
    seen.left = found ? splat(0.0f) : seen.left;
    seen.depth = found ? above : seen.depth;
    seen.normal = lit.normal;
}

}  // namespace spinel
