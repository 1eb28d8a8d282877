#pragma once
// A whole file in memory, and the shape of the errors that all readers share.

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/result.h"

namespace spinel {

// "cannot read 'name': why"
Error cannot_read(const std::filesystem::path& path, const std::string& why);

Result<std::string> read_file_bytes(const std::filesystem::path& path, std::uintmax_t max_bytes);

}  // namespace spinel
