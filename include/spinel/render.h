#pragma once
// From a scene to a picture. A program that uses Spinel as a library needs no more than this:
//
//     auto scene   = spinel::load_scene("castle.vox");                                     // spinel/formats.h
//     auto picture = spinel::render_picture(*scene, {.size = {640, 360}, .render = {.spp = 64}});
//     auto saved   = spinel::save_picture("castle.png", picture->radiance);                // spinel/image.h
//
// Each gives a Result: a value, or an error of one sentence.

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "core/result.h"
#include "spinel/image.h"
#include "spinel/scene.h"

namespace spinel {

// Part of a picture: pixels [lower, upper), origin at the top left.
struct Crop {
    ivec2 lower = {0, 0};
    ivec2 upper = {0, 0};
    ivec2 size() const { return upper - lower; }
};

struct RenderOptions {
    int spp = 0;                  // samples per pixel; 0: the scene's, unless time or noise is given, then no limit
    double time_limit = 0;        // seconds; 0: none
    double noise = 0;             // stop at this relative standard error (of each tile); 0: never
    double clamp = -1;            // of indirect light; −1: the scene's; 0: none
    int max_bounces = -2;         // −2: the scene's; −1: no limit
    std::string integrator = {};  // empty: the scene's
    std::uint32_t seed = 0;       // same seed, same bits, on any number of threads
    Crop crop = {};               // empty: the whole film
};

struct RenderProgress {
    double fraction = 0;        // 0 … 1 of the work, as far as it can be known
    double seconds = 0;         // so far
    double remaining = -1;      // seconds still to go; −1: unknown
    std::uint32_t samples = 0;  // per pixel, so far
    double relative_error = 0;
};

enum class StopReason { samples, time, noise, interrupted };

struct PictureOptions {
    std::string camera = {};     // name; empty: the scene's first
    ivec2 size = {0, 0};         // of the film in pixels; (0, 0): the scene's
    std::string device = "cpu";  // as `spinel list devices` names them
    int threads = 0;             // 0: as many as the machine has cores
    RenderOptions render = {};
};

struct Picture {
    Image radiance;                // linear Rec.709, of the crop
    double samples_per_pixel = 0;  // on average
    double relative_error = 0;     // estimated standard error over brightness
    double seconds = 0;
    std::uint64_t biased_paths = 0;  // that reached a safety bound or were not finite: the picture is a little dark
    StopReason reason = StopReason::samples;
};

// Compiles the scene, renders it and forgets what is between. `report` is called between passes. `stop` may be set from
// another thread or a signal handler: what there is then is returned.
Result<Picture> render_picture(const Scene& scene, const PictureOptions& options = {},
                               const std::function<void(const RenderProgress&)>& report = {},
                               const std::atomic<bool>* stop = nullptr);

}  // namespace spinel
