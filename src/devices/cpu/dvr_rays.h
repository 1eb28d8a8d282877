#pragma once
// Eight rays on their way through a volume, and what they have seen: what the files of DvrPackets share.

#include <algorithm>

#include "devices/cpu/dvr_packet.h"

namespace spinel {

struct DvrPackets::Rays {
    RayLanes world, index;  // in their two spaces
    Float8 start;
    Float8 span_begin, span_end;  // in units of the ray
    Int8 first, last;             // steps; first > last: none
    Float8 per_index;             // steps that go one unit of index space along the axis that they go farthest
    int begin, end;               // least and greatest of all

    Vec8 at(Float8 t) const { return index.at(t); }
};

struct DvrPackets::Seen {
    Float8 red = splat(0.0f), green = splat(0.0f), blue = splat(0.0f);
    Float8 left = splat(1.0f);
    Float8 depth = splat(0.0f);
    Vec8 normal = {splat(0.0f), splat(0.0f), splat(0.0f)};
    Int8 bound_reached = splat(0);
};

// How many steps all of these rays may leap, at least 1: rays that are alive as far as `steps`, others to where they
// begin.
inline int dvr_leap(Int8 alive, Int8 steps, Int8 first, Int8 waiting, int k) {
    return std::max(1, least(alive ? steps : waiting ? first - k : splat(1 << 20)));
}

}  // namespace spinel
