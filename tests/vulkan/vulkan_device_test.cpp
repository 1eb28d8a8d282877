// The compute host: data go to the device and come back, dispatches see each other, mistakes are errors.
#include "devices/vulkan/vulkan_device.h"

#include <numeric>
#include <vector>

#include "vulkan_test.h"

namespace spinel::vulkan_device_test {
namespace {

struct PushConstants {
    uint64_t from;
    uint64_t to;
    uint32_t count;
    uint32_t scale;
};

constexpr uint32_t local_size = 64;  // of buffers.comp

std::vector<uint32_t> some_words(uint32_t count) {
    std::vector<uint32_t> words(count);
    std::iota(words.begin(), words.end(), 3u);
    return words;
}

// With and without staging: a mapped device takes the other way only when told to.
class VulkanDeviceTest : public testing::TestWithParam<bool> {
  protected:
    std::optional<VulkanDevice> open() { return open_vulkan_device({.name = "", .always_stage = GetParam()}); }
};

TEST_P(VulkanDeviceTest, buffers_come_back_unchanged) {
    auto device = open();
    if (!device) return;
    const auto words = some_words(100'003);
    auto buffer = device->create_buffer<uint32_t>(words);
    ASSERT_TRUE(buffer) << buffer.error().message;
    EXPECT_EQ(buffer->size(), words.size() * sizeof(uint32_t));
    auto read = device->read<uint32_t>(*buffer);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(*read, words);
}

TEST_P(VulkanDeviceTest, a_part_of_a_buffer_is_replaced_and_the_rest_kept) {
    auto device = open();
    if (!device) return;
    auto expected = some_words(1000);
    auto buffer = device->create_buffer<uint32_t>(expected);
    ASSERT_TRUE(buffer) << buffer.error().message;
    const std::vector<uint32_t> part = {7, 8, 9};
    auto done = device->upload(*buffer, std::as_bytes(std::span(part)), 500 * sizeof(uint32_t));
    ASSERT_TRUE(done) << done.error().message;
    std::copy(part.begin(), part.end(), expected.begin() + 500);
    auto read = device->read<uint32_t>(*buffer);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(*read, expected);
}

TEST_P(VulkanDeviceTest, a_dispatch_sees_what_the_one_before_wrote) {
    auto device = open();
    if (!device) return;
    const auto words = some_words(1000);
    auto first = device->create_buffer<uint32_t>(words);
    auto second = device->create_buffer(words.size() * sizeof(uint32_t));
    auto third = device->create_buffer(words.size() * sizeof(uint32_t));
    auto pipeline = device->create_pipeline(load_spirv("buffers"), sizeof(PushConstants));
    ASSERT_TRUE(first && second && third && pipeline);
    const uint32_t count = static_cast<uint32_t>(words.size());
    const PushConstants push[2] = {{first->address(), second->address(), count, 3},
                                   {second->address(), third->address(), count, 5}};
    const uint32_t groups = (count + local_size - 1) / local_size;
    const VulkanDispatch dispatches[2] = {{&*pipeline, std::as_bytes(std::span(push, 1)), {groups, 1, 1}},
                                          {&*pipeline, std::as_bytes(std::span(push + 1, 1)), {groups, 1, 1}}};
    auto done = device->run(dispatches);
    ASSERT_TRUE(done) << done.error().message;
    auto read = device->read<uint32_t>(*third);
    ASSERT_TRUE(read) << read.error().message;
    for (uint32_t i = 0; i < count; ++i) ASSERT_EQ((*read)[i], 15 * words[i]) << "word " << i;
}

INSTANTIATE_TEST_SUITE_P(Copies, VulkanDeviceTest, testing::Bool(),
                         [](const auto& info) { return info.param ? "staged" : "mapped"; });

TEST(VulkanDevice, an_empty_buffer_has_an_address_and_no_bytes) {
    auto device = open_vulkan_device();
    if (!device) return;
    auto buffer = device->create_buffer(0);
    ASSERT_TRUE(buffer) << buffer.error().message;
    EXPECT_EQ(buffer->size(), 0u);
    EXPECT_NE(buffer->address(), 0u);
}

TEST(VulkanDevice, an_unknown_name_is_an_error_that_lists_the_devices) {
    auto device = open_vulkan_device();
    if (!device) return;
    auto other = VulkanDevice::create({.name = "no such device"});
    ASSERT_FALSE(other);
    EXPECT_NE(other.error().message.find(device->name()), std::string::npos) << other.error().message;
}

TEST(VulkanDevice, too_many_push_constants_and_bytes_that_are_no_shader_are_errors) {
    auto device = open_vulkan_device();
    if (!device) return;
    EXPECT_FALSE(device->create_pipeline(load_spirv("buffers"), 1 << 20));
    const std::vector<uint32_t> nonsense(16, 12345u);
    EXPECT_FALSE(device->create_pipeline(nonsense, 16));
}

TEST(VulkanDevice, buffers_and_pipelines_outlive_their_device) {
    std::optional<VulkanBuffer> buffer;
    std::optional<VulkanPipeline> pipeline;
    {
        auto device = open_vulkan_device();
        if (!device) return;
        auto made = device->create_buffer<uint32_t>(some_words(16));
        auto compiled = device->create_pipeline(load_spirv("buffers"), sizeof(PushConstants));
        ASSERT_TRUE(made && compiled);
        buffer.emplace(std::move(*made));
        pipeline.emplace(std::move(*compiled));
    }
    EXPECT_NE(buffer->address(), 0u);  // freed at the end of the test, without its device object
}

}  // namespace
}  // namespace spinel::vulkan_device_test
