#ifndef SPINEL_KERNELS_INTERIOR_H
#define SPINEL_KERNELS_INTERIOR_H
// What a path is inside of: a short multiset of interiors, updated at every boundary it crosses. Dielectrics nest by
// priority (Schmidt and Budge, "Simple Nested Dielectrics in Ray Traced Images", JGT 7(2), 2002): where several
// overlap, the highest priority is what is there, and boundaries of the others are not seen. Interiors without an index
// of refraction are mere volumes of priority 0: they add to each other and to dielectrics of priority 0 or less, and
// are displaced by dielectrics of a higher one.
#include "scene_view.h"
KERNELS_BEGIN

const uint MAX_INSIDE = 8u;

struct Inside {
    uint entries[8];  // interior indices
    uint count;
    uint dropped;  // entries that found no room: a bias, so it is counted and reported
};

FN Inside inside_nothing() {
    Inside list;
    for (uint i = 0u; i < MAX_INSIDE; ++i) list.entries[i] = NONE;
    list.count = 0u;
    list.dropped = 0u;
    return list;
}

FN void inside_enter(inout(Inside) list, uint interior) {
    if (interior == NONE) return;
    if (list.count >= MAX_INSIDE) {
        list.dropped += 1u;
        return;
    }
    list.entries[list.count] = interior;
    list.count += 1u;
}

// The same before the first entry that is greater: a list that is only ever entered so does not depend on the order.
FN void inside_enter_sorted(inout(Inside) list, uint interior) {
    uint i = list.count;
    inside_enter(list, interior);
    for (; i > 0u && i < list.count && list.entries[i - 1u] > interior; --i) {
        list.entries[i] = list.entries[i - 1u];
        list.entries[i - 1u] = interior;
    }
}

FN void inside_leave(inout(Inside) list, uint interior) {
    for (uint i = 0u; i < list.count; ++i) {
        if (list.entries[i] == interior) {
            for (uint j = i + 1u; j < list.count; ++j) list.entries[j - 1u] = list.entries[j];
            list.count -= 1u;
            return;
        }
    }
}

FN bool inside_contains(const_in(Inside) list, uint interior) {
    for (uint i = 0u; i < list.count; ++i)
        if (list.entries[i] == interior) return true;
    return false;
}

// The dielectric that is really there: highest priority, the first entered among equals; NONE in air.
FN uint inside_dielectric(const_in(SceneView) scene, const_in(Inside) list) {
    uint winner = NONE;
    int priority = 0;
    for (uint i = 0u; i < list.count; ++i) {
        RECORD(Interior) interior = scene.interiors.at[list.entries[i]];
        if (interior.ior > 0.0f && (winner == NONE || interior.priority > priority)) {
            winner = list.entries[i];
            priority = interior.priority;
        }
    }
    return winner;
}

FN float interior_ior(const_in(SceneView) scene, uint interior) {
    return interior == NONE ? 1.0f : scene.interiors.at[interior].ior;
}

// The scattering media in force, and what merely absorbs, summed.
struct ActiveMedia {
    uint ids[8];  // as many as a path can be inside of: MAX_INSIDE
    uint count;
    vec3 absorption;   // of media flagged MEDIUM_ABSORBS_ONLY, attenuated in closed form
    bool homogeneous;  // all of ids: attenuation has a closed form too
    bool emissive;     // any of ids
};

FN ActiveMedia active_media(const_in(SceneView) scene, const_in(Inside) list) {
    ActiveMedia m;
    m.count = 0u;
    m.absorption = vec3(0.0f);
    m.homogeneous = true;
    m.emissive = false;
    if (list.count == 0u) return m;
    uint winner = inside_dielectric(scene, list);
    bool winner_taken = false;
    for (uint i = 0u; i < list.count; ++i) {
        uint entry = list.entries[i];
        RECORD(Interior) interior = scene.interiors.at[entry];
        if (interior.medium == NONE) continue;
        if (interior.ior > 0.0f) {
            if (entry != winner || winner_taken) continue;
            winner_taken = true;
        } else if (winner != NONE && scene.interiors.at[winner].priority > interior.priority) {
            continue;
        }
        RECORD(Medium) medium = scene.media.at[interior.medium];
        if ((medium.flags & MEDIUM_ABSORBS_ONLY) != 0u) {
            m.absorption += medium.absorption;
        } else {
            m.ids[m.count] = interior.medium;
            m.count += 1u;
            if (medium.grid != NONE) m.homogeneous = false;
            if (!is_black(medium.emission)) m.emissive = true;
        }
    }
    return m;
}

KERNELS_END
#endif
