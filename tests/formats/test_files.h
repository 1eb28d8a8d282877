#pragma once
// Files for the tests of readers: a folder that each test has to itself, and real data where it is at hand.

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/result.h"

#ifndef SPINEL_SOURCE_DIR
#define SPINEL_SOURCE_DIR "."
#endif

namespace spinel {

inline const std::filesystem::path data_folder = std::filesystem::path(SPINEL_SOURCE_DIR) / "../shared/data";

class FileTest : public testing::Test {
  protected:
    void SetUp() override {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder = std::filesystem::path(testing::TempDir()) /
                 ("spinel_" + std::string(info->test_suite_name()) + "_" + info->name());
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    std::filesystem::path write(const std::string& name, const std::string& bytes) const {
        std::ofstream(folder / name, std::ios::binary) << bytes;
        return folder / name;
    }
    std::filesystem::path folder;
};

inline std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

// The little-endian bytes of a number.
template <class T>
std::string raw(T value) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    return bytes;
}

// One line that names the file.
template <class T>
void expect_refused(const Result<T>& result, const std::filesystem::path& path, const std::string& why = "") {
    ASSERT_FALSE(result) << path;
    const std::string& message = result.error().message;
    EXPECT_NE(message.find(path.filename().string()), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_NE(message.find(why), std::string::npos) << message;
}

}  // namespace spinel
