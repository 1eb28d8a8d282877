// MagicaVoxel files: whatever the bytes, an error or a scene that validates; and what is written of it is read again.

#include "formats/vox.h"
#include "formats/vox_writer.h"
#include "fuzz_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto path = spinel::fuzz_file("input.vox", data, size);
    const auto scene = spinel::load_vox(path);
    spinel::check_scene(scene);
    spinel::check_scene(spinel::load_vox(path, {.frame = 3, .heightmap = {}}));
    if (!scene) return 0;
    const auto copy = path.parent_path() / "copy.vox";
    if (const auto saved = spinel::save_vox(*scene, copy); !saved) return spinel::check_message(saved.error()), 0;
    const auto back = spinel::load_vox(copy);
    if (!back) {
        std::fprintf(stderr, "written, but not readable: %s\n", back.error().message.c_str());
        std::abort();
    }
    spinel::check_scene(back);
    return 0;
}
