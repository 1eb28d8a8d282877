#ifndef SPINEL_KERNELS_LOCATE_H
#define SPINEL_KERNELS_LOCATE_H
// Which closed objects a point lies in: a ray to far away leaves each of them once more than it enters it.
#include "device.h"
#include "surface.h"
KERNELS_BEGIN

const uint MAX_LOCATE_CROSSINGS = 4096u;

FN Inside interiors_at(const_in(SceneView) scene, vec3 p) {
    Inside found = inside_nothing();
    Inside entered = inside_nothing();
    // A direction without symmetry, so that edges and corners of things people build are not met.
    Ray ray = Ray(p, 0.0f, normalize(vec3(0.3713907f, 0.7427814f, 0.5570860f)), INFINITE);
    for (uint i = 0u; i < MAX_LOCATE_CROSSINGS; ++i) {
        Hit hit = trace_closest(scene, ray, TRACE_ALL);
        if (!is_hit(hit)) break;
        Surface s = surface_at(scene, ray, hit);
        if (s.leaves != NONE) {
            if (inside_contains(entered, s.leaves)) inside_leave(entered, s.leaves);
            else inside_enter(found, s.leaves);
        }
        inside_enter(entered, s.enters);
        ray.origin = leave_surface(scene, s, ray.direction);
    }
    return found;
}

KERNELS_END
#endif
