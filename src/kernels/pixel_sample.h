#ifndef SPINEL_KERNELS_PIXEL_SAMPLE_H
#define SPINEL_KERNELS_PIXEL_SAMPLE_H
// What an integrator gives for one sample of a pixel.
#include "constants.h"
KERNELS_BEGIN

// What the first surface shows, for the auxiliary outputs; nothing where a medium scattered before.
struct FirstHit {
    vec3 normal;
    float depth;  // along the ray; 0: nothing was hit
    vec3 albedo;
    uint object;  // NONE: nothing was hit
};

struct PixelSample {
    vec3 radiance;
    FirstHit first;
    bool bound_reached;  // a safety bound cut the path: counted, since it would be a bias
};

KERNELS_END
#endif
