// How a picture is made of a scene: film, integrators, acceleration structure, frames, what a test expects.
#include "scene/scene_fields.h"

namespace spinel {

template <>
struct ChoiceNames<Transmittance> {
    static constexpr std::string_view names[] = {"ratio", "residual", "delta"};
};
template <>
struct ChoiceNames<ToneMap> {
    static constexpr std::string_view names[] = {"linear", "aces", "agx"};
};
template <>
struct ChoiceNames<MarchOptions::Integration> {
    static constexpr std::string_view names[] = {"energy_conserving", "naive"};
};
template <>
struct ChoiceNames<DvrOptions::Mode> {
    static constexpr std::string_view names[] = {"composite", "maximum", "average", "isosurface"};
};
template <>
struct ChoiceNames<DvrOptions::Light> {
    static constexpr std::string_view names[] = {"camera", "scene"};
};
template <>
struct ChoiceNames<DvrOptions::Preset> {
    static constexpr std::string_view names[] = {"none",     "ct-bone", "ct-skin", "ct-muscle", "ct-lung",
                                                 "ct-angio", "ct-xray", "mri",     "solid"};
};
template <>
struct ChoiceNames<DvrOptions::ColorMap> {
    static constexpr std::string_view names[] = {"none", "grey", "viridis", "inferno", "hot", "cool-warm", "rainbow"};
};
template <>
struct ChoiceNames<PixelFilter> {
    static constexpr std::string_view names[] = {"box", "tent", "gaussian", "blackman_harris"};
};

namespace {

constexpr Range pixels{1, 65536};

}  // namespace

const Record& film_record() {
    static const Record table = record<Film>(
        "", "The picture that is made.",
        {
            field("size", &Film::size, "Width and height of the picture.", pixels, "pixels"),
            field("exposure", &Film::exposure, "Brightening before the tone map; radiance is multiplied by 2^exposure.",
                  any, "stops"),
            field("tone_map", &Film::tone_map,
                  "How radiance becomes the colours of an 8-bit picture; EXR stays linear."),
            field("filter", &Film::filter, "Pixel reconstruction filter, importance sampled."),
            field("filter_radius", &Film::filter_radius,
                  "Half the width of the filter; a box of 0.5 is the pixel itself.", {0, 16, true}, "pixels"),
        });
    return table;
}

const Record& integrator_record() {
    static const Record table = record<IntegratorSettings>(
        "", "How light is computed; the command line overrides it.",
        {
            field("type", &IntegratorSettings::name, "Name of the integrator, as `spinel list integrators` prints it."),
            field("spp", &IntegratorSettings::spp, "Samples per pixel.", {1, 1 << 30}),
            field("clamp", &IntegratorSettings::clamp,
                  "Most radiance that one path may add by indirect light: takes sparks away and caustics with them; 0: "
                  "no "
                  "limit, unbiased.",
                  non_negative),
            field("max_bounces", &IntegratorSettings::max_bounces,
                  "Scattering events of a path; 0: only light that is seen directly; −1: Russian roulette "
                  "alone ends it.",
                  {-1, 1 << 30}),
            field(
                "transmittance", &IntegratorSettings::transmittance,
                "`path`: how shadow rays through media on grids estimate what is left of the light. All are unbiased: "
                "`ratio` multiplies what every collision leaves; `residual` does so about the least density of a "
                "neighbourhood, which counts in closed form; `delta` takes the first real collision as a shadow."),
            field("equiangular", &IntegratorSettings::equiangular,
                  "`path`: media also look for the light of points and spots near to them (Kulla and Fajardo 2012). "
                  "Pictures differ in noise alone."),
            field("ao_radius", &IntegratorSettings::ao_radius,
                  "`ao`: how far rays look for what hides the sky; 0: a twentieth of the scene's diagonal. Voxels look "
                  "at "
                  "their neighbours instead.",
                  non_negative, "scene units"),
            field("ao_strength", &IntegratorSettings::ao_strength,
                  "`ao`: 1: where all is hidden it is black; 0: no ambient occlusion.", unit_interval),
            field("glow", &IntegratorSettings::glow,
                  "`ao`, `faces`, `cone`: strength of the halo about voxels that emit; 0: none.", non_negative),
            field("glow_radius", &IntegratorSettings::glow_radius, "Reach of that halo; 0: four voxels of the set.",
                  non_negative, "scene units"),
            by_hand("march", "march", "`single-scatter`: how it marches."),
            by_hand("dvr", "dvr", "`dvr`: what it shows, and how."),
            field(
                "heat_counter", &IntegratorSettings::heat_counter,
                "`heatmap`: what is counted. 0: all together, 1: nodes and cells visited, 2: boxes and planes tested, "
                "3: triangles tested.",
                {0, 3}),
            field("heat_most", &IntegratorSettings::heat_most, "`heatmap`: the count that has the hottest colour.",
                  {1, 1e9}),
            field("depth_end", &IntegratorSettings::depth_end,
                  "`depth`: the distance that is black; 0: the far end of what is bounded.", non_negative,
                  "scene units"),
        });
    return table;
}

const Record& march_record() {
    static const Record table = record<MarchOptions>(
        "",
        "How `single-scatter` marches through media. Light comes from points, spots and directional lights, the last "
        "without their size; the environment is even light without shadows.",
        {
            field("step", &MarchOptions::step, "Step along camera rays; 0: a 256th of the scene's diagonal.",
                  non_negative, "scene units"),
            field("shadow_step", &MarchOptions::shadow_step,
                  "Step from within media towards lights; 0: four times `step`.", non_negative, "scene units"),
            field("shadow_reach", &MarchOptions::shadow_reach,
                  "How far media are looked at on that way; 0: all the way.", non_negative, "scene units"),
            field("surface_shadow_step", &MarchOptions::surface_shadow_step,
                  "Step from surfaces towards lights; 0: as `shadow_step`.", non_negative, "scene units"),
            field("surface_shadow_reach", &MarchOptions::surface_shadow_reach,
                  "How far media are looked at on that way; 0: all the way.", non_negative, "scene units"),
            field(
                "light_reach", &MarchOptions::light_reach,
                "Points and spots fade out by (1 − distance/light_reach)² besides the inverse square; 0: they do not.",
                non_negative, "scene units"),
            field("integration", &MarchOptions::integration,
                  "`energy_conserving`: in closed form within a step; `naive`: the sum of what each step adds, too "
                  "bright "
                  "where a step is not thin."),
            field("jitter", &MarchOptions::jitter,
                  "Whether marches from camera and surfaces begin at a random part of a step, which turns bands into "
                  "grain; marches from within media begin at half a step."),
            field("shortcuts", &MarchOptions::shortcuts,
                  "Whether the CPU may take faster ways to nearly the same picture: how deep a light's way lies in the "
                  "medium comes from a lattice of 112 cells along the longest edge, and less than a 512th of the light "
                  "is as good as none; a few thousandths of full brightness (root mean square) in `bunny.json`, more "
                  "where shadows are finer than a cell. false: every step of every march is taken."),
        });
    return table;
}

const Record& dvr_record() {
    static const Record table = record<DvrOptions>(
        "",
        "What `dvr` shows of the scene's first volume (of others there is a warning): its values through a transfer "
        "function, in the data's own units "
        "(Hounsfield, for CT). Windows and points need no knowledge of how the volume is otherwise made a medium.",
        {
            field(
                "mode", &DvrOptions::mode,
                "Front to back through opacity; the greatest value along a ray; the mean value; the surface where the "
                "value is `iso`."),
            field("preset", &DvrOptions::preset,
                  "Transfer function by name: those of CT in Hounsfield units, `mri` and `solid` over the window; "
                  "`none`: "
                  "`points`, or a grey ramp over the window."),
            by_hand("points", "transfer_points", "The transfer function, in place of a preset."),
            field("color_map", &DvrOptions::color_map, "Colours over the window, in place of the points'."),
            field("level", &DvrOptions::level, "Middle of the window.", any, "data units"),
            field("width", &DvrOptions::width,
                  "Width of the window, over which `points` are then told from 0 to 1 and a preset is stretched; 0: "
                  "values "
                  "are in data units, and what needs a window takes the range of the data.",
                  non_negative, "data units"),
            field("opacity", &DvrOptions::opacity, "Multiplies the extinction.", non_negative),
            field("unit", &DvrOptions::unit, "How thick a layer opacities are told of.", positive, "edges of a voxel"),
            field("step", &DvrOptions::step, "Step along a ray; opacity is corrected for it.", {0.01, 100},
                  "edges of a voxel"),
            field("iso", &DvrOptions::iso, "Value of the surface.", any, "data units"),
            color("iso_color", &DvrOptions::iso_color, "Its colour.", unit_interval),
            field("shaded", &DvrOptions::shaded, "Whether the gradient is lit as a surface would be (Blinn–Phong)."),
            field("light", &DvrOptions::light,
                  "Where light comes from: the camera, or the scene's sun, its brightest directional light."),
            field("ambient", &DvrOptions::ambient, "Light that reaches everything.", non_negative),
            field("diffuse", &DvrOptions::diffuse, "Light that depends on the gradient.", non_negative),
            field("specular", &DvrOptions::specular, "Strength of highlights.", non_negative),
            field("shininess", &DvrOptions::shininess, "Their exponent.", {0, 1e4}),
            field("shadow", &DvrOptions::shadow, "How much of the light the volume may take on its way; 0: none.",
                  unit_interval),
            field("shadow_reach", &DvrOptions::shadow_reach, "How far that is looked for.", {0, 1e4},
                  "edges of a voxel"),
            field("clip_lower", &DvrOptions::clip_lower, "Lower corner of what is shown, in parts of the volume's box.",
                  unit_interval),
            field("clip_upper", &DvrOptions::clip_upper, "Upper corner of it.", unit_interval),
            by_hand("clip_planes", "clip_planes",
                    "Up to four [x, y, z, w] in world space: where x·px + y·py + z·pz > w, nothing is shown."),
            color("background", &DvrOptions::background, "What is seen behind the volume."),
            field("jitter", &DvrOptions::jitter, "Whether rays begin at a random part of a step."),
            field(
                "shortcuts", &DvrOptions::shortcuts,
                "Whether the CPU may take faster ways to the same picture, but for values being kept in 16 bits (whole "
                "numbers exactly); false: every step is taken."),
        });
    return table;
}

const Record& transfer_point_record() {
    static const Record table = record<TransferPoint>(
        "", "A point of a transfer function; between points all is linear, outside constant.",
        {
            required(
                field("value", &TransferPoint::value, "In data units, or 0 to 1 over the window if it has a width.")),
            color("color", &TransferPoint::color, "Linear colour.", unit_interval),
            field("opacity", &TransferPoint::opacity, "Of a layer as thick as `unit`.", unit_interval),
        });
    return table;
}

const Record& animation_record() {
    static const Record table = record_by_hand(
        "",
        "Values of this file as formulas of time: `spinel render scene.json --frames 0:120 -o frame_%04d.png`. They "
        "take "
        "their places before the file is read, so whatever it may say may move; where nobody asks for a frame, frame 0 "
        "is shown. Formulas have + − * / ^, parentheses, pi, `t` (seconds, frame/fps), `frame`, the variables and "
        "abs(x), ceil(x), clamp(x, low, high), cos(x), exp(x), floor(x), fract(x), keys(t, t0, v0, t1, v1, …) (linear "
        "between, constant outside), log(x), max(x, y), min(x, y), mix(a, b, x), mod(x, y), random(n, stream) (uniform "
        "in 0 … 1, for each whole part of n), sin(x), smoothstep(low, high, x), sqrt(x), step(edge, x), tan(x); angles "
        "are in radians.",
        {
            by_hand("fps", "rate", "Frames a second; 30 without. `--fps` overrides it."),
            by_hand("variables", "formulas", "Formulas by name, each of which may use those before it."),
            by_hand(
                "values", "formula_values",
                "By the place in this file: \"/lights/0/position/1\", keys, numbers in lists from 0 or the `name` of "
                "what stands in a list. There has to be a value, which is replaced by a formula, a number or a list "
                "of these."),
        });
    return table;
}

const Record& accelerator_record() {
    static const Record table = record<AcceleratorSettings>(
        "", "How rays find triangles; the command line overrides it. Pictures agree but for rounding.",
        {
            field("type", &AcceleratorSettings::structure,
                  "What meshes are built into, as `spinel list accelerators` prints it."),
            field("triangle_test", &AcceleratorSettings::triangle_test,
                  "How a ray is tested against a triangle, as `spinel list triangle-tests` prints it."),
            field("preset", &AcceleratorSettings::preset,
                  "How wide-bvh8 and wide-bvh8-compact are built: `fast`, `balanced` or `high`, slower to build and "
                  "faster for rays in this order; empty: `high`."),
        });
    return table;
}

const Record& expected_record() {
    static const Record table = record<Expected>(
        "", "Makes the scene a test: what the mean over the picture must be.",
        {
            required(
                color("mean", &Expected::mean, "Mean radiance over the whole picture.", non_negative, "W/(sr·m²)")),
            field("tolerance", &Expected::tolerance, "Allowed relative difference of each channel.", positive),
        });
    return table;
}

}  // namespace spinel
