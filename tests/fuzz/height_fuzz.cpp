// Heights as terrain: the first byte chooses between a tile and pictures, the rest is the file. Of pictures only such
// as have no library behind them that is worth a fuzzer of its own (TIFF, EXR).

#include <iterator>

#include "fuzz_scene.h"
#include "spinel/formats.h"

// The reader of PNG leaks a little where a file is damaged; errors of memory are still found.
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const char* const names[] = {"N10E010.hgt", "input.png", "input.pgm"};
    if (size == 0) return 0;
    const auto path = spinel::fuzz_file(names[data[0] % std::size(names)], data + 1, size - 1);
    spinel::check_scene(spinel::load_model(path, {.frame = {}, .heightmap = 40.0f}));
    return 0;
}
