#ifndef SPINEL_KERNELS_BSDF_TYPES_H
#define SPINEL_KERNELS_BSDF_TYPES_H
// What every material's functions take and return.
//
// Local frame: +z is the shading normal on wo's side, wo.z > 0; wi.z < 0 is transmission. Both point away
// from the surface; radiance arrives along wi and leaves along wo. Values are f·|cos θi|, 0 for delta lobes;
// densities are over solid angle [1/sr]. Radiance is transported: what crosses into or out of a dielectric is
// scaled by (n_incident / n_transmitted)², as the same flux fills another solid angle there.
#include "microfacet.h"
#include "scene_view.h"
KERNELS_BEGIN

// A material at a point, its textures applied. Which members count depends on the kind.
struct Bsdf {
    uint kind;  // MATERIAL_…
    vec3 color;
    float roughness;
    float metallic;
    vec3 eta;
    vec3 k;
    vec3 edge_color;
    float ior;           // of a coat, against what surrounds it
    float relative_ior;  // n_transmitted / n_incident as seen from wo
    // What a kind works out once for a point, in its _make function (energy: see there):
    vec3 again;   // colour of the multiple scattering between microfacets
    vec3 energy;  // means over the hemisphere
    // Of principled: a clear coat, its mean; how much of the base is a thin wall.
    float coat;
    float coat_roughness;
    float coated_through;  // see principled_make
    float transmission;
};

const uint LOBE_DELTA = 1u;         // a mirror or a clear interface: `pdf` is the probability of having chosen it
const uint LOBE_TRANSMISSION = 2u;  // crosses the surface
const uint LOBE_FAILED = 4u;        // no direction: the weight is 0, the path ends

struct BsdfSample {
    vec3 direction;
    vec3 weight;  // f·|cos θi| / pdf
    float pdf;    // of all lobes together, what the pdf function gives for this direction
    uint flags;   // LOBE_…
};

FN BsdfSample bsdf_failed() { return BsdfSample(vec3(0.0f, 0.0f, 1.0f), vec3(0.0f), 0.0f, LOBE_FAILED); }

// A sample's weight from value and density of all lobes together.
FN BsdfSample bsdf_weighted(vec3 wi, vec4 value_pdf) {
    if (!(value_pdf.w > 1e-20f)) return bsdf_failed();
    return BsdfSample(wi, vec3(value_pdf.x, value_pdf.y, value_pdf.z) / value_pdf.w, value_pdf.w,
                      wi.z < 0.0f ? LOBE_TRANSMISSION : 0u);
}

FN float lambert_pdf(vec3 wi) { return abs(wi.z) * INV_PI; }

KERNELS_END
#endif
