// What lies below the readers of worlds: gzip, zlib and LZ4 streams, and NBT.

#include <string>

#include "formats/inflate.h"
#include "formats/nbt.h"
#include "fuzz_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string bytes(reinterpret_cast<const char*>(data), size);
    if (const auto plain = spinel::inflated(bytes, 1 << 20); !plain) spinel::check_message(plain.error());
    if (const auto plain = spinel::lz4_unpacked(bytes, 1 << 20); !plain) spinel::check_message(plain.error());
    if (const auto document = spinel::nbt::parse_packed(bytes); !document) spinel::check_message(document.error());
    return 0;
}
