// Qubicle, Voxlap and binvox: the first byte chooses the format, the rest is the file.

#include <iterator>

#include "fuzz_scene.h"
#include "spinel/formats.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const char* const names[] = {"input.qb", "input.kv6", "input.binvox"};
    if (size == 0) return 0;
    spinel::check_scene(spinel::load_model(spinel::fuzz_file(names[data[0] % std::size(names)], data + 1, size - 1)));
    return 0;
}
