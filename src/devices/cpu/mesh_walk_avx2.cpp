#include "devices/cpu/mesh_walk_avx2.h"

#include "devices/cpu/mesh_compact_avx2.h"

#ifdef SPINEL_AVX2
SPINEL_AVX2_BEGIN

namespace spinel {
namespace {

template <class Layout>
SPINEL_INLINE WideHit closest(const WideMesh& mesh, const kernels::Ray& ray) {
    wide::Best best = {ray.t_max, 0, 0, 0, false};
    wide::walk<Layout, false>(mesh.units, wide::make_slabs(mesh, ray), Layout::make_shear(ray), 0, best);
    return {best.t, best.u, best.v, best.found ? best.triangle : kernels::NONE, best.block, best.lane};
}

template <class Layout>
SPINEL_INLINE bool any(const WideMesh& mesh, const kernels::Ray& ray) {
    wide::Best limit = {ray.t_max, 0, 0, 0, false};
    return wide::walk<Layout, true>(mesh.units, wide::make_slabs(mesh, ray), Layout::make_shear(ray), 0, limit);
}

}  // namespace

WideHit wide_closest_avx2(const WideMesh& mesh, const kernels::Ray& ray) { return closest<wide::Gathered>(mesh, ray); }
bool wide_any_avx2(const WideMesh& mesh, const kernels::Ray& ray) { return any<wide::Gathered>(mesh, ray); }

WideHit compact_closest_avx2(const WideMesh& mesh, const kernels::Ray& ray) {
    return closest<wide::Compact>(mesh, ray);
}
bool compact_any_avx2(const WideMesh& mesh, const kernels::Ray& ray) { return any<wide::Compact>(mesh, ray); }

}  // namespace spinel

SPINEL_AVX2_END
#endif
