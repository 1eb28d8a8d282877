#include "core/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>

namespace spinel {
namespace {

Error cannot_write(const std::filesystem::path& path, const std::string& why) {
    return {"cannot write '" + path.string() + "': " + why};
}

// Flushes a file (or, after a rename, its folder) to the disk.
bool synchronise(const std::filesystem::path& path, int flags) {
    const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC);
    if (descriptor < 0) return false;
    const bool done = ::fsync(descriptor) == 0 || errno == EINVAL;  // EINVAL: a file system that cannot
    ::close(descriptor);
    return done;
}

}  // namespace

Result<void> write_file_atomically(const std::filesystem::path& path,
                                   const std::function<Result<void>(const std::filesystem::path&)>& write) {
    static std::atomic<unsigned> counter = 0;
    if (path.filename().empty()) return cannot_write(path, "that is not the name of a file");
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    std::error_code error;
    if (!std::filesystem::is_directory(folder, error))
        return cannot_write(path, "there is no folder '" + folder.string() + "'");
    if (std::filesystem::is_directory(path, error)) return cannot_write(path, "that is a folder");

    // Short and independent of the target's name, which may already be as long as a name can be.
    const std::filesystem::path aside = folder / (".spinel-" + std::to_string(::getpid()) + "-" +
                                                  std::to_string(counter++) + path.extension().string());
    Result<void> written = write(aside);
    if (written && !synchronise(aside, O_RDONLY)) written = cannot_write(path, std::strerror(errno));
    if (written) {
        std::filesystem::rename(aside, path, error);
        if (error) written = cannot_write(path, error.message());
    }
    if (!written) {
        std::filesystem::remove(aside, error);
        return written;
    }
    synchronise(folder,
                O_RDONLY | O_DIRECTORY);  // the file is whole either way; this only makes the rename durable
    return {};
}

Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view bytes) {
    return write_file_atomically(path, [&](const std::filesystem::path& aside) -> Result<void> {
        std::ofstream file(aside, std::ios::binary);
        file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        file.close();
        if (!file) return cannot_write(path, std::strerror(errno));
        return {};
    });
}

}  // namespace spinel
