#include "devices/vulkan/vulkan_device.h"

#include <fmt/format.h>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstring>
#include <optional>

#include "devices/vulkan/vulkan_context.h"

namespace spinel {
namespace {

constexpr uint64_t staging_size = 64ull << 20;  // bytes per copy where device memory is not mapped
constexpr VkMemoryPropertyFlags mapped_memory =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

// The first memory type that the buffer may live in and that has all the wanted properties.
std::optional<uint32_t> find_memory_type(const VulkanContext& context, uint32_t allowed, VkMemoryPropertyFlags wanted) {
    for (uint32_t i = 0; i < context.memory.memoryTypeCount; ++i)
        if ((allowed >> i & 1u) && (context.memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    return std::nullopt;
}

void memory_barrier(VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
                    VkAccessFlags read) {
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER, .srcAccessMask = written, .dstAccessMask = read};
    vkCmdPipelineBarrier(commands, from, to, 0, 1, &barrier, 0, nullptr, 0, nullptr);
}

}  // namespace

struct VulkanBuffer::State {
    explicit State(std::shared_ptr<VulkanContext> owner) : context(std::move(owner)) {}
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        vkDestroyBuffer(context->device, buffer, nullptr);
        vkFreeMemory(context->device, memory, nullptr);  // unmaps as well
    }

    // Creates the buffer in the best memory type among `wanted`, the first that the device has.
    Result<void> allocate(uint64_t bytes, VkBufferUsageFlags usage, std::span<const VkMemoryPropertyFlags> wanted) {
        size = bytes;
        const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                         .size = std::max<uint64_t>(bytes, 16),  // Vulkan knows no empty buffer
                                         .usage = usage,
                                         .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
        VkResult result = vkCreateBuffer(context->device, &info, nullptr, &buffer);
        if (result != VK_SUCCESS) return vulkan_error(fmt::format("create a buffer of {} bytes", bytes), result);

        VkMemoryRequirements requirements;
        vkGetBufferMemoryRequirements(context->device, buffer, &requirements);
        std::optional<uint32_t> type;
        for (VkMemoryPropertyFlags flags : wanted)
            if (!type) type = find_memory_type(*context, requirements.memoryTypeBits, flags);
        if (!type) return Error{"the Vulkan device has no suitable memory for a buffer"};

        const bool addressed = usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
        const VkMemoryAllocateFlagsInfo flags = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                                 .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
        const VkMemoryAllocateInfo allocation = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                                 .pNext = addressed ? &flags : nullptr,
                                                 .allocationSize = requirements.size,
                                                 .memoryTypeIndex = *type};
        result = vkAllocateMemory(context->device, &allocation, nullptr, &memory);
        if (result == VK_SUCCESS) result = vkBindBufferMemory(context->device, buffer, memory, 0);
        if (result == VK_SUCCESS && (context->memory.memoryTypes[*type].propertyFlags & mapped_memory) == mapped_memory)
            result = vkMapMemory(context->device, memory, 0, VK_WHOLE_SIZE, 0, &mapped);
        if (result != VK_SUCCESS) return vulkan_error(fmt::format("allocate {} bytes", bytes), result);

        if (addressed) {
            const VkBufferDeviceAddressInfo query = {.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                                     .buffer = buffer};
            address = vkGetBufferDeviceAddress(context->device, &query);
        }
        return {};
    }

    std::shared_ptr<VulkanContext> context;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    void* mapped = nullptr;  // null where the host does not see the memory
    uint64_t address = 0;
    uint64_t size = 0;
};

VulkanBuffer::VulkanBuffer(std::unique_ptr<State> state) : state_(std::move(state)) {}
VulkanBuffer::VulkanBuffer(VulkanBuffer&&) noexcept = default;
VulkanBuffer& VulkanBuffer::operator=(VulkanBuffer&&) noexcept = default;
VulkanBuffer::~VulkanBuffer() = default;
uint64_t VulkanBuffer::address() const { return state_->address; }
uint64_t VulkanBuffer::size() const { return state_->size; }

struct VulkanPipeline::State {
    explicit State(std::shared_ptr<VulkanContext> owner) : context(std::move(owner)) {}
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        vkDestroyPipeline(context->device, pipeline, nullptr);
        vkDestroyPipelineLayout(context->device, layout, nullptr);
    }

    std::shared_ptr<VulkanContext> context;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
    uint32_t push_constant_size = 0;
};

VulkanPipeline::VulkanPipeline(std::unique_ptr<State> state) : state_(std::move(state)) {}
VulkanPipeline::VulkanPipeline(VulkanPipeline&&) noexcept = default;
VulkanPipeline& VulkanPipeline::operator=(VulkanPipeline&&) noexcept = default;
VulkanPipeline::~VulkanPipeline() = default;

VulkanDevice::VulkanDevice(std::shared_ptr<VulkanContext> context, bool always_stage)
    : context_(std::move(context)), name_(context_->properties.deviceName), always_stage_(always_stage) {}

Result<VulkanDevice> VulkanDevice::create(const VulkanDeviceOptions& options) {
    auto context = create_vulkan_context(options.name);
    if (!context) return context.error();
    return VulkanDevice(*context, options.always_stage);
}

Result<std::vector<std::string>> VulkanDevice::available() { return vulkan_device_names(); }

Result<VulkanBuffer> VulkanDevice::create_buffer(uint64_t size) {
    constexpr VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                         VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                                         VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    // Local to the device first; mapped as well where that costs nothing (integrated, CPU, resizable BAR).
    constexpr VkMemoryPropertyFlags wanted[] = {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | mapped_memory,
                                                VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT};
    auto state = std::make_unique<VulkanBuffer::State>(context_);
    if (auto done = state->allocate(size, usage, wanted); !done) return done.error();
    return VulkanBuffer(std::move(state));
}

Result<VulkanBuffer> VulkanDevice::create_staging(uint64_t size) {
    constexpr VkMemoryPropertyFlags wanted[] = {mapped_memory | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, mapped_memory};
    auto state = std::make_unique<VulkanBuffer::State>(context_);
    if (auto done = state->allocate(size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, wanted);
        !done)
        return done.error();
    return VulkanBuffer(std::move(state));
}

Result<void> VulkanDevice::upload(const VulkanBuffer& buffer, std::span<const std::byte> bytes, uint64_t offset) {
    assert(offset + bytes.size() <= buffer.size());
    if (bytes.empty()) return {};
    const VulkanBuffer::State& target = *buffer.state_;
    if (target.mapped && !always_stage_) {
        std::memcpy(static_cast<std::byte*>(target.mapped) + offset, bytes.data(), bytes.size());
        return {};
    }
    auto staging = create_staging(std::min<uint64_t>(bytes.size(), staging_size));
    if (!staging) return staging.error();
    const VulkanBuffer::State& source = *staging->state_;
    for (uint64_t begin = 0; begin < bytes.size(); begin += staging_size) {
        const uint64_t count = std::min<uint64_t>(bytes.size() - begin, staging_size);
        std::memcpy(source.mapped, bytes.data() + begin, count);
        auto done = vulkan_submit(*context_, [&](VkCommandBuffer commands) {
            const VkBufferCopy region = {.srcOffset = 0, .dstOffset = offset + begin, .size = count};
            vkCmdCopyBuffer(commands, source.buffer, target.buffer, 1, &region);
            memory_barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                           VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                           VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT);
        });
        if (!done) return done;
    }
    return {};
}

Result<void> VulkanDevice::download(const VulkanBuffer& buffer, std::span<std::byte> bytes, uint64_t offset) {
    assert(offset + bytes.size() <= buffer.size());
    if (bytes.empty()) return {};
    const VulkanBuffer::State& source = *buffer.state_;
    if (source.mapped && !always_stage_) {
        std::memcpy(bytes.data(), static_cast<const std::byte*>(source.mapped) + offset, bytes.size());
        return {};
    }
    auto staging = create_staging(std::min<uint64_t>(bytes.size(), staging_size));
    if (!staging) return staging.error();
    const VulkanBuffer::State& target = *staging->state_;
    for (uint64_t begin = 0; begin < bytes.size(); begin += staging_size) {
        const uint64_t count = std::min<uint64_t>(bytes.size() - begin, staging_size);
        auto done = vulkan_submit(*context_, [&](VkCommandBuffer commands) {
            const VkBufferCopy region = {.srcOffset = offset + begin, .dstOffset = 0, .size = count};
            vkCmdCopyBuffer(commands, source.buffer, target.buffer, 1, &region);
            memory_barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                           VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
        });
        if (!done) return done;
        std::memcpy(bytes.data() + begin, target.mapped, count);
    }
    return {};
}

Result<VulkanPipeline> VulkanDevice::create_pipeline(std::span<const uint32_t> spirv, uint32_t push_constant_size,
                                                     std::span<const uint32_t> constants) {
    if (const uint32_t limit = context_->properties.limits.maxPushConstantsSize; push_constant_size > limit)
        return Error{
            fmt::format("'{}' takes at most {} bytes of push constants, not {}", name_, limit, push_constant_size)};
    if (push_constant_size % 4 != 0)
        return Error{fmt::format("push constants must fill whole 4-byte words, not {} bytes", push_constant_size)};
    if (spirv.empty() || spirv.front() != 0x07230203u) return Error{"a compute shader is not a SPIR-V module"};

    auto state = std::make_unique<VulkanPipeline::State>(context_);
    state->push_constant_size = push_constant_size;
    const VkPushConstantRange range = {
        .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT, .offset = 0, .size = push_constant_size};
    const VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .pushConstantRangeCount = push_constant_size > 0 ? 1u : 0u,
                                               .pPushConstantRanges = &range};
    VkResult result = vkCreatePipelineLayout(context_->device, &layout, nullptr, &state->layout);
    if (result != VK_SUCCESS) return vulkan_error("create a pipeline layout", result);

    const VkShaderModuleCreateInfo module_info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = spirv.size_bytes(), .pCode = spirv.data()};
    VkShaderModule module = VK_NULL_HANDLE;
    result = vkCreateShaderModule(context_->device, &module_info, nullptr, &module);
    if (result != VK_SUCCESS) return vulkan_error("load a shader", result);
    std::vector<VkSpecializationMapEntry> entries;
    for (uint32_t i = 0; i < constants.size(); ++i)
        entries.push_back({.constantID = i, .offset = 4 * i, .size = sizeof(uint32_t)});
    const VkSpecializationInfo specialization = {.mapEntryCount = uint32_t(entries.size()),
                                                 .pMapEntries = entries.data(),
                                                 .dataSize = constants.size_bytes(),
                                                 .pData = constants.data()};
    const VkComputePipelineCreateInfo pipeline = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main",
                  .pSpecializationInfo = &specialization},
        .layout = state->layout};
    result = vkCreateComputePipelines(context_->device, VK_NULL_HANDLE, 1, &pipeline, nullptr, &state->pipeline);
    vkDestroyShaderModule(context_->device, module, nullptr);
    if (result != VK_SUCCESS) return vulkan_error("create a compute pipeline", result);
    return VulkanPipeline(std::move(state));
}

Result<void> VulkanDevice::run(std::span<const VulkanDispatch> dispatches) {
    const auto& limits = context_->properties.limits;
    for (const VulkanDispatch& dispatch : dispatches) {
        assert(dispatch.push_constants.size() == dispatch.pipeline->state_->push_constant_size);
        for (int axis = 0; axis < 3; ++axis)
            if (dispatch.group_count[axis] > limits.maxComputeWorkGroupCount[axis])
                return Error{fmt::format("'{}' runs at most {} work groups along axis {}, not {}", name_,
                                         limits.maxComputeWorkGroupCount[axis], axis, dispatch.group_count[axis])};
    }
    return vulkan_submit(*context_, [&](VkCommandBuffer commands) {
        for (const VulkanDispatch& dispatch : dispatches) {
            const VulkanPipeline::State& state = *dispatch.pipeline->state_;
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, state.pipeline);
            if (state.push_constant_size > 0)
                vkCmdPushConstants(commands, state.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, state.push_constant_size,
                                   dispatch.push_constants.data());
            vkCmdDispatch(commands, dispatch.group_count.x, dispatch.group_count.y, dispatch.group_count.z);
            // What follows may be another dispatch, a copy or a read by the host.
            memory_barrier(
                commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
                VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_HOST_BIT,
                VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                    VK_ACCESS_HOST_READ_BIT);
        }
    });
}

}  // namespace spinel
