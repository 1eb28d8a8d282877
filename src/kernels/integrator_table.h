#ifndef SPINEL_KERNELS_INTEGRATOR_TABLE_H
#define SPINEL_KERNELS_INTEGRATOR_TABLE_H
// The integrators there are; integrators.h defines integrate_<name>. A number never changes.

//      number  name      what it shows
#define SPINEL_INTEGRATORS(ROW)                                                                          \
    ROW(0u, path, "volumetric path tracing with next-event estimation and multiple importance sampling") \
    ROW(1u, normals, "shading normals of what is seen first")

#endif
