#ifndef SPINEL_KERNELS_SCENE_VIEW_H
#define SPINEL_KERNELS_SCENE_VIEW_H
// What a kernel sees of a compiled scene: flat arrays of plain records, the same bytes on every device.
// Records refer to each other by index into the arrays of SceneView; NONE is "no such thing".
#include "ray.h"
KERNELS_BEGIN

// ---------------------------------------------------------------------------------------------------------- geometry
const uint GEOMETRY_MESH = 0u;
const uint GEOMETRY_VOXELS = 1u;
const uint GEOMETRY_SDF = 2u;
const uint GEOMETRY_SPHERE = 3u;     // radius 1 about the origin
const uint GEOMETRY_BOX = 4u;        // [-1, 1]³
const uint GEOMETRY_PLANE = 5u;      // y = 0, infinite, normal +y
const uint GEOMETRY_RECTANGLE = 6u;  // y = 0, |x| ≤ 1, |z| ≤ 1, normal +y

// Binary bounding volume hierarchy. Interior (count = 0): children are nodes first and first + 1. Leaf: primitives
// [first, first + count). Child and primitive indices are relative to the owner's base.
struct BvhNode {
    vec3 lower;
    uint first;
    vec3 upper;
    uint count;
};
BUFFER(BvhNodes, BvhNode)

// Vertices gathered in the order of the BVH's leaves: one indirection fewer in the loop that matters.
struct Triangle {
    vec3 a;
    vec3 b;
    vec3 c;
};
BUFFER(Triangles, Triangle)

struct TriangleInfo {
    uvec3 vertices;  // relative to the mesh's first
    uint slot;       // material slot within the instance's table
    uint primitive;  // the triangle's index in the user's mesh
};
BUFFER(TriangleInfos, TriangleInfo)

BUFFER(Vec2s, vec2)
BUFFER(Vec3s, vec3)
BUFFER(Vec4s, vec4)

// A node of a kd-tree. Interior: children are nodes link >> 3 and the one behind it, below and above `split` along axis
// (link >> 1) & 3. Leaf (link & 1): `split` holds the bits of the number of references, which begin at link >> 3.
struct KdNode {
    float split;
    uint link;
};
BUFFER(KdNodes, KdNode)

// A node of a hierarchy of spheres; first and count as in BvhNode.
struct SphereNode {
    vec3 center;
    float radius;
    uint first;
    uint count;
};
BUFFER(SphereNodes, SphereNode)

// A grid of cells, x fastest; each is a word: 0 is empty, GRID_REFINED and a number is another grid (relative to the
// mesh's first), anything else is where a list of triangles begins among the mesh's references, its length first. The
// word before the cells of a grid that stands in a cell says where the list of that whole cell begins. The mesh's first
// word counts its grids.
const uint GRID_REFINED = 0x80000000u;
struct MeshGrid {
    vec3 lower;
    uint cell_first;  // relative to the mesh's first reference
    vec3 cell;        // edges of one
    vec3 inverse_cell;
    ivec3 size;
};
BUFFER(MeshGrids, MeshGrid)

// The affine map that carries a triangle to (0,0,0), (1,0,0), (0,1,0), in rows.
struct UnitTriangle {
    vec4 x_row;
    vec4 y_row;
    vec4 z_row;
};
BUFFER(UnitTriangles, UnitTriangle)

// A wide hierarchy (mesh_wide.h) consists of units of eight lanes. An interior node is WIDE_NODE_UNITS of them: the
// planes lower x, upper x, lower y, upper y, lower z, upper z of eight boxes, then their references; boxes that are not
// used are inverted. A reference's upper four bits count the blocks of a leaf, 0: a node; the lower ones say where it
// begins, in units from the root. A block is WIDE_BLOCK_UNITS: rows of four lanes, x, y and z of the vertices a, b, c
// of four triangles, then their indices; where there are fewer, the last is repeated.
struct ALIGNED(32) WideUnit {
    float lanes[8];
};
BUFFER(WideUnits, WideUnit)
const uint WIDE_NODE_UNITS = 7u;
const uint WIDE_BLOCK_UNITS = 5u;
// The compact kind of it (mesh_compact.h) takes the same units as words of 32 bits, and references count in steps of
// COMPACT_STEP words.
const uint COMPACT_STEP = 4u;

// How rays go through a mesh, and where its structure stands (mesh.h).
const uint MESH_WALK_BVH2 = 0u;       // BvhNode, with a stack
const uint MESH_WALK_STACKLESS = 1u;  // BvhNode in depth-first order, with links
const uint MESH_WALK_KD = 2u;         // KdNode
const uint MESH_WALK_GRID = 3u;       // MeshGrid
const uint MESH_WALK_SPHERES = 4u;    // SphereNode
const uint MESH_WALK_WIDE = 5u;       // WideUnit
const uint MESH_WALK_COMPACT = 6u;    // WideUnit as words
const uint MESH_WALK_JOINED = 7u;     // nothing of its own: rays walk a mesh that it is joined into (Instance)

// How rays are tested against its triangles (mesh_triangles.h).
const uint TRIANGLE_WATERTIGHT = 0u;
const uint TRIANGLE_MOLLER_TRUMBORE = 1u;
const uint TRIANGLE_PLANE = 2u;
const uint TRIANGLE_UNIT = 3u;     // of UnitTriangles
const uint TRIANGLE_INDEXED = 4u;  // watertight, vertices fetched by index

// Attributes of vertices are streams of their own: what a mesh does not have takes no room and no time.
struct Mesh {
    vec3 lower;  // of the triangles
    vec3 upper;
    uint walk;             // MESH_WALK_…
    uint triangle_test;    // TRIANGLE_…
    uint node_first;       // into the array of the walk
    uint reference_first;  // into SceneView::words, of walks that refer to triangles by number
    uint test_first;       // into UnitTriangles or SceneView::positions, of tests that need them
    uint triangle_first;   // also indexes TriangleInfos
    uint triangle_count;
    uint normal_first;     // the first vertex's in SceneView::normals; NONE: the geometric normal serves
    uint uv_first;         // NONE: (0, 0)
    uint second_uv_first;  // of a second set; NONE: the first set serves
    uint tangent_first;    // xyz along +u, w the bitangent's sign; NONE: no tangents
    uint color_first;      // linear, multiplies the base colour, w is unused; NONE: white
};
BUFFER(Meshes, Mesh)

// A node of a 64-tree of voxels: a cube of 4×4×4 children, child (i,j,k) in bit i + 4·j + 16·k. The link's upper two
// bits say what the children in the mask are, the lower ones where:
const uint VOXEL_LINK_KIND = 0xc0000000u;
const uint VOXEL_LINK_CHILDREN = 0u;         // nodes, in the order of their bits, from this one on
const uint VOXEL_LINK_SOLID = 0x40000000u;   // solid cubes of one palette index, which stands here
const uint VOXEL_LINK_BYTES = 0x80000000u;   // voxels, their palette indices from this word on, four a word …
const uint VOXEL_LINK_HALVES = 0xc0000000u;  // … or two a word, the lowest bits first
struct VoxelNode {
    uint mask_low;
    uint mask_high;
    uint link;
};

BUFFER(VoxelNodes, VoxelNode)

// Voxels. Cell (i,j,k) fills [i,i+1)×[j,j+1)×[k,k+1) and holds a palette index; 0 is empty space.
// Palette index p uses material slot p − 1 of the instance. Links of nodes are relative to what stands here.
struct VoxelGrid {
    ivec3 size;
    uint level_count;  // the root is 4^level_count cells wide
    VoxelNode root;
    uint node_first;
    uint reference_first;  // into SceneView::words; NONE: children stand in a row
    uint palette_first;    // into SceneView::words
    uint walk;             // VOXEL_WALK_…
    uint shape_first;      // into SceneView::floats, one for each palette index from 1 on (voxel_shapes.h)
    uint wave_first;       // into SceneView::floats (voxel_waves.h); NONE: none
    uint wave_count;
    uint line_first;    // into SceneView::floats (voxel_lines.h); NONE: no outlines
    uint sdf;           // into SceneView::sdfs: cells are not stored, but solid where this is ≤ 0 in their middle
    vec3 sdf_origin;    // where the corner of cell (0,0,0) lies in the space of the SDF …
    float sdf_cell;     // … and the edge of a cell there
    uint strata_first;  // into SceneView::floats: heights in that space above which the next palette index begins
    uint strata_count;
};
BUFFER(VoxelGrids, VoxelGrid)

const uint VOXEL_WALK_TREE = 0u;    // voxels fill their cells: voxels.h
const uint VOXEL_WALK_SHAPES = 1u;  // some fill a part only: voxel_shapes.h
const uint VOXEL_WALK_SDF = 2u;     // sdf_voxels.h

// What a voxel, or a node of a 64-tree with all that is in it, shows from afar (voxel_mip.h).
struct VoxelMip {
    uint coverage;   // of its cube seen along x, y and z, a byte each, 255: all; the highest: how much of that emits
    uint albedo;     // mean of what covers it, the square root of each channel in a byte
    vec3 emission;   // mean radiance of what emits
    float emitting;  // part of the cube's volume that emits
};
BUFFER(VoxelMips, VoxelMip)

// One instruction of an SDF tape; sdf.h defines the operations. Registers: points p0… and values v0….
struct SdfOp {
    uint op;
    uint target;  // register written
    uint a;       // registers read
    uint b;
    vec4 data0;  // constants of the operation
    vec4 data1;
};
BUFFER(SdfOps, SdfOp)

struct Sdf {
    vec3 lower;  // bounds of the solid in local space
    uint op_first;
    vec3 upper;
    uint op_count;
    float lipschitz;  // |f(p) − f(q)| ≤ lipschitz·|p − q| inside the bounds: a step of |f| / lipschitz is safe
    uint result;      // value register that holds f at the end
    float longest_crawl;  // how far a march may go blindly where f is next to nothing: what is thinner may be missed
};
BUFFER(Sdfs, Sdf)

// A placed geometry. Plain transforms, so that a ray is carried by two products and t keeps its meaning.
struct Instance {
    mat4x3 object_to_world;
    mat4x3 world_to_object;
    uint geometry_kind;
    uint geometry;     // index into the kind's array
    uint slot_first;   // into SceneView::slots
    uint light_first;  // first light of this instance's emitters, NONE if none has a light
    uint light_count;
    uint flags;   // INSTANCE_…
    uint object;  // the user's object, for AOVs
    // Where its surface may lie in the same place as that of another instance, in world space.
    uint contact_first;  // into SceneView::contacts
    uint contact_count;
    // Meshes that lie about each other in one local space are walked as one: the first of their instances leads, and
    // the others are not asked by themselves.
    uint joined_mesh;   // of a leader: the mesh of all their triangles, which follow each other
    uint member_first;  // into SceneView::words: their instances, in order
    uint member_count;  // 0: this instance is no leader, and rays walk its own geometry
};
BUFFER(Instances, Instance)

// Where surfaces of an instance and of others may be in the same place, in world space.
struct Contact {
    vec3 lower;
    vec3 upper;
    float error;  // bound of the rounding error of any of their positions there
};
BUFFER(Contacts, Contact)

const uint INSTANCE_ENCLOSES = 2u;  // has an interior, and is not a voxel set
const uint INSTANCE_PASS_THROUGH =
    1u;  // some of it does not stop a shadow ray for sure: an interface without a material, or opacity < 1

// What a material slot of an instance means.
struct Slot {
    uint material;  // NONE: an interface that does not scatter, the boundary of a medium
    uint interior;  // what is inside, NONE: opaque or thin
};
BUFFER(Slots, Slot)

// ---------------------------------------------------------------------------------------------------- media, volumes
// What lies behind a surface. A path keeps a list of those it is inside of (interior.h). Equal interiors share one
// index.
struct Interior {
    uint medium;   // NONE: clear
    float ior;     // index of refraction; 0: not a dielectric, a mere volume whose extinction adds to what it overlaps
    int priority;  // where dielectrics overlap, the highest wins; a mere volume has 0 and yields to dielectrics above
};
BUFFER(Interiors, Interior)

const uint MEDIUM_ABSORBS_ONLY = 1u;  // homogeneous, no scattering, no emission: attenuated in closed form

struct Medium {
    vec3 scattering;  // σs per unit length at density 1
    float g;          // Henyey–Greenstein asymmetry, −1 … 1
    vec3 absorption;  // σa per unit length at density 1
    uint grid;        // into SceneView::grids; NONE: density 1 everywhere
    vec3 emission;    // radiance per unit length at density 1: the source term, not multiplied by σa
    uint flags;
    mat4x3 world_to_grid;  // to the grid's index space, where sample i sits at i + ½
    float density_scale;   // density = max(0, density_scale · the grid's value + density_offset), then eroded
    float density_offset;
    uint noise;  // NOISE_… that eats the density: times max(0, noise_offset + noise_scale · noise in [−1, 1])
    float noise_offset;  // (density.h)
    float noise_scale;
    float noise_frequency;  // per unit of the grid's [0,1]³ box
    uint noise_octaves;
    float noise_gain;        // of an octave's amplitude to the one's before
    float noise_lacunarity;  // the same of its frequency
    vec3 noise_drift;        // added to the noise coordinate
    ivec3 majorant_size;     // coarse cells of the density, over the grid's box
    uint majorant_first;     // into SceneView::floats: for each cell the greatest density in it …
    uint minorant_first;     // … and the smallest
    float majorant_cell;     // edge of a cell, in samples
    float emission_rate;     // collisions per unit length at density 1, at least, by which emission is found
    uint albedo_grid;  // colours that split the extinction: σs·colour scatters, σs·(1 − colour) absorbs; NONE
    mat4x3 world_to_albedo;
    uint temperature_grid;  // NONE; else the emission is times that of a black body at this temperature …
    mat4x3 world_to_temperature;
    float temperature_scale;  // … entry scale · the grid's value + offset of the table of colours …
    float temperature_offset;
    uint temperature_first;  // … in SceneView::floats, rgb, of TEMPERATURE_ENTRIES
};
BUFFER(Media, Medium)

const uint NOISE_NONE = 0u;
const uint NOISE_VALUE = 1u;
const uint NOISE_PERLIN = 2u;
const uint NOISE_SIMPLEX = 3u;

const uint TEMPERATURE_ENTRIES = 1024u;

const uint FILTER_NEAREST = 0u;
const uint FILTER_TRILINEAR = 1u;
const uint FILTER_TRICUBIC = 2u;  // B-spline: smooth, never beyond the samples around; volumes alone

const uint GRID_FLOAT = 0u;
const uint GRID_HALF = 1u;
const uint GRID_BITS16 = 2u;  // between the least and the greatest sample of the brick
const uint GRID_BITS8 = 3u;

// Samples as bricks of 8³, equal ones of a single value shared (grids.h).
struct DensityGrid {
    ivec3 size;
    ivec3 brick_counts;
    uint table_first;     // into SceneView::words: of each brick, x fastest, the first word
    uint storage;         // GRID_…
    uint channel_words;   // from one channel of a brick to the next
    uint filter_kind;     // FILTER_…
    float background;     // the value outside of the box
    ivec3 majorant_size;  // coarse cells
    uint majorant_first;  // into SceneView::floats: for each coarse cell the greatest value a look-up in it can give …
    uint minorant_first;  // … and the smallest
    int majorant_cell;    // edge of a coarse cell, in samples
};
BUFFER(DensityGrids, DensityGrid)

// ------------------------------------------------------------------------------------------------ materials, textures
// One record serves every material; which members count depends on the kind (kernels/materials/*.h say which).
struct Material {
    uint kind;                // MATERIAL_… of materials.h
    vec3 color;               // reflectance, or F0 of a metal, linear Rec.709
    uint color_texture;       // multiplies color
    float roughness;          // perceptual, 0 … 1: GGX α = roughness²; Fujii's σ of diffuse, 0 … 1
    uint roughness_texture;   // channel g multiplies roughness (glTF)
    float metallic;           // 0 … 1
    uint metallic_texture;    // channel b multiplies metallic (glTF)
    float ior;                // of dielectrics, coats and the dielectric part of principled
    vec3 eta;                 // complex index of a metal: η …
    vec3 k;                   // … and κ; all zero: the metal is given by color and edge_color
    vec3 edge_color;          // a metal's reflectance towards grazing, 1: Schlick-like
    vec3 absorption;          // inside a dielectric, per unit length (Beer–Lambert)
    int priority;             // of a dielectric where solids overlap
    uint interior;            // medium inside a dielectric: index into Scene::media; NONE: clear
    vec3 emission;            // radiance
    uint emission_texture;    // multiplies emission
    uint emission_two_sided;  // 0: only the side of the outward normal emits
    uint normal_texture;      // tangent space, NONE: none
    float normal_scale;
    float opacity;                // 0 … 1: chance that a ray meets the surface at all
    uint opacity_texture;         // channel a multiplies opacity
    float coat;                   // 0 … 1: of principled, how much of it lies under a clear coat …
    uint coat_texture;            // … channel r multiplies coat
    float coat_roughness;         // perceptual
    uint coat_roughness_texture;  // channel g multiplies coat_roughness
    float transmission;           // 0 … 1: of principled, how much of its base is a thin clear wall …
    uint transmission_texture;    // … channel r multiplies transmission
};
BUFFER(Materials, Material)

const uint TEXTURE_RGBA8 = 0u;    // one word a texel, r in the low byte
const uint TEXTURE_RGBA16F = 1u;  // two words a texel, halves r,g | b,a
const uint TEXTURE_CHECKER = 2u;  // color_a and color_b alternate over unit squares of uv·scale

const uint WRAP_REPEAT = 0u;
const uint WRAP_CLAMP = 1u;
const uint WRAP_MIRROR = 2u;

struct Texture {
    uint kind;  // TEXTURE_…
    uint width;
    uint height;
    uint word_first;   // into SceneView::words, row 0 at v = 1 (the top of the image)
    uint srgb;         // 1: rgb is sRGB-encoded
    uint filter_kind;  // FILTER_NEAREST or FILTER_TRILINEAR (bilinear here)
    uint wrap_u;       // WRAP_…
    uint wrap_v;
    uint uv_set;  // 0, 1: which texture coordinates of a mesh
    vec2 row_u;   // the place in the picture is (row_u·uv, row_v·uv) + offset
    vec2 row_v;
    vec2 offset;
    vec3 color_a;
    vec3 color_b;
    uint face_first;  // into SceneView::words, NONE: the whole picture over uv; else six rectangles of texels x, y,
                      // width, height, row 0 at the top, one for each face 2·axis + (1 if on the + side)
};
BUFFER(Textures, Texture)

// --------------------------------------------------------------------------------------------------------------- light
const uint LIGHT_POINT = 0u;
const uint LIGHT_SPOT = 1u;
const uint LIGHT_DIRECTIONAL = 2u;  // parallel light, or a disc of angular radius at infinity (the sun)
const uint LIGHT_ENVIRONMENT = 3u;
const uint LIGHT_TRIANGLE = 4u;       // one triangle of an emissive mesh
const uint LIGHT_PARALLELOGRAM = 5u;  // a face of an emissive voxel or box, a rectangle
const uint LIGHT_SPHERE = 6u;

struct Light {
    uint kind;
    uint instance;  // of an emissive surface, else NONE
    uvec2 key;      // its primitive: triangle in the BVH's order, or box face; voxels: voxel_light_key()
    uint material;  // whose emission it sends, NONE: radiance below
    vec3 position;  // point, spot; a corner; the sphere's centre
    vec3 u;         // edges from the corner (triangle: to vertices 1 and 2)
    vec3 v;
    vec3 direction;   // that light travels in (spot, directional); outward unit normal of a flat emitter
    vec3 radiance;    // [W/(sr·m²)]; point, spot: intensity [W/sr]; directional without size: irradiance [W/m²]
    float radius;     // sphere; directional: angular radius [rad], 0: a delta
    float cos_inner;  // spot: full intensity inside, none outside, smooth between
    float cos_outer;
    float area;  // of a flat emitter
    uint two_sided;
};
BUFFER(Lights, Light)

// Alias method (Walker 1974, Vose 1991): one uniform number picks a light in O(1).
struct AliasEntry {
    float threshold;  // keep this entry if the fraction is below
    uint alias;
    float probability;  // of this entry in all
};
BUFFER(AliasEntries, AliasEntry)

// Equirectangular radiance; row 0 is straight up (+y), u = 0 looks along −z and grows towards +x … with a
// piecewise-constant density for sampling: row by `marginal`, column by `conditional`.
struct Environment {
    uint width;  // 0: no environment, nothing but black
    uint height;
    uint radiance_first;     // floats, rgb interleaved
    uint marginal_first;     // floats, height + 1 values of the cumulative distribution
    uint conditional_first;  // floats, (width + 1) for each row
    uint light;              // its index in lights, NONE: not sampled
    uint filter_kind;        // FILTER_…
    mat3 world_to_local;     // rotation about +y, as the user asked
};

// The scene's light as the preview integrators see it (preview_shade.h).
struct PreviewLight {
    vec3 to_sun;     // unit
    vec3 sun;        // irradiance on a surface that faces it [W/m²]
    float sun_tan;   // of its angular radius
    vec3 sky_above;  // irradiance over π of a surface that faces up, by the environment alone …
    vec3 sky_below;  // … and of one that faces down
};

BUFFER(Words, uint)
BUFFER(Floats, float)

// -------------------------------------------------------------------------------------------------------------- camera
const uint CAMERA_PERSPECTIVE = 0u;
const uint CAMERA_ORTHOGRAPHIC = 1u;

struct Camera {
    uint kind;
    mat4x3 camera_to_world;  // looks along −z, +y up, +x right
    float half_height;       // of the image plane: tan(fov/2) at distance 1, or world units when orthographic
    float lens_radius;       // 0: a pinhole
    float focus_distance;    // along the axis
    uvec2 resolution;        // of the whole film, a crop included
    float filter_radius;     // of the pixel filter, pixels
    uint filter_kind;        // PIXEL_FILTER_… of camera.h
    uint locate_rays;        // 1: not all rays start inside of the same things
};

// The whole scene.
struct SceneView {
    Instances instances;
    BvhNodes instance_nodes;  // top-level BVH; its leaves index instance_order
    Words instance_order;
    Contacts contacts;
    Slots slots;
    BvhNodes nodes;  // of all meshes
    KdNodes kd_nodes;
    SphereNodes sphere_nodes;
    MeshGrids mesh_grids;
    WideUnits wide_units;
    UnitTriangles unit_triangles;
    Vec3s positions;  // of vertices, of meshes whose test fetches them by index
    Triangles triangles;
    TriangleInfos triangle_infos;
    Vec3s normals;  // of vertices, as the next three
    Vec2s uvs;
    Vec4s tangents;
    Vec4s colors;
    Meshes meshes;
    VoxelGrids voxel_grids;
    VoxelNodes voxel_nodes;
    VoxelMips voxel_mips;
    SdfOps sdf_ops;
    Sdfs sdfs;
    Interiors interiors;
    Media media;
    DensityGrids grids;
    Materials materials;
    Textures textures;
    Lights lights;
    AliasEntries light_table;  // as many entries as lights
    Words words;               // voxels, textures
    Floats floats;             // densities, environment
    Environment environment;
    PreviewLight preview_light;
    Camera camera;
    uint instance_count;
    uint bounded_count;    // instances under the top-level BVH
    uint unbounded_count;  // planes: instance_order[bounded_count …] are tested one by one
    uint light_count;
    uint infinite_light_count;  // environment and directional lights stand first in lights
    uint pass_through_count;    // instances a shadow ray must look at one by one; 0: any hit is a shadow
    uint camera_inside_count;   // interiors that the camera starts in …
    uint camera_inside_first;   // … in words
    uint microfacet_first;      // MICROFACET_TABLE in words, for shaders (microfacet_energy.h)
    uint mip_first;             // NONE: no mips; else in words, two for each instance (voxel_mip.h)
    float mip_edge;             // of the smallest voxel that has mips, world units
};
BUFFER(SceneViews, SceneView)

KERNELS_END
#endif
