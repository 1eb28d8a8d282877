// SDF expressions: an error that says where, or a tree that is written and read again to the same text, and
// whose tape is built or refused.

#include <string_view>

#include "fuzz_scene.h"
#include "geometry/sdf/sdf_builder.h"
#include "geometry/sdf/sdf_text.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto node = spinel::parse_sdf_text({reinterpret_cast<const char*>(data), size}, "input");
    if (!node) {
        spinel::check_message(node.error());
        return 0;
    }
    const std::string text = spinel::sdf_text(*node);
    const auto again = spinel::parse_sdf_text(text, "written");
    if (!again || spinel::sdf_text(*again) != text) {
        std::fprintf(stderr, "not read back: %s\n", text.c_str());
        std::abort();
    }
    const spinel::SdfGeometry geometry = {*node, std::pair(glm::vec3(-2), glm::vec3(2))};
    if (const auto tape = spinel::build_sdf(geometry); !tape) spinel::check_message(tape.error());
    return 0;
}
