#ifndef SPINEL_KERNELS_INTEGRATOR_TABLE_H
#define SPINEL_KERNELS_INTEGRATOR_TABLE_H
// The integrators there are; integrators.h defines integrate_<name>. A number never changes.

// What compile() makes for an integrator alone:
#define SPINEL_NEEDS_NOTHING 0
#define SPINEL_NEEDS_MIPS 1       // voxels as they look from afar (VoxelMip)
#define SPINEL_NEEDS_GLOW_MIPS 2  // the same, if there is to be a halo

// name: the suffix of its function; text: what files, messages and the command line call it.
//      number  name  text  needs  what it shows
#define SPINEL_INTEGRATORS(ROW)                                                                                    \
    ROW(0u, path, "path", SPINEL_NEEDS_NOTHING,                                                                    \
        "volumetric path tracing with next-event estimation and multiple importance sampling")                     \
    ROW(1u, normals, "normals", SPINEL_NEEDS_NOTHING, "shading normals of what is seen first")                     \
    ROW(2u, ao, "ao", SPINEL_NEEDS_GLOW_MIPS,                                                                      \
        "preview: sun and sky without shadows, darkened in corners by ambient occlusion")                          \
    ROW(3u, faces, "faces", SPINEL_NEEDS_GLOW_MIPS,                                                                \
        "preview: flat faces in sun and even sky with a hard shadow, without random numbers")                      \
    ROW(4u, cone, "cone", SPINEL_NEEDS_MIPS,                                                                       \
        "preview: sky, bounced light, glossy reflections and soft shadows by cones through voxel sets")            \
    ROW(5u, single_scatter, "single-scatter", SPINEL_NEEDS_NOTHING,                                                \
        "ray march: light that media scatter once, with their shadows on surfaces, almost without noise")          \
    ROW(6u, dvr, "dvr", SPINEL_NEEDS_NOTHING,                                                                      \
        "volume rendering by a transfer function: windows, shading, projections, iso-surfaces")                    \
    ROW(11u, whitted, "whitted", SPINEL_NEEDS_NOTHING,                                                             \
        "direct light, and rays that mirrors and clear glass reflect and refract, all of them followed (1980)")    \
    ROW(12u, direct, "direct", SPINEL_NEEDS_NOTHING, "light that a surface gets straight from its sources")        \
    ROW(13u, depth, "depth", SPINEL_NEEDS_NOTHING, "how far away what is seen first is, white near and black far") \
    ROW(14u, heatmap, "heatmap", SPINEL_NEEDS_NOTHING,                                                             \
        "what a camera ray costs, in false colour: nodes and cells, boxes, triangles")

#endif
