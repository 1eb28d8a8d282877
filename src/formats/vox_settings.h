#pragma once
// What a MagicaVoxel file says of the place its models stand in: sun, sky, fog, ground, film and cameras.

#include "formats/vox_file.h"
#include "spinel/scene.h"

namespace spinel::vox {

// Gives the scene the file's light, surroundings and cameras. A file without render settings changes nothing.
//
//   _inf     sun: elevation and azimuth, intensity, colour; _area, the radius of its disc in radians
//   _env     which sky: 0 one colour (_uni), 1 a picture, 2 the air (_atm). The picture is not in the file: its place
//            takes the one colour, and that is noted
//   _atm     a clear sky; _mie_d is its haze
//   _fog_uni a fog around all that is there
//   _ground  colour; whether there is one at all says _setting
//   _film    exposure, and ACES or not
//   rCAM     cameras that were ever moved: pers, orth and iso
// Bloom, bounces, lens, edges, grid and background are the program's own way to draw, and are left out.
void apply_settings(const File& file, Scene& scene);

}  // namespace spinel::vox
