// MagicaVoxel files: whatever the bytes, an error or a scene that validates.

#include "formats/vox.h"
#include "fuzz_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    spinel::check_scene(spinel::load_vox(spinel::fuzz_file("input.vox", data, size)));
    return 0;
}
