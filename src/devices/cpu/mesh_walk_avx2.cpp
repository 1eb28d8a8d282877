#include "devices/cpu/mesh_walk_avx2.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_BEGIN

namespace spinel {

WideHit wide_closest_avx2(const WideMesh& mesh, const kernels::Ray& ray) {
    wide::Best best = {ray.t_max, 0, 0, 0, false};
    wide::walk<false>(mesh.units, wide::make_slabs(mesh, ray), wide::make_shear(ray), _mm_set1_ps(ray.t_min), 0, best);
    return {best.t, best.u, best.v, best.found ? best.triangle : kernels::NONE, best.block, best.lane};
}

bool wide_any_avx2(const WideMesh& mesh, const kernels::Ray& ray) {
    wide::Best limit = {ray.t_max, 0, 0, 0, false};
    return wide::walk<true>(mesh.units, wide::make_slabs(mesh, ray), wide::make_shear(ray), _mm_set1_ps(ray.t_min), 0,
                            limit);
}

}  // namespace spinel

SPINEL_AVX2_END
#endif
