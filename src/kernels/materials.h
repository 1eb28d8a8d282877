#ifndef SPINEL_KERNELS_MATERIALS_H
#define SPINEL_KERNELS_MATERIALS_H
// The table of materials. To add one, say `velvet`:
//
//   1. write materials/velvet.h with velvet_make, velvet_eval_pdf, velvet_sample, velvet_albedo and velvet_is_delta
//      (conventions: bsdf_types.h; a short example: materials/diffuse.h) and, for the host, velvet_description;
//   2. add its row, and its #include, below.
//
// From the row come the constant MATERIAL_VELVET, the cases of bsdf.h, its name in scene files, the parameters of the
// scene reader and the schema, `spinel list`, and the tests that every material must pass, on the CPU and on a Vulkan
// device. A kind's number never changes.
#include "materials/dielectric.h"
#include "materials/diffuse.h"
#include "materials/metal.h"
#include "materials/plastic.h"
#include "materials/principled.h"

#define SPINEL_MATERIALS(ROW)       \
    ROW(0u, DIFFUSE, diffuse)       \
    ROW(1u, METAL, metal)           \
    ROW(2u, DIELECTRIC, dielectric) \
    ROW(3u, PLASTIC, plastic)       \
    ROW(4u, PRINCIPLED, principled)

KERNELS_BEGIN

#define SPINEL_MATERIAL_CONSTANT(number, CONSTANT, name) const uint MATERIAL_##CONSTANT = number;
SPINEL_MATERIALS(SPINEL_MATERIAL_CONSTANT)
#undef SPINEL_MATERIAL_CONSTANT

KERNELS_END
#endif
