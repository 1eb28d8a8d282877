#ifndef SPINEL_KERNELS_CONTACT_H
#define SPINEL_KERNELS_CONTACT_H
// Where surfaces of two instances may lie in the same place, as scene/compile_contacts.cpp found it.
#include "scene_view.h"
KERNELS_BEGIN

// Bound of the rounding error of all surfaces that may be where p on the instance's surface is; 0: there is no other.
FN float contact_error(const_in(SceneView) scene, const_in(Instance) instance, vec3 p) {
    float error = 0.0f;
    for (uint i = instance.contact_first; i < instance.contact_first + instance.contact_count; ++i) {
        RECORD(Contact) c = scene.contacts.at[i];
        if (p.x >= c.lower.x && p.y >= c.lower.y && p.z >= c.lower.z && p.x <= c.upper.x && p.y <= c.upper.y &&
            p.z <= c.upper.z)
            error = max(error, c.error);
    }
    return error;
}

KERNELS_END
#endif
