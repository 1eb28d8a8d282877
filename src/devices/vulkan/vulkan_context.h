#pragma once
// Instance, physical device, logical device and queue of one Vulkan compute device, with the lifetime of all
// four. Buffers and pipelines share ownership of it, so that they may outlive the VulkanDevice that made
// them.

#include <vulkan/vulkan.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"

namespace spinel {

struct VulkanContext {
    VulkanContext() = default;
    VulkanContext(const VulkanContext&) = delete;
    VulkanContext& operator=(const VulkanContext&) = delete;
    ~VulkanContext();

    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical_device = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t queue_family = 0;
    VkCommandPool command_pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;  // recorded anew by every submit; owned by the pool
    VkFence done = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties = {};
    VkPhysicalDeviceMemoryProperties memory = {};
};

// Opens the device whose name contains `name` (any device if empty), the fastest kind first: discrete,
// integrated, virtual, then a CPU implementation such as lavapipe.
Result<std::shared_ptr<VulkanContext>> create_vulkan_context(const std::string& name);

// The names of all devices that create_vulkan_context would accept, best first.
Result<std::vector<std::string>> vulkan_device_names();

// Records commands, submits them and waits until the device has finished.
Result<void> vulkan_submit(VulkanContext& context, const std::function<void(VkCommandBuffer)>& record);

// "cannot <action>: <what Vulkan answered>".
Error vulkan_error(const std::string& action, VkResult result);

}  // namespace spinel
