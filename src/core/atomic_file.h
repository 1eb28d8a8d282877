#pragma once
// Files that are never seen half-written: the bytes go to a file beside the target, reach the disk, and take
// its name.

#include <filesystem>
#include <functional>
#include <string_view>

#include "core/result.h"

namespace spinel {

// Calls `write` with the name of a fresh file in the folder of `path` (with the same extension, since some
// writers choose the format by it), then renames that file to `path`. When anything fails, `path` stays as it
// was and nothing is left beside it.
Result<void> write_file_atomically(const std::filesystem::path& path,
                                   const std::function<Result<void>(const std::filesystem::path&)>& write);

Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace spinel
