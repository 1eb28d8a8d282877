// Scene files: an error that says where, or a scene that is valid and is read again from what is written of
// it.

#include <string_view>

#include "fuzz_scene.h"
#include "scene/json_reader.h"
#include "scene/json_writer.h"

namespace {

// Files that a scene names are other readers' concern.
const spinel::SceneLoaders no_files = {
    [](const std::filesystem::path& path, const spinel::LoadOptions&) {
        return spinel::Result<spinel::Scene>(spinel::Error{"no " + path.filename().string()});
    },
    [](const std::filesystem::path& path) {
        return spinel::Result<spinel::PixelBuffer>(spinel::Error{"no " + path.filename().string()});
    }};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const spinel::Result<spinel::Scene> scene = spinel::read_scene_json(text, "scene.json", no_files);
    spinel::check_scene(scene);
    if (!scene) return 0;
    const auto written = spinel::write_scene_json(*scene);
    const auto again = written ? spinel::read_scene_json(*written, "written.json", no_files) : written.error();
    if (!again) {
        std::fprintf(stderr, "not read back: %s\n", again.error().message.c_str());
        std::abort();
    }
    return 0;
}
