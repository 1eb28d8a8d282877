// What an OpenVDB file lists, which is checked before OpenVDB sees it: an error, or grids whose names the file has
// bytes for. What OpenVDB reads inside of a grid is trusted.

#include "formats/vdb_layout.h"
#include "fuzz_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto grids = spinel::read_vdb_layout(spinel::fuzz_file("input.vdb", data, size));
    if (!grids) return spinel::check_message(grids.error()), 0;
    std::size_t bytes = 0;
    for (const spinel::VdbGridEntry& grid : *grids) bytes += grid.name.size() + grid.type.size();
    if (bytes > size) std::abort();
    return 0;
}
