// NanoVDB as a peer: a careful use of its hierarchical DDA, from node to node, and in a leaf from voxel to voxel by the
// leaf's mask.

#include <nanovdb/util/HDDA.h>
#include <nanovdb/util/Ray.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "cli/bench/bench_structure.h"
#include "cli/bench/nanovdb_grids.h"

namespace spinel::cli {
namespace {

using kernels::Hit;
using kernels::Ray;
using NanoGrid = nanovdb::NanoGrid<nanovdb::ValueMask>;
using NanoRay = nanovdb::Ray<float>;

// The first active voxel.
template <class Accessor>
bool nano_first(const Ray& ray, const nanovdb::CoordBBox& box, const Accessor& accessor, ivec3& cell, float& t) {
    using nanovdb::Coord;
    const nanovdb::Vec3f o(ray.origin.x, ray.origin.y, ray.origin.z),
        d(ray.direction.x, ray.direction.y, ray.direction.z);
    NanoRay r(o, d);
    if (!r.clip(box)) return false;
    Coord ijk = nanovdb::RoundDown<Coord>(r.start());
    nanovdb::HDDA<NanoRay, Coord> hdda(r, int(accessor.getDim(ijk, r)));
    for (;;) {
        ijk = hdda.voxel();
        if (const auto* leaf = accessor.probeLeaf(ijk)) {
            hdda.update(r, 1);
            ijk = hdda.voxel();
            const Coord origin = leaf->origin();
            while ((ijk & ~7) == origin) {
                if (leaf->isActive(ijk)) {
                    cell = {ijk[0], ijk[1], ijk[2]};
                    t = hdda.time();
                    return true;
                }
                if (!hdda.step()) return false;
                ijk = hdda.voxel();
            }
            hdda.update(r, int(accessor.getDim(ijk, r)));
            continue;
        }
        if (accessor.isActive(ijk)) {  // a tile
            const nanovdb::Vec3f p = r(hdda.time());
            const Coord low = hdda.voxel();
            for (int i = 0; i < 3; ++i) cell[i] = std::clamp(int(std::floor(p[i])), low[i], low[i] + hdda.dim() - 1);
            t = hdda.time();
            return true;
        }
        if (!hdda.step()) return false;
        hdda.update(r, int(accessor.getDim(hdda.voxel(), r)));
    }
}

}  // namespace

std::vector<BenchStructure> nanovdb_structures(const VoxelTree& tree) {
    const auto start = std::chrono::steady_clock::now();
    const auto handle = std::make_shared<nanovdb::GridHandle<>>(nanovdb_mask(tree));
    const double build = 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    BenchStructure peer;
    peer.name = "nanovdb-leaf-mask";
    peer.build_ms = build;
    peer.bytes = double(handle->size());
    peer.closest = [handle](std::span<const Ray> rays, Hit* hits) {
        const NanoGrid& grid = *handle->grid<nanovdb::ValueMask>();
        const nanovdb::CoordBBox box = grid.tree().bbox();
        const auto accessor = grid.getAccessor();
        for (std::size_t i = 0; i < rays.size(); ++i) {
            Hit hit = kernels::no_hit(rays[i].t_max);
            if (nano_first(rays[i], box, accessor, hit.cell, hit.t)) hit.instance = 0;
            hits[i] = hit;
        }
    };
    return {peer};
}

}  // namespace spinel::cli
