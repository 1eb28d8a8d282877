#include "devices/vulkan/vulkan_context.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace spinel {
namespace {

// The kernels are compiled for Vulkan 1.3, that is SPIR-V 1.6.
constexpr uint32_t required_api = VK_API_VERSION_1_3;

struct Candidate {
    VkPhysicalDevice physical_device;
    VkPhysicalDeviceProperties properties;
    uint32_t queue_family;
};

const char* result_text(VkResult result) {
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY: return "out of host memory";
        case VK_ERROR_OUT_OF_DEVICE_MEMORY: return "out of device memory";
        case VK_ERROR_INITIALIZATION_FAILED: return "initialisation failed";
        case VK_ERROR_DEVICE_LOST: return "the device was lost";
        case VK_ERROR_MEMORY_MAP_FAILED: return "memory cannot be mapped";
        case VK_ERROR_LAYER_NOT_PRESENT: return "a layer is not installed";
        case VK_ERROR_EXTENSION_NOT_PRESENT: return "an extension is missing";
        case VK_ERROR_FEATURE_NOT_PRESENT: return "a feature is missing";
        case VK_ERROR_INCOMPATIBLE_DRIVER: return "no Vulkan driver is installed";
        case VK_ERROR_TOO_MANY_OBJECTS: return "too many objects";
        case VK_ERROR_INVALID_SHADER_NV: return "the shader is invalid";
        default: return nullptr;
    }
}

Result<VkInstance> create_instance() {
    const VkApplicationInfo application = {
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "spinel", .apiVersion = required_api};
    const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                       .pApplicationInfo = &application};
    VkInstance instance = VK_NULL_HANDLE;
    if (VkResult result = vkCreateInstance(&info, nullptr, &instance); result != VK_SUCCESS)
        return vulkan_error("create a Vulkan instance", result);
    return instance;
}

bool has_required_features(VkPhysicalDevice physical_device) {
    VkPhysicalDeviceVulkan12Features features12 = {};
    features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &features12};
    vkGetPhysicalDeviceFeatures2(physical_device, &features);
    return features12.bufferDeviceAddress && features12.scalarBlockLayout;
}

// A family that computes, best without graphics: such a queue runs beside a desktop's.
std::optional<uint32_t> compute_queue_family(VkPhysicalDevice physical_device) {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical_device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical_device, &count, families.data());
    std::optional<uint32_t> best;
    for (uint32_t i = 0; i < count; ++i) {
        if (!(families[i].queueFlags & VK_QUEUE_COMPUTE_BIT)) continue;
        if (!best || !(families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT)) best = i;
    }
    return best;
}

int rank(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return 0;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return 1;
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return 2;
        case VK_PHYSICAL_DEVICE_TYPE_CPU: return 3;
        default: return 4;
    }
}

// Every usable device, best first.
Result<std::vector<Candidate>> candidates(VkInstance instance) {
    uint32_t count = 0;
    VkResult result = vkEnumeratePhysicalDevices(instance, &count, nullptr);
    std::vector<VkPhysicalDevice> devices(count);
    if (result == VK_SUCCESS) result = vkEnumeratePhysicalDevices(instance, &count, devices.data());
    if (result != VK_SUCCESS) return vulkan_error("list the Vulkan devices", result);
    std::vector<Candidate> usable;
    for (VkPhysicalDevice device : devices) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(device, &properties);
        if (properties.apiVersion < required_api || !has_required_features(device)) continue;
        if (auto family = compute_queue_family(device)) usable.push_back({device, properties, *family});
    }
    std::stable_sort(usable.begin(), usable.end(), [](const Candidate& a, const Candidate& b) {
        return rank(a.properties.deviceType) < rank(b.properties.deviceType);
    });
    return usable;
}

Result<void> open_device(VulkanContext& context) {
    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = context.queue_family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    VkPhysicalDeviceVulkan12Features features12 = {};
    features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    features12.scalarBlockLayout = VK_TRUE;
    features12.bufferDeviceAddress = VK_TRUE;
    VkPhysicalDeviceVulkan13Features features13 = {};
    features13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    features13.pNext = &features12;
    features13.maintenance4 = VK_TRUE;  // every 1.3 device has it; SPIR-V 1.6 states the local size its way
    const VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                       .pNext = &features13,
                                       .queueCreateInfoCount = 1,
                                       .pQueueCreateInfos = &queue};
    VkResult result = vkCreateDevice(context.physical_device, &device, nullptr, &context.device);
    if (result != VK_SUCCESS)
        return vulkan_error(fmt::format("open the Vulkan device '{}'", context.properties.deviceName), result);
    vkGetDeviceQueue(context.device, context.queue_family, 0, &context.queue);

    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = context.queue_family};
    result = vkCreateCommandPool(context.device, &pool, nullptr, &context.command_pool);
    if (result != VK_SUCCESS) return vulkan_error("create a command pool", result);
    const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                  .commandPool = context.command_pool,
                                                  .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                  .commandBufferCount = 1};
    result = vkAllocateCommandBuffers(context.device, &commands, &context.commands);
    if (result != VK_SUCCESS) return vulkan_error("allocate a command buffer", result);
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    result = vkCreateFence(context.device, &fence, nullptr, &context.done);
    if (result != VK_SUCCESS) return vulkan_error("create a fence", result);
    return {};
}

}  // namespace

VulkanContext::~VulkanContext() {
    if (device) {
        vkDeviceWaitIdle(device);
        vkDestroyFence(device, done, nullptr);
        vkDestroyCommandPool(device, command_pool, nullptr);
        vkDestroyDevice(device, nullptr);
    }
    if (instance) vkDestroyInstance(instance, nullptr);
}

Result<std::shared_ptr<VulkanContext>> create_vulkan_context(const std::string& name) {
    auto context = std::make_shared<VulkanContext>();
    auto instance = create_instance();
    if (!instance) return instance.error();
    context->instance = *instance;

    auto usable = candidates(context->instance);
    if (!usable) return usable.error();
    auto chosen = std::find_if(usable->begin(), usable->end(), [&](const Candidate& candidate) {
        return std::string(candidate.properties.deviceName).find(name) != std::string::npos;
    });
    if (chosen == usable->end()) {
        if (usable->empty())
            return Error{
                "no Vulkan 1.3 device with buffer addresses and scalar block layout; "
                "install a driver (Mesa's lavapipe runs on the CPU)"};
        std::string names;
        for (const Candidate& candidate : *usable)
            names += fmt::format("{}'{}'", names.empty() ? "" : ", ", candidate.properties.deviceName);
        return Error{fmt::format("no Vulkan device named '{}'; available: {}", name, names)};
    }
    context->physical_device = chosen->physical_device;
    context->properties = chosen->properties;
    context->queue_family = chosen->queue_family;
    vkGetPhysicalDeviceMemoryProperties(context->physical_device, &context->memory);
    if (auto opened = open_device(*context); !opened) return opened.error();
    return context;
}

Result<std::vector<std::string>> vulkan_device_names() {
    auto instance = create_instance();
    if (!instance) return instance.error();
    auto usable = candidates(*instance);
    vkDestroyInstance(*instance, nullptr);
    if (!usable) return usable.error();
    std::vector<std::string> names;
    for (const Candidate& candidate : *usable) names.emplace_back(candidate.properties.deviceName);
    return names;
}

Result<void> vulkan_submit(VulkanContext& context, const std::function<void(VkCommandBuffer)>& record) {
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                            .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    VkResult result = vkBeginCommandBuffer(context.commands, &begin);
    if (result != VK_SUCCESS) return vulkan_error("begin a command buffer", result);
    record(context.commands);
    result = vkEndCommandBuffer(context.commands);
    if (result != VK_SUCCESS) return vulkan_error("record commands", result);

    const VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &context.commands};
    result = vkQueueSubmit(context.queue, 1, &submit, context.done);
    if (result != VK_SUCCESS) return vulkan_error("submit work to the device", result);
    // No time limit: a hung device is reported by its driver as lost.
    result = vkWaitForFences(context.device, 1, &context.done, VK_TRUE, UINT64_MAX);
    if (result == VK_SUCCESS) result = vkResetFences(context.device, 1, &context.done);
    if (result != VK_SUCCESS) return vulkan_error("wait for the device", result);
    return {};
}

Error vulkan_error(const std::string& action, VkResult result) {
    if (const char* text = result_text(result)) return Error{fmt::format("cannot {}: {}", action, text)};
    return Error{fmt::format("cannot {}: Vulkan error {}", action, static_cast<int>(result))};
}

}  // namespace spinel
