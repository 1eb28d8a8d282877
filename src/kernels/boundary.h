#ifndef SPINEL_KERNELS_BOUNDARY_H
#define SPINEL_KERNELS_BOUNDARY_H
// What a ray crosses at one place. Mostly one surface; but things touch: fog fills a glass to the rim, two blocks share
// a face, smoke and fire fill one box. Then rounding alone decides which of the surfaces is met first, and the step by
// which the ray leaves that one passes over the others. So all of them count as one boundary: before it the ray is
// inside of what it was inside of; behind it, that with everything left and entered that any of them leaves and enters.
// Between the two there is one interface, or, where glass goes on behind the shared face of two blocks, none.
//
// Which surfaces belong to it is asked by a short ray through the place, along the normal, from where a reflected ray
// will start to where one that goes on will start: what crosses that, exactly what is passed over. Both ends lie
// farther from the place than rounding can move any of the surfaces, so no answer depends on rounding, nor on which
// surface was met first. Only where the compiler found that surfaces of two instances may touch
// (contact.h) is it asked at all.
//
// One of the surfaces is what light meets there:
//   1. one that stops light for sure; 2. one that may (opacity between 0 and 1); both: any material but a dielectric;
//   3. the dielectric of the highest priority: if anything refracts there, it does, since no other can have been on top
//      on either side; among equals, that whose interior stands first, whatever side the ray comes from;
//   4. a mere interface.
// Among other equals, that of the first instance. Where a surface that may stop light does not, light meets what else
// is there: glass refracts behind the holes of its label.
#include "surface.h"
#include "traverse.h"
KERNELS_BEGIN

const uint MAX_CONTACT_CROSSINGS = 8u;  // of one instance at one place

const uint MEETS_NOTHING = 0u;
const uint MEETS_DIELECTRIC = 1u;
const uint MEETS_VEIL = 2u;
const uint MEETS_WALL = 3u;

FN uint what_meets(const_in(SceneView) scene, const_in(Surface) s) {
    float opacity = surface_opacity(scene, s);
    if (!(opacity > 0.0f)) return MEETS_NOTHING;
    if (scene.materials.at[s.material].kind == MATERIAL_DIELECTRIC) return MEETS_DIELECTRIC;
    return opacity < 1.0f ? MEETS_VEIL : MEETS_WALL;
}

// Of a dielectric surface, the interior that owns it: a face between two glasses is the stronger one's.
FN uint owning_interior(const_in(SceneView) scene, const_in(Surface) s) {
    if (s.leaves == NONE || s.enters == NONE) return s.leaves == NONE ? s.enters : s.leaves;
    int difference = scene.interiors.at[s.leaves].priority - scene.interiors.at[s.enters].priority;
    if (difference != 0) return difference > 0 ? s.leaves : s.enters;
    return min(s.leaves, s.enters);
}

// Whether light meets `a` rather than `b`, which is in the same place.
FN bool meets_first(const_in(SceneView) scene, const_in(Surface) a, const_in(Surface) b) {
    uint what_a = what_meets(scene, a);
    uint what_b = what_meets(scene, b);
    if (what_a != what_b) return what_a > what_b;
    if (what_a == MEETS_DIELECTRIC) {
        uint inside_a = owning_interior(scene, a);
        uint inside_b = owning_interior(scene, b);
        if (inside_a != NONE && inside_b != NONE && inside_a != inside_b) {
            int difference = scene.interiors.at[inside_a].priority - scene.interiors.at[inside_b].priority;
            return difference != 0 ? difference > 0 : inside_a < inside_b;
        }
    }
    return a.instance < b.instance;
}

// What is left and entered at one place, in sum: what one surface enters and the next leaves is a sheet without
// thickness.
struct Passage {
    Inside left;
    Inside entered;
};

FN void pass_surface(const_in(Surface) s, inout(Passage) passage) {
    if (s.leaves != NONE) {
        if (inside_contains(passage.entered, s.leaves)) inside_leave(passage.entered, s.leaves);
        else inside_enter(passage.left, s.leaves);
    }
    if (s.enters != NONE) {
        if (inside_contains(passage.left, s.enters)) inside_leave(passage.left, s.enters);
        else inside_enter_sorted(passage.entered, s.enters);
    }
}

// Passes what else is in the place of `met`, which the ray met along `direction`, among the instances that the mask
// admits. `met` becomes the surface that light meets; `under` that which it meets where a veil lets it through, its
// instance NONE if there is no other.
FN void pass_contacts(const_in(SceneView) scene, vec3 direction, uint mask, inout(Surface) met, inout(Surface) under,
                      inout(Passage) passage) {
    under = met;
    if (what_meets(scene, met) == MEETS_VEIL) under.instance = NONE;
    vec3 front = leave_surface(scene, met, -direction);
    vec3 across = leave_surface(scene, met, direction) - front;
    if (is_black(across)) return;
    vec3 place = met.position;
    uint first = met.instance;
    Ray gap = Ray(front, 0.0f, across, 1.0f);
    InstanceWalk walk = walk_instances(scene, gap);
    for (uint i = next_instance(scene, walk); i != NONE; i = next_instance(scene, walk)) {
        if (i == first || !(contact_error(scene, scene.instances.at[i], place) > 0.0f)) continue;
        if (!instance_admitted(scene.instances.at[i].flags, mask)) continue;
        Ray onward = gap;
        for (uint k = 0u; k <= MAX_CONTACT_CROSSINGS; ++k) {
            Hit hit = no_hit(gap.t_max);
            instance_closest(scene, i, onward, hit);
            if (!is_hit(hit)) break;
            if (k == MAX_CONTACT_CROSSINGS) passage.entered.dropped += 1u;
            Surface s = surface_at(scene, gap, hit);
            pass_surface(s, passage);
            float error = max(met.error, s.error);
            uint what = what_meets(scene, s);
            if (what != MEETS_VEIL && (under.instance == NONE || meets_first(scene, s, under))) under = s;
            if (meets_first(scene, s, met)) met = s;
            met.error = error;
            under.error = error;
            if (what == MEETS_WALL) break;  // nothing behind it matters
            onward.t_min = hit.t;
        }
    }
}

// Crosses the boundary that a ray along `direction` meets at s: returns what lies behind it. Something that is left but
// was never entered (an open mesh seen from behind) is taken as if it had been. s becomes the surface that light meets,
// `under` that which it meets where s is a veil and lets it through (instance NONE: nothing).
FN Inside cross_boundary(const_in(SceneView) scene, vec3 direction, uint mask, inout(Surface) s, inout(Surface) under,
                         inout(Inside) inside) {
    under.instance = NONE;
    if (!s.contact) {
        if (s.leaves != NONE && !inside_contains(inside, s.leaves)) inside_enter(inside, s.leaves);
        Inside behind = inside;
        inside_leave(behind, s.leaves);
        inside_enter(behind, s.enters);
        return behind;
    }
    Passage passage = Passage(inside_nothing(), inside_nothing());
    pass_surface(s, passage);
    pass_contacts(scene, direction, mask, s, under, passage);
    Inside after = inside;
    for (uint i = 0u; i < passage.left.count; ++i) {
        uint left = passage.left.entries[i];
        if (inside_contains(after, left)) inside_leave(after, left);
        else inside_enter(inside, left);
    }
    for (uint i = 0u; i < passage.entered.count; ++i) inside_enter(after, passage.entered.entries[i]);
    after.dropped = max(after.dropped, inside.dropped) + passage.left.dropped + passage.entered.dropped;
    return after;
}

KERNELS_END
#endif
