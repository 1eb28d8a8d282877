// Batches of rays: an error, or as many rays as the file has bytes for.

#include "formats/npy.h"
#include "fuzz_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto rays = spinel::read_rays_npy(spinel::fuzz_file("rays.npy", data, size));
    if (!rays) spinel::check_message(rays.error());
    else if (rays->size() * sizeof(spinel::TraceRay) > size) std::abort();
    return 0;
}
