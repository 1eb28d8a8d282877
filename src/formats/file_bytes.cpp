#include "formats/file_bytes.h"

#include <algorithm>
#include <fstream>

namespace spinel {

Error cannot_read(const std::filesystem::path& path, const std::string& why) {
    // What is wrong may be quoted from the file itself; a message is one line all the same.
    std::string line = why;
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return c < ' ' || c == 127; }, '?');
    return {"cannot read '" + path.string() + "': " + line};
}

Result<std::string> read_file_bytes(const std::filesystem::path& path, std::uintmax_t max_bytes) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) return cannot_read(path, "there is no such file");
    if (!std::filesystem::is_regular_file(path, error)) return cannot_read(path, "that is not a plain file");
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) return cannot_read(path, error.message());
    if (size > max_bytes)
        return cannot_read(
            path, "its " + std::to_string(size) + " bytes are more than the " + std::to_string(max_bytes) + " allowed");
    std::ifstream file(path, std::ios::binary);
    std::string bytes(static_cast<std::size_t>(size), '\0');
    if (!file.read(bytes.data(), static_cast<std::streamsize>(size)))
        return cannot_read(path, "the file cannot be opened, or ended early");
    return bytes;
}

}  // namespace spinel
