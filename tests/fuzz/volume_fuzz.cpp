// Dense volumes: the first byte chooses between .svol and .bits, the rest is the file.

#include "formats/raw_volume.h"
#include "fuzz_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    if (data[0] & 1) spinel::check_scene(spinel::load_bits(spinel::fuzz_file("input.bits", data + 1, size - 1)));
    else spinel::check_scene(spinel::load_svol(spinel::fuzz_file("input.svol", data + 1, size - 1)));
    return 0;
}
