#pragma once
// A scene as plain data: what the user said, nothing computed. Things refer to each other by index into the scene's
// vectors; −1 (or kernels::NONE in a material) is "none". Build one by hand, or read a file (spinel/formats.h); then
// compile() freezes it for rendering.
//
// Space: right-handed, +y up, units are the scene's own. Angles in degrees (kernels speak radians). Colours are linear
// Rec.709.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "image/tone_map.h"
#include "kernels/scene_view.h"
#include "spinel/dvr.h"
#include "spinel/grid.h"
#include "spinel/voxels.h"

namespace spinel {

using glm::ivec2;
using glm::ivec3;
using glm::mat3;
using glm::mat4x3;
using glm::uvec3;
using glm::vec2;
using glm::vec3;
using glm::vec4;

struct PixelBuffer;  // image/pixels.h

// ------------------------------------------------------------------------------------------------- textures, materials
enum class Filter { nearest, linear, cubic };  // cubic: volumes alone
enum class Wrap { repeat, clamp, mirror };
enum class WrapV { same, repeat, clamp, mirror };  // same: as along u

struct ImageTexture {
    std::string file;                           // where it came from, for messages
    std::shared_ptr<const PixelBuffer> pixels;  // never null in a valid scene
    bool srgb = true;                           // 8-bit colour; false for data (normals, roughness) and floating point
    Filter filter = Filter::linear;
    Wrap wrap = Wrap::repeat;
    WrapV wrap_v = WrapV::same;
    int uv_set = 0;  // 0, 1: texture coordinates that a mesh has one or two sets of
    vec2 scale = {1, 1};
    float rotation = 0;  // counter-clockwise about (0, 0), after `scale`
    vec2 offset = {0, 0};
};

struct CheckerTexture {
    vec3 color_a = {0.8f, 0.8f, 0.8f};
    vec3 color_b = {0.2f, 0.2f, 0.2f};
    vec2 scale = {1, 1};  // squares per unit of uv
    vec2 offset = {0, 0};
};

// A picture of its own on every face of voxels and boxes, out of one atlas.
struct FaceTexture {
    std::string file;
    std::shared_ptr<const PixelBuffer> pixels;  // never null in a valid scene
    bool srgb = true;
    Filter filter = Filter::nearest;
    std::array<glm::ivec4, 6> faces = {};  // −x, +x, −y, +y, −z, +z: x, y, width, height in pixels from the top left
};

struct Texture {
    std::string name;
    std::variant<ImageTexture, CheckerTexture, FaceTexture> data;
};

// The kernel's own record; texture members are indices into Scene::textures, `interior` into Scene::media.
// default_material(kind) in scene/material_registry.h fills in the defaults of a kind (kernels/materials.h).
struct Material {
    std::string name;
    kernels::Material values;
};

// ----------------------------------------------------------------------------------------------------------------
// media
// How samples are kept for rendering. The 16 and 8 bits lie between the least and the greatest sample of each brick of
// 8³: wrong by at most 1/131070 or 1/510 of what these differ; half is wrong by at most 1/2048 of the value.
enum class GridPrecision { full, half, bits16, bits8 };

// A field on a regular grid, in the data's own units (Hounsfield, kelvin, densities, …).
struct Grid {
    std::string name;
    GridPointer samples;                // never null in a valid scene
    mat4x3 index_to_local = mat4x3(1);  // index space to the space of the object that holds it
    Filter filter = Filter::linear;
    GridPrecision precision = GridPrecision::full;
    float background = 0;    // the value outside of the box
    bool level_set = false;  // distances from a surface, negative inside, that end at ±background
    std::string unit = {};   // as the file names it, for people; empty: it does not
};

// Noise that eats a density: density = grid · max(0, offset + strength·noise), see kernels/density.h.
struct Erosion {
    // value and fbm are the bunny's, one octave and a fractal sum, their offsets given; the others have one of their
    // own.
    enum class Kind { none, value, fbm, value_noise, perlin, simplex };
    Kind kind = Kind::none;
    float strength = 1;
    float offset = 0;      // of the last three
    float frequency = 12;  // per edge of the grid's box
    int octaves = 4;
    float gain = 0.5f;     // of the last three, of each octave's amplitude to the one's before …
    float lacunarity = 2;  // … and of its frequency
    vec3 drift = {0, 0, 0};
    vec3 velocity = {0, 0, 0};  // the drift grows by this in a second …
    float time = 0;             // … of so many
};

struct Medium {
    std::string name;
    vec3 scattering = {0, 0, 0};   // σs per unit length at density 1
    vec3 absorption = {0, 0, 0};   // σa per unit length at density 1
    float g = 0;                   // Henyey–Greenstein asymmetry, −1 … 1
    vec3 emission = {0, 0, 0};     // radiance per unit length at density 1
    int grid = -1;                 // −1: homogeneous; else its density is that of
    vec2 density_range = {0, 1};   // the grid's values that mean density 0 and 1; below is 0, above is more than 1
    int albedo = -1;               // a grid of colours: σs·colour scatters, σs·(1 − colour) absorbs
    int temperature = -1;          // a grid by which the medium glows as a black body; the emission is then that …
    float temperature_scale = 1;   // kelvin for each unit of it
    float temperature_offset = 0;  // kelvin
    float temperature_reference = 1500;  // … at so many kelvin
    Erosion erosion = {};
};

// -----------------------------------------------------------------------------------------------------------
// geometries
struct MeshGeometry {
    std::vector<vec3> positions;
    std::vector<uvec3> triangles;
    std::vector<vec3> normals;         // empty, or one a vertex
    std::vector<vec2> uvs;             // empty, or one a vertex
    std::vector<vec2> second_uvs;      // empty, or one a vertex, for textures of uv_set 1; empty: `uvs` serve them
    std::vector<vec4> tangents;        // empty, or one a vertex; w is the bitangent's sign
    std::vector<vec4> colors;          // empty, or one a vertex, linear; multiplies the base colour
    std::vector<std::uint32_t> slots;  // empty (all 0), or the material slot of each triangle
};

// Cell (i,j,k) fills [i,i+1)×[j,j+1)×[k,k+1) of local space. Palette index p uses material slot p − 1.
struct VoxelOutlines {
    enum class Where { voxels, changes, shape };  // every edge; where shape or palette index ends; where the shape does
    Where where = Where::voxels;
    float width = 0.06f;  // cells; half on either face of an edge
    vec3 color = {0, 0, 0};
    float strength = 1;  // 0 … 1: how much of the surface's own colour is replaced
};

// Waves on water: directional waves from the longest on, their lengths in a geometric row, as high as they are long.
struct VoxelWaves {
    std::vector<int> palette;  // indices of the voxels that are water
    float height = 0.3f;       // from trough to crest if all waves meet, cells, below 1
    float length = 6;          // of the longest wave, cells
    int count = 6;             // of waves
    float direction = 30;      // that they run to, from +x towards +z
    float spread = 50;         // to both sides of it
    float time = 0;            // seconds
    float gravity = 9.81f;     // cells/s²: deep water, ω² = g·k
    int seed = 0;              // of the phases
};

struct VoxelGeometry {
    VoxelTreePointer tree;             // never null in a valid scene
    float level_of_detail = 0;         // pixels: what is opaque is kept no finer than this in the picture; 0: whole
    std::vector<float> rounding = {};  // radius of edges in cells, 0 … 0.5: one for all, or one a palette index
    std::optional<VoxelOutlines> outlines = {};
    std::optional<VoxelWaves> waves = {};
};

// The box of a density grid: has no surface of its own, holds an object's interior medium. Or the solid where the grid
// is below a level, whose surface is that of the look-up itself.
struct VolumeGeometry {
    int grid = -1;
    bool surface = false;
    float level = 0;           // in the data's units, of a surface
    bool solid_above = false;  // of a surface: the solid is where the grid is above the level
};

// Expression tree of a signed distance bound, negative inside. What each operation takes: geometry/sdf.
struct SdfNode {
    std::string op;              // "sphere", "union", "translate", …
    std::vector<float> numbers;  // the operation's parameters, in the order of its table
    std::vector<SdfNode> children;
};
struct SdfGeometry {
    SdfNode root;
    std::optional<std::pair<vec3, vec3>> bounds;  // needed where the expression is unbounded; clips the solid
};

// Voxels that are not stored: cell (i,j,k) fills [i,i+1)×[j,j+1)×[k,k+1) times `cell` and is solid if the SDF is not
// positive in its middle.
struct SdfVoxelGeometry {
    SdfGeometry sdf;
    float cell = 1;
    std::vector<float> strata = {};  // heights, rising; material slot i + 1 begins at strata[i]
    std::optional<VoxelOutlines> outlines = {};
};

struct SphereGeometry {
    float radius = 1;  // about the origin
};
struct BoxGeometry {
    vec3 size = {1, 1, 1};  // full edges, about the origin
};
struct PlaneGeometry {};  // y = 0, infinite, normal +y
struct RectangleGeometry {
    vec2 size = {1, 1};  // full edges along x and z, about the origin, normal +y
};

struct Geometry {
    std::string name;
    std::variant<MeshGeometry, VoxelGeometry, VolumeGeometry, SdfGeometry, SphereGeometry, BoxGeometry, PlaneGeometry,
                 RectangleGeometry, SdfVoxelGeometry>
        data;
};

// ------------------------------------------------------------------------------------------------------ objects,
// lights
struct Object {
    std::string name;
    int geometry = -1;
    mat4x3 transform = mat4x3(1);  // object to world, affine, not singular
    std::vector<int> materials;  // one for each slot; a single one serves all; −1: an interface that does not scatter
    int interior = -1;           // medium inside (closed geometries); overrides the material's own
};

struct PointLight {
    vec3 position = {0, 0, 0};
    vec3 intensity = {1, 1, 1};  // W/sr
};
struct SpotLight {
    vec3 position = {0, 0, 0};
    vec3 direction = {0, -1, 0};
    vec3 intensity = {1, 1, 1};  // W/sr on the axis
    float inner_angle = 20;      // half-angle of full intensity
    float outer_angle = 30;      // half-angle beyond which there is none
};
struct DirectionalLight {
    vec3 direction = {0, -1, 0};  // that the light travels in
    vec3 irradiance = {1, 1, 1};  // W/m² on a surface that faces it
    float angular_radius = 0;     // of the disc it comes from; the sun's is 0.265
};
struct Light {
    std::string name;
    std::variant<PointLight, SpotLight, DirectionalLight> data;
};

struct ConstantEnvironment {
    vec3 radiance = {1, 1, 1};
};
struct ImageEnvironment {
    std::string file;
    std::shared_ptr<const PixelBuffer> pixels;  // equirectangular
    vec3 scale = {1, 1, 1};
    float rotation = 0;  // about +y
    Filter filter = Filter::linear;
};
// Clear sky with its sun: single scattering in air, haze and ozone, after Nishita et al. 1993 (kernels/sky.h).
struct SkyEnvironment {
    float sun_elevation = 40;  // above the horizon
    float sun_azimuth = 135;   // from +z (south of a viewer who looks along −z) towards +x
    float sun_angular_radius = 0.265f;
    float haze = 1;   // 1: clear air; more: hazier
    float scale = 1;  // of sky and sun together
    bool sun = true;  // false: the sky alone
};
using EnvironmentData = std::variant<std::monostate, ConstantEnvironment, ImageEnvironment, SkyEnvironment>;

// ------------------------------------------------------------------------------------------------------- camera and
// film
struct Camera {
    std::string name;
    enum class Kind { perspective, orthographic };
    Kind kind = Kind::perspective;
    vec3 from = {0, 0, 5};
    vec3 at = {0, 0, 0};
    vec3 up = {0, 1, 0};
    float fov = 45;            // vertical, full angle (perspective)
    float height = 2;          // of the picture in world units (orthographic)
    float lens_radius = 0;     // world units; 0: everything is sharp
    float focus_distance = 0;  // 0: the distance to `at`
    bool mirrored = false;     // flips left and right, for scenes made for left-handed systems
};

enum class PixelFilter { box, tent, gaussian, blackman_harris };

struct Film {
    ivec2 size = {1280, 720};
    float exposure = 0;  // stops
    ToneMap tone_map = ToneMap::agx;
    PixelFilter filter = PixelFilter::blackman_harris;
    float filter_radius = 1.5f;  // pixels; a box of radius 0.5 is the pixel itself
};

// How `single-scatter` marches; world units.
struct MarchOptions {
    enum class Integration { energy_conserving, naive };
    Integration integration = Integration::energy_conserving;
    float step = 0;                  // along camera rays; 0: a 256th of the scene's diagonal
    float shadow_step = 0;           // from within media to lights; 0: four steps
    float shadow_reach = 0;          // how far media are looked at on that way; 0: all the way
    float surface_shadow_step = 0;   // from surfaces to lights; 0: shadow_step
    float surface_shadow_reach = 0;  // 0: all the way
    float light_reach = 0;           // points and spots fade to nothing so far away; 0: they do not
    bool jitter = true;              // marches begin at a random part of a step
    bool shortcuts = true;           // false: every step of every march is taken
};

// What the integrator should do; the command line overrides it.
// How shadow rays through media on grids estimate what is left of the light: kernels/path_settings.h, in its order.
enum class Transmittance { ratio, residual, delta };

struct IntegratorSettings {
    std::string name = "path";
    int spp = 64;     // samples per pixel
    float clamp = 0;  // most that one path may add by indirect light, against sparks; 0: none, unbiased
    int max_bounces =
        -1;  // scattering events of a path; 0: only light that is seen directly; −1: Russian roulette alone ends it
    Transmittance transmittance = Transmittance::ratio;
    bool equiangular = true;  // places along rays through media near to points and spots are sampled, too
    // Of the previews alone:
    float ao_radius = 0;    // world units: reach of ambient occlusion by rays; 0: a twentieth of the scene's diagonal
    float ao_strength = 1;  // 0 … 1
    float glow = 0;         // of the halo about voxels that emit; 0: none
    float glow_radius = 0;  // world units; 0: four voxels of the set
    MarchOptions march;     // of single-scatter
    DvrOptions dvr;         // of dvr
    // Of `heatmap` and `depth`:
    int heat_counter = 0;   // 0: all together, 1: nodes and cells, 2: boxes, 3: triangles
    float heat_most = 150;  // what has the hottest colour
    float depth_end = 0;    // world units: what is black; 0: the far end of the scene
};

// What meshes are built into and how rays are tested against their triangles; pictures are the same but for rounding.
struct AcceleratorSettings {
    std::string structure = "wide-bvh8";       // `spinel list accelerators`
    std::string triangle_test = "watertight";  // `spinel list triangle-tests`
    std::string preset = {};                   // of structures that have some: "fast", "balanced", "high"; "": the last
};

// A scene file that is a test carries what it must give: the mean over the picture.
struct Expected {
    vec3 mean = {0, 0, 0};
    float tolerance = 0.005f;  // relative
};

// What a model file says of the place that its objects stand in, for pictures of the bare model (scene/complete.h).
// Nothing else looks at it.
struct Surroundings {
    bool ground = true;
    vec3 ground_color = {0.42f, 0.41f, 0.40f};
    float fog_density = 0;  // extinction per unit length; 0: none
    vec3 fog_color = {1, 1, 1};
    float fog_g = 0;
};

struct Scene {
    std::vector<Texture> textures;
    std::vector<Material> materials;
    std::vector<Grid> grids;
    std::vector<Medium> media;
    std::vector<Geometry> geometries;
    std::vector<Object> objects;
    std::vector<Light> lights;
    EnvironmentData environment;
    std::vector<Camera> cameras;  // the first is the default
    Film film;
    IntegratorSettings integrator;
    AcceleratorSettings accelerator;
    std::optional<Expected> expected;
    Surroundings surroundings;
    std::vector<std::string> notes;  // what a reader guessed or left out, a sentence each; nothing depends on it
};

}  // namespace spinel
