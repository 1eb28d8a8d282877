#include "scene/scene_fields.h"

namespace spinel {

template <>
struct ChoiceNames<Filter> {
    static constexpr std::string_view names[] = {"nearest", "linear"};
};
template <>
struct ChoiceNames<Wrap> {
    static constexpr std::string_view names[] = {"repeat", "clamp", "mirror"};
};
template <>
struct ChoiceNames<WrapV> {
    static constexpr std::string_view names[] = {"same", "repeat", "clamp", "mirror"};
};
template <>
struct ChoiceNames<VoxelOutlines::Where> {
    static constexpr std::string_view names[] = {"voxels", "changes", "shape"};
};
template <>
struct ChoiceNames<Erosion::Kind> {
    static constexpr std::string_view names[] = {"none", "value", "fbm", "value_noise", "perlin", "simplex"};
};
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

template <class T>
Record record(std::string_view type, std::string_view doc, std::vector<Field> fields) {
    static const T defaults{};
    return {type, doc, std::move(fields), &defaults};
}

Record record_by_hand(std::string_view type, std::string_view doc, std::vector<Field> fields) {
    return {type, doc, std::move(fields), nullptr};
}

constexpr Range half_turn{0, 180, true};
constexpr Range quarter_turn{0, 90};
constexpr Range pixels{1, 65536};

}  // namespace

const Field* Record::find(std::string_view name) const {
    for (const Field& field : fields)
        if (field.name == name) return &field;
    return nullptr;
}

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

const Family& camera_family() {
    const auto view = [](Field lens, std::string_view doc) {
        return record<Camera>(
            lens.name == "fov" ? "perspective" : "orthographic", doc,
            {
                field("from", &Camera::from, "Where the camera stands.", any, "scene units"),
                field("at", &Camera::at, "The point in the middle of the picture.", any, "scene units"),
                field("up", &Camera::up, "Direction that is up in the picture; not along the view."),
                lens,
                field("lens_radius", &Camera::lens_radius, "Radius of the thin lens; 0: everything is sharp.",
                      non_negative, "scene units"),
                field("focus_distance", &Camera::focus_distance,
                      "Distance of what is sharp along the axis; 0: the distance to `at`.", non_negative,
                      "scene units"),
                field("mirrored", &Camera::mirrored, "Flips left and right, for scenes of left-handed systems."),
            });
    };
    static const Family table{
        "camera",
        {
            view(field("fov", &Camera::fov, "Full vertical angle of view.", half_turn, "degrees"),
                 "Thin lens, or a pinhole."),
            view(field("height", &Camera::height, "Height of what is seen.", positive, "scene units"),
                 "Parallel view; `from` lies in the plane where rays begin."),
        },
        "perspective"};
    return table;
}

const Family& environment_family() {
    static const Family table{
        "environment",
        {
            record<ConstantEnvironment>(
                "constant", "The same radiance from everywhere.",
                {
                    color("radiance", &ConstantEnvironment::radiance, "Radiance.", non_negative, "W/(sr·m²)"),
                }),
            record<ImageEnvironment>(
                "image", "An equirectangular picture, its top at +y and its middle towards +z at rotation 0.",
                {
                    required(by_hand("file", "path", "Picture (EXR, HDR, PNG, …), relative to the scene file.")),
                    color("scale", &ImageEnvironment::scale, "Multiplies the picture."),
                    field("rotation", &ImageEnvironment::rotation, "Turn about +y.", any, "degrees"),
                    field("filter", &ImageEnvironment::filter, "Look-up between the picture's pixels."),
                }),
            record<SkyEnvironment>(
                "sky",
                "Clear sky with its sun (single scattering in air, haze and ozone, after Nishita et al. "
                "1993).",
                {
                    field("sun_elevation", &SkyEnvironment::sun_elevation, "Height of the sun above the horizon.",
                          {-90, 90}, "degrees"),
                    field("sun_azimuth", &SkyEnvironment::sun_azimuth, "Direction of the sun, from +z towards +x.", any,
                          "degrees"),
                    field("sun_angular_radius", &SkyEnvironment::sun_angular_radius,
                          "Half the apparent size of the sun.", {0, 90, true}, "degrees"),
                    field("haze", &SkyEnvironment::haze, "Dust in the air; 1: clear, more: hazier.", non_negative),
                    field("scale", &SkyEnvironment::scale, "Multiplies sky and sun.", non_negative),
                    field("sun", &SkyEnvironment::sun, "Whether the sun itself is there; false: the sky alone."),
                }),
        },
        ""};
    return table;
}

const Family& texture_family() {
    static const Family table{
        "texture",
        {
            record<ImageTexture>(
                "image", "A picture over uv; row 0, its top, lies at v = 1.",
                {
                    required(by_hand("file", "path", "Picture, relative to the scene file.")),
                    field("srgb", &ImageTexture::srgb,
                          "Whether 8-bit colours are sRGB-encoded; false for data such as normals and "
                          "roughness."),
                    field("filter", &ImageTexture::filter, "Look-up between pixels."),
                    field("wrap", &ImageTexture::wrap, "What lies outside of [0, 1]²."),
                    field("wrap_v", &ImageTexture::wrap_v, "The same, along v alone."),
                    field("uv_set", &ImageTexture::uv_set,
                          "Which texture coordinates of a mesh: 0, its `uvs`, or 1, its `second_uvs`.", {0, 1}),
                    field("scale", &ImageTexture::scale, "Multiplies uv."),
                    field("rotation", &ImageTexture::rotation,
                          "Turns uv counter-clockwise about (0, 0), after `scale`.", any, "degrees"),
                    field("offset", &ImageTexture::offset, "Added to uv last."),
                }),
            record<CheckerTexture>("checker", "Two colours in squares.",
                                   {
                                       color("color_a", &CheckerTexture::color_a, "Colour of the square at uv = 0."),
                                       color("color_b", &CheckerTexture::color_b, "Colour of its neighbours."),
                                       field("scale", &CheckerTexture::scale, "Squares per unit of uv."),
                                       field("offset", &CheckerTexture::offset, "Added to uv after `scale`."),
                                   }),
            record<FaceTexture>(
                "faces",
                "A picture of its own on each face of voxels and boxes, out of one atlas: upright on the sides; on the "
                "top its right is +x and its top −z, as on a map with north towards −z. A part of the atlas is a "
                "tile's "
                "number in `grid`, row by row from 0 at the top left, or [x, y, width, height] in pixels from the top "
                "left. A face takes the most particular key that is there: its own, `sides`, `all`.",
                {
                    required(by_hand("file", "path", "The atlas, a picture, relative to the scene file.")),
                    by_hand("grid", "tile_grid", "Columns and rows of tiles of the same size; [1, 1] without."),
                    by_hand("all", "tile", "Part of the atlas for all faces."),
                    by_hand("sides", "tile", "For the four faces that stand upright."),
                    by_hand("top", "tile", "For the face towards +y."),
                    by_hand("bottom", "tile", "For the face towards −y."),
                    by_hand("east", "tile", "For the face towards +x."),
                    by_hand("west", "tile", "For the face towards −x."),
                    by_hand("south", "tile", "For the face towards +z."),
                    by_hand("north", "tile", "For the face towards −z."),
                    field("srgb", &FaceTexture::srgb, "Whether 8-bit colours are sRGB-encoded."),
                    field("filter", &FaceTexture::filter, "Look-up between pixels; never beyond the edge of a part."),
                }),
        },
        ""};
    return table;
}

const Record& medium_record() {
    static const Record table = record<Medium>(
        "", "What fills a closed object: absorbs, scatters and glows along the way.",
        {
            color("scattering", &Medium::scattering, "Scattering coefficient σs at density 1.", non_negative,
                  "1/scene unit"),
            color("absorption", &Medium::absorption, "Absorption coefficient σa at density 1.", non_negative,
                  "1/scene unit"),
            field("g", &Medium::g, "Henyey–Greenstein asymmetry: forward above 0, backward below.", {-1, 1, true}),
            color("emission", &Medium::emission, "Radiance gained per unit length at density 1.", non_negative,
                  "W/(sr·m²) per scene unit"),
            by_hand("density", "reference", "Volume (a named geometry) whose density multiplies all this; none: 1."),
            field("density_range", &Medium::density_range,
                  "The values of `density` that mean 0 and 1, for data in units of its own: below is 0, above is more "
                  "than 1."),
            by_hand("albedo", "reference",
                    "Volume of colours, 0 to 1: so much of what would scatter still does, the rest is absorbed."),
            by_hand(
                "temperature", "reference",
                "Volume of temperatures: the medium glows as a black body; `emission` is then what white would glow "
                "at `temperature_reference`."),
            field("temperature_scale", &Medium::temperature_scale, "Kelvin for each unit of `temperature`."),
            field("temperature_offset", &Medium::temperature_offset, "Temperature where its value is 0.", any,
                  "kelvin"),
            field("temperature_reference", &Medium::temperature_reference,
                  "Temperature at which a black body's luminance counts as 1.", positive, "kelvin"),
            by_hand("erosion", "erosion", "Noise that eats the density; needs `density`."),
        });
    return table;
}

const Record& erosion_record() {
    static const Record table = record<Erosion>(
        "", "Noise that eats a density.",
        {
            required(
                field("type", &Erosion::kind,
                      "What the density is multiplied by: `value_noise`, `perlin` and `simplex`: max(0, offset + "
                      "strength · noise), the noise a fractal sum from −1 to 1; `value`: max(0, ½ + ½ · strength · "
                      "value noise) of one octave; `fbm`: max(0, 5 · strength · (½ + ½ · value noise) − 2).")),
            field("strength", &Erosion::strength, "Factor of the noise.", non_negative),
            field("offset", &Erosion::offset, "Added to the noise; not of `value` and `fbm`."),
            field("frequency", &Erosion::frequency, "Noise cells per edge of the grid's box.", positive),
            field("octaves", &Erosion::octaves, "Octaves of the fractal sum; `value` has one.", {1, 16}),
            field("gain", &Erosion::gain, "Amplitude of an octave, that of the one before being 1; ½ of `fbm`.",
                  {0.01, 1}),
            field("lacunarity", &Erosion::lacunarity, "The same of its frequency; 2 of `fbm`.", {1, 8}),
            field("drift", &Erosion::drift, "Added to the noise coordinate."),
            field("velocity", &Erosion::velocity, "How the drift changes with `time`.", any, "1/s"),
            field("time", &Erosion::time, "Time for `velocity`.", any, "seconds"),
        });
    return table;
}

const Record& outlines_record() {
    static const Record table = record<VoxelOutlines>(
        "", "Lines along the edges of voxels, drawn in a colour of their own on the surface's material.",
        {
            field("where", &VoxelOutlines::where,
                  "Around every voxel; where the visible shape or the palette index changes; where the shape does."),
            field("width", &VoxelOutlines::width, "Width of a line, half of it on either face of an edge.",
                  {0, 1, true}, "cells"),
            color("color", &VoxelOutlines::color, "Colour in place of the material's.", unit_interval),
            field("strength", &VoxelOutlines::strength, "How much of the material's colour is replaced.",
                  unit_interval),
        });
    return table;
}

const Record& waves_record() {
    static const Record table = record<VoxelWaves>(
        "",
        "A sum of directional waves on voxels of a dielectric where air lies above them: the true surface of the "
        "solid, "
        "within its cell. Waves follow deep water, each as high as it is long, its crests round.",
        {
            required(by_hand("palette", "palette_list", "Palette indices of the voxels that are water.")),
            field("height", &VoxelWaves::height, "From trough to crest where all waves meet.", {0, 1, true}, "cells"),
            field("length", &VoxelWaves::length, "Length of the longest wave; each next is 0.77 times as long.",
                  {0.1, 1e6}, "cells"),
            field("count", &VoxelWaves::count, "Number of waves.", {1, 32}),
            field("direction", &VoxelWaves::direction, "Where they run to, from +x towards +z.", any, "degrees"),
            field("spread", &VoxelWaves::spread, "How far single waves turn from it.", {0, 180}, "degrees"),
            field("time", &VoxelWaves::time, "Moves the waves on.", {-1e6, 1e6}, "s"),
            field("gravity", &VoxelWaves::gravity, "Makes long waves fast.", {0, 1e6}, "cells/s²"),
            field("seed", &VoxelWaves::seed, "Of the waves' phases.", {0, 1 << 24}),
        });
    return table;
}

const Family& geometry_family() {
    static const Family table{
        "geometry",
        {
            record_by_hand(
                "mesh", "Indexed triangles, from a file or written here; counter-clockwise is outward.",
                {
                    by_hand("file", "path",
                            "Model file relative to the scene file; it may bring several objects and their "
                            "materials."),
                    by_hand("positions", "vec3_list", "Vertices, in place of `file`."),
                    by_hand("triangles", "index3_list", "Three vertex indices each, from 0."),
                    by_hand("normals", "vec3_list", "One a vertex; without them faces are flat."),
                    by_hand("uvs", "vec2_list", "One a vertex."),
                    by_hand("second_uvs", "vec2_list", "One a vertex, for textures whose `uv_set` is 1."),
                    by_hand("tangents", "vec4_list", "One a vertex; the fourth number is the bitangent's sign."),
                    by_hand("colors", "vec4_list", "One a vertex, linear; multiply the material's colour."),
                    by_hand("slots", "index_list", "Material slot of each triangle; all 0 without."),
                }),
            record_by_hand(
                "voxels", "Unit cubes; cell (i, j, k) fills [i, i+1)×[j, j+1)×[k, k+1).",
                {
                    by_hand("file", "path",
                            "Voxel file relative to the scene file; it may bring several objects "
                            "and their materials."),
                    by_hand("frame", "frame", "Of an animated `file`, from 0; without it the first."),
                    by_hand("height", "voxel_height",
                            "Makes a picture or .hgt `file` terrain of so many voxels from black to white, "
                            "or from the lowest to the highest."),
                    by_hand("level_of_detail", "pixels",
                            "Opaque voxels are kept no finer than so many pixels of the picture, seen from its "
                            "camera: distant parts take less memory; 0, as without it: whole."),
                    by_hand("size", "size3", "Cells along x, y and z, with `cells`."),
                    by_hand("cells", "index_list",
                            "Palette indices, x fastest, then y, then z; 0 is empty, p uses "
                            "material slot p − 1."),
                    by_hand("layers", "layers",
                            "The cells as text, in place of `size` and `cells`: a list of layers "
                            "from the bottom up, each "
                            "a list of rows from z = 0 on, a character for each cell along x: `.` "
                            "or a space is empty, "
                            "1…9 then a…z are palette indices 1…35."),
                    by_hand("rounding", "rounding",
                            "Radius in cells, 0 … 0.5, of edges where air lies across both faces: one "
                            "number, or one for each palette index from 1 on; for opaque materials."),
                    by_hand("outlines", "outlines", "Lines along the edges of voxels."),
                    by_hand("waves", "waves", "Waves on top of voxels of water."),
                }),
            record_by_hand("volume",
                           "Samples on a grid. As fog, the box of a density: no surface of its own, holds an interior "
                           "medium. As a surface, the solid on one side of a level.",
                           {
                               by_hand("file", "path", "Volume file relative to the scene file."),
                               by_hand("grid", "text",
                                       "The grid of this name in `file`, as `spinel info` tells it, where there are "
                                       "several."),
                               by_hand("frame", "frame", "Of a `file` that holds a row of volumes, from 0."),
                               by_hand("size", "size3", "Samples along x, y and z, with `values`."),
                               by_hand("values", "number_list",
                                       "Values, x fastest, then y, then z; sample (i, j, k) sits at "
                                       "(i+½, j+½, k+½) of the box [0, size]."),
                               by_hand("transform", "transform",
                                       "Of the box of `values` to the geometry's own space; as that of an object."),
                               by_hand("filter", "filter",
                                       "Look-up between samples; linear, or as the file has it. `cubic` is a B-spline: "
                                       "smooth, and smoothing."),
                               by_hand("as", "volume_look",
                                       "`surface`, the default of level sets, or `fog`, that of all else. A level set "
                                       "as fog is 1 inside and falls to 0 over its band."),
                               by_hand("level", "level",
                                       "Of a surface: it lies where the look-up crosses this, in the data's units; 0."),
                               by_hand("solid", "solid_side",
                                       "Of a surface: which side of the level is solid; `below`, as of distances. The "
                                       "solid ends at the outermost samples."),
                               by_hand("precision", "precision",
                                       "How samples are kept: `full` as floats, `half` within 1/2048 of the value, `16 "
                                       "bits` and `8 bits` within 1/131070 and 1/510 of what the samples of a brick of "
                                       "8³ differ."),
                           }),
            record_by_hand("sdf", "The solid where a signed distance bound is negative.",
                           {
                               required(by_hand("expression", "sdf",
                                                "Text such as `difference(box(2,2,2), sphere(1.2))`, or a tree such as "
                                                "{\"op\": \"sphere\", \"radius\": 1}; see SDF operations.")),
                               by_hand("bounds", "bounds",
                                       "[[x,y,z],[x,y,z]], lower and upper corner of the box that clips the solid; "
                                       "needed where the expression is unbounded."),
                           }),
            record<SphereGeometry>("sphere", "About the origin.",
                                   {
                                       field("radius", &SphereGeometry::radius, "Radius.", positive, "scene units"),
                                   }),
            record<BoxGeometry>("box", "About the origin, along the axes.",
                                {
                                    field("size", &BoxGeometry::size, "Full edges.", positive, "scene units"),
                                }),
            record<PlaneGeometry>("plane", "y = 0, infinite, its normal +y.", {}),
            record<RectangleGeometry>(
                "rectangle", "In y = 0 about the origin, its normal +y.",
                {
                    field("size", &RectangleGeometry::size, "Full edges along x and z.", positive, "scene units"),
                }),
            record<SdfVoxelGeometry>(
                "sdf_voxels",
                "Cubes that are not stored: cell (i, j, k) fills [i, i+1)×[j, j+1)×[k, k+1) times `cell` and is solid "
                "where "
                "the expression is not positive in its middle. Worlds of any size cost nothing but their expression.",
                {
                    required(by_hand("expression", "sdf", "As that of an `sdf`.")),
                    by_hand("bounds", "bounds", "As those of an `sdf`: cells whose middle lies within may be solid."),
                    field("cell", &SdfVoxelGeometry::cell, "Edge of a cell.", positive, "scene units"),
                    by_hand("strata", "heights",
                            "Rising heights: cells whose middle lies below the first use material slot 0, below the "
                            "second slot 1, and so on."),
                    by_hand("outlines", "outlines", "Lines along the edges of voxels."),
                }),
        },
        ""};
    return table;
}

const Record& object_record() {
    static const Record table = record_by_hand(
        "", "A geometry at its place.",
        {
            by_hand("name", "text", "What messages and pictures of objects call it."),
            required(by_hand("geometry", "geometry_reference", "Name of a geometry, or a geometry written here.")),
            by_hand("material", "material_slots",
                    "Name of a material; null: an interface that does not scatter, the boundary of a medium; "
                    "a list: one "
                    "for each slot. Overrides the materials that a file brings; needed where none does."),
            by_hand("interior", "reference", "Medium inside (closed geometries); overrides the material's own."),
            by_hand("transform", "transform",
                    "List of steps, the first applied first: {\"scale\": 2 or [x,y,z]}, {\"rotate\": {\"axis\": "
                    "[x,y,z], "
                    "\"degrees\": 30}}, {\"translate\": [x,y,z]}; or a matrix of 12 or 16 numbers, row by row."),
        });
    return table;
}

const Family& light_family() {
    const Field name = by_hand("name", "text", "What messages call it.");
    static const Family table{
        "light",
        {
            record<PointLight>(
                "point", "The same in all directions, from a point.",
                {
                    name,
                    field("position", &PointLight::position, "Where it is.", any, "scene units"),
                    color("intensity", &PointLight::intensity, "Radiant intensity.", non_negative, "W/sr"),
                }),
            record<SpotLight>(
                "spot", "A cone of light from a point, soft between its two angles.",
                {
                    name,
                    field("position", &SpotLight::position, "Where it is.", any, "scene units"),
                    field("direction", &SpotLight::direction, "The axis of the cone."),
                    color("intensity", &SpotLight::intensity, "Radiant intensity on the axis.", non_negative, "W/sr"),
                    field("inner_angle", &SpotLight::inner_angle, "Half-angle of full intensity.", quarter_turn,
                          "degrees"),
                    field("outer_angle", &SpotLight::outer_angle, "Half-angle beyond which there is none.", {0, 90},
                          "degrees"),
                }),
            record<DirectionalLight>(
                "directional", "Parallel light, or a disc at infinity.",
                {
                    name,
                    field("direction", &DirectionalLight::direction, "Direction that the light travels in."),
                    color("irradiance", &DirectionalLight::irradiance, "On a surface that faces it.", non_negative,
                          "W/m²"),
                    field("angular_radius", &DirectionalLight::angular_radius,
                          "Half the apparent size of its disc; 0: parallel, the sun's is 0.265.", {0, 89.9}, "degrees"),
                }),
        },
        ""};
    return table;
}

const Record& scene_record() {
    static const Record table = record_by_hand(
        "", "The file.",
        {
            required(by_hand("version", "version", "Of this format: 1.")),
            by_hand("camera", "camera", "The camera."),
            by_hand("cameras", "cameras", "Several cameras by name, in place of `camera`; the first is the default."),
            by_hand("film", "film", "The picture that is made."),
            by_hand("integrator", "integrator", "How light is computed."),
            by_hand("accelerator", "accelerator", "How rays find triangles."),
            by_hand("environment", "environment", "Light from infinity; none: black."),
            by_hand("textures", "textures", "Textures by name."),
            by_hand("materials", "materials", "Materials by name."),
            by_hand("media", "media", "Media by name."),
            by_hand("geometries", "geometries", "Geometries by name."),
            by_hand("objects", "objects", "List of what stands in the scene."),
            by_hand("lights", "lights", "List of lights that have no surface."),
            by_hand("animation", "animation", "Values of this file as formulas of time."),
            by_hand("expected", "expected", "Makes the scene a test."),
        });
    return table;
}

}  // namespace spinel
