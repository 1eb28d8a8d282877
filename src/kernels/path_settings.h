#ifndef SPINEL_KERNELS_PATH_SETTINGS_H
#define SPINEL_KERNELS_PATH_SETTINGS_H
#include "portable.h"
KERNELS_BEGIN

struct PathSettings {
    uint seed;
    int max_bounces;     // scattering events; −1: no limit
    float clamp;         // most that a path may add after its second scattering; 0: no limit
    int roulette_start;  // first bounce that Russian roulette may end
};

KERNELS_END
#endif
