#pragma once
// What the tests on a Vulkan device share.

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "devices/vulkan/vulkan_device.h"

// The machine's best device. Empty, with the test marked as skipped, only where there is no Vulkan device at
// all; a device that is listed and cannot be opened is a failure.
inline std::optional<spinel::VulkanDevice> open_vulkan_device(const spinel::VulkanDeviceOptions& options = {}) {
    auto names = spinel::VulkanDevice::available();
    if (!names || names->empty()) {
        [&] { GTEST_SKIP() << "no Vulkan device: " << (names ? "none is listed" : names.error().message); }();
        return std::nullopt;
    }
    auto device = spinel::VulkanDevice::create(options);
    if (!device) {
        ADD_FAILURE() << device.error().message;
        return std::nullopt;
    }
    return std::move(*device);
}

// A module that the build compiled from tests/vulkan/<name>.comp.
inline std::vector<uint32_t> load_spirv(const std::string& name) {
    std::ifstream file(std::string(SPINEL_SHADER_DIR) + "/" + name + ".spv", std::ios::binary | std::ios::ate);
    EXPECT_TRUE(file) << "cannot read " << name << ".spv in " << SPINEL_SHADER_DIR;
    if (!file) return {};
    std::vector<uint32_t> words(static_cast<size_t>(file.tellg()) / sizeof(uint32_t));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(words.data()), static_cast<std::streamsize>(words.size() * sizeof(uint32_t)));
    return words;
}
