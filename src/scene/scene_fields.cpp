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

namespace {

constexpr Range half_turn{0, 180, true};
constexpr Range quarter_turn{0, 90};

}  // namespace

const Field* Record::find(std::string_view name) const {
    for (const Field& field : fields)
        if (field.name == name) return &field;
    return nullptr;
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
