// A file of its own since these headers are by far the slowest to compile.

#include "cli/bench/nanovdb_grids.h"

#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>

namespace spinel::cli {

nanovdb::GridHandle<> nanovdb_mask(const VoxelTree& tree) {
    openvdb::initialize();
    openvdb::MaskGrid grid;
    tree.for_each_cube([&](ivec3 lower, int size, std::uint16_t) {
        const ivec3 upper = lower + (size - 1);
        grid.fill({openvdb::Coord(lower.x, lower.y, lower.z), openvdb::Coord(upper.x, upper.y, upper.z)}, true);
    });
    grid.tree().prune();
    return nanovdb::openToNanoVDB(grid);
}

nanovdb::GridHandle<> nanovdb_floats(const GridSamples& samples, float background, std::size_t& active_count) {
    nanovdb::GridBuilder<float> builder(background);
    auto accessor = builder.getAccessor();
    active_count = 0;
    const ivec3 size = samples.size();
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const float value = samples.at({x, y, z});
                if (value == background) continue;
                accessor.setValue(nanovdb::Coord(x, y, z), value);
                ++active_count;
            }
    return builder.getHandle();
}

}  // namespace spinel::cli
