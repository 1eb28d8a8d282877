#pragma once
// Compressed bytes of other people's files. Sizes that a file announces are never believed: the output grows as the
// stream gives bytes, up to a bound.

#include <string>
#include <string_view>

#include "core/result.h"

namespace spinel {

// Whether the bytes begin like a gzip or zlib stream.
bool looks_deflated(std::string_view bytes);

// The bytes of a gzip stream (of one or several members) or a zlib stream.
Result<std::string> inflated(std::string_view packed, std::size_t max_bytes);

// The same, but no more than the first `bytes` of them: the rest is not looked at.
Result<std::string> inflated_start(std::string_view packed, std::size_t bytes);

// The bytes of a row of blocks as LZ4's Java library frames them ("LZ4Block"), which Minecraft's region files may hold.
// Checksums are not verified.
Result<std::string> lz4_unpacked(std::string_view packed, std::size_t max_bytes);

}  // namespace spinel
