#ifndef SPINEL_KERNELS_INTEGRATOR_TABLE_H
#define SPINEL_KERNELS_INTEGRATOR_TABLE_H
// The integrators there are; integrators.h defines integrate_<name>. A number never changes.

// What compile() makes for an integrator alone:
#define SPINEL_NEEDS_NOTHING 0
#define SPINEL_NEEDS_MIPS 1       // voxels as they look from afar (VoxelMip)
#define SPINEL_NEEDS_GLOW_MIPS 2  // the same, if there is to be a halo

//      number  name      needs  what it shows
#define SPINEL_INTEGRATORS(ROW)                                                                           \
    ROW(0u, path, SPINEL_NEEDS_NOTHING,                                                                   \
        "volumetric path tracing with next-event estimation and multiple importance sampling")            \
    ROW(1u, normals, SPINEL_NEEDS_NOTHING, "shading normals of what is seen first")                       \
    ROW(2u, ao, SPINEL_NEEDS_GLOW_MIPS,                                                                   \
        "preview: sun and sky without shadows, darkened in corners by ambient occlusion")                 \
    ROW(3u, faces, SPINEL_NEEDS_GLOW_MIPS,                                                                \
        "preview: flat faces in sun and even sky with a hard shadow, without random numbers")             \
    ROW(4u, cone, SPINEL_NEEDS_MIPS,                                                                      \
        "preview: sky, bounced light, glossy reflections and soft shadows by cones through voxel sets")   \
    ROW(12u, direct, SPINEL_NEEDS_NOTHING, "light that a surface gets straight from its sources")         \
    ROW(13u, depth, SPINEL_NEEDS_NOTHING, "how far away what is seen first is, white near and black far") \
    ROW(14u, heatmap, SPINEL_NEEDS_NOTHING,                                                               \
        "what a camera ray costs, in false colour: nodes and cells, boxes, triangles")

#endif
