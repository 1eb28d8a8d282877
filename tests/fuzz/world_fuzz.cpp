// Worlds, structures and heights: the first byte chooses the format, the rest is the file. Compressed files are hard to
// reach from random bytes, so NBT comes plain: readers take both.

#include <iterator>

#include "fuzz_scene.h"
#include "spinel/formats.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const char* const names[] = {"input.mca", "input.schem", "input.schematic", "input.litematic",
                                        "input.nbt", "input.mts",   "input.hgt",       "input.hgt.gz"};
    if (size == 0) return 0;
    spinel::check_scene(spinel::load_model(spinel::fuzz_file(names[data[0] % std::size(names)], data + 1, size - 1)));
    return 0;
}
