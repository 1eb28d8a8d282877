// Volumes of other people's files: the first byte chooses the format, the rest is the file. What the formats name
// beside themselves (a .nhdr's samples) is a file that is not there.

#include <iterator>

#include "fuzz_scene.h"
#include "spinel/formats.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const char* const names[] = {"input.nii", "input.nrrd", "input.nhdr",          "input.mha",
                                        "input.vol", "input.nvdb", "input_3x2x2_u16.raw", "input.nii.gz"};
    if (size == 0) return 0;
    const auto path = spinel::fuzz_file(names[data[0] % std::size(names)], data + 1, size - 1);
    spinel::check_scene(spinel::load_model(path));
    return 0;
}
