#pragma once
// Readers take files, libFuzzer gives bytes: a file in shared memory stands between.

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace spinel {

// A folder in shared memory for one process, removed at its end.
class FuzzFolder {
  public:
    FuzzFolder() : path_(std::filesystem::path("/dev/shm") / ("spinel-fuzz-" + std::to_string(::getpid()))) {
        std::filesystem::create_directories(path_);
    }
    ~FuzzFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::filesystem::path write(const std::string& name, const std::uint8_t* data, std::size_t size) const {
        const std::filesystem::path path = path_ / name;
        std::ofstream file(path, std::ios::binary);
        file.write(reinterpret_cast<const char*>(data), std::streamsize(size));
        file.close();
        if (!file) std::abort();
        return path;
    }

  private:
    std::filesystem::path path_;
};

inline std::filesystem::path fuzz_file(const std::string& name, const std::uint8_t* data, std::size_t size) {
    static const FuzzFolder folder;
    return folder.write(name, data, size);
}

}  // namespace spinel
