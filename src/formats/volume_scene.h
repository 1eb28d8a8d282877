#pragma once
// What a file of volumes becomes: for each grid its box as a volume geometry and one object; around what is a density a
// bright medium, so that the bare file shows something; on a level set's surface a material, for the same reason. A
// scene file names the geometries and has media of its own.

#include <string>
#include <vector>

#include "spinel/scene.h"

namespace spinel {

struct BareVolume {
    vec2 density_range = {0, 1};
    float optical_depth = 10;  // about, along the longest edge at density 1
};

// The grids are named already. Vectors get no medium.
Scene volume_scene(std::vector<Grid> grids, const BareVolume& look = {});

// For data in units of their own (scans): what lies in the lowest fifth of the range is air.
BareVolume look_of_scan(const Grid& grid);

// "density", "density[1]", …: names of grids are made different where they are equal.
void tell_apart(std::vector<Grid>& grids);

}  // namespace spinel
