// Voxels in OpenVDB files. What a file lists is checked before OpenVDB sees it; what it allocates inside of a grid goes
// by counts of the file, and must end as an error where it fails.

#include <cstdlib>
#include <new>

#include "formats/vdb.h"
#include "fuzz_scene.h"

// The sanitizer's own would end the program where memory ends.
namespace {
void* allocated(std::size_t size) {
    if (size > std::size_t(1) << 29) throw std::bad_alloc();
    if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
    throw std::bad_alloc();
}
}  // namespace
void* operator new(std::size_t size) { return allocated(size); }
void* operator new[](std::size_t size) { return allocated(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    spinel::LoadOptions as_voxels;
    as_voxels.voxels = true;
    spinel::check_scene(spinel::load_vdb(spinel::fuzz_file("input.vdb", data, size), as_voxels));
    return 0;
}
