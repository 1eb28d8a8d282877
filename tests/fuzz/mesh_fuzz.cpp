// Meshes through Assimp: the first byte chooses the format, the rest is the file. What Assimp itself throws
// or asserts on must not get past the readers.

#include <iterator>

#include "fuzz_scene.h"
#include "spinel/formats.h"

// Assimp's PLY reader leaks a mesh where a file ends early; errors of memory are still found.
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const char* const names[] = {"input.obj", "input.ply", "input.stl", "input.off", "input.glb", "input.gltf"};
    if (size == 0) return 0;
    spinel::check_scene(spinel::load_model(spinel::fuzz_file(names[data[0] % std::size(names)], data + 1, size - 1)));
    return 0;
}
