#pragma once
// A small host for compute on a Vulkan device: buffers that shaders reach by address, pipelines from SPIR-V,
// dispatches with push constants, read-back. There are no descriptor sets: a shader gets every buffer as a
// 64-bit address in its push constants (buffer_reference in GLSL), which is how a kernel's SceneView reaches
// the device.
//
//     auto device   = VulkanDevice::create();
//     auto numbers  = device->create_buffer<float>(values);                      // device memory, filled
//     auto pipeline = device->create_pipeline(spirv_words, sizeof(PushConstants));
//     device->run(*pipeline, PushConstants{numbers->address()}, {group_count, 1, 1});
//     auto results  = device->read<float>(*numbers);
//
// One thread at a time may use a device and what it made. Every call returns when the work is done.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <glm/vec3.hpp>

#include "core/result.h"

namespace spinel {

struct VulkanContext;

struct VulkanDeviceOptions {
    std::string name;           // part of the device's name; empty: the fastest kind of device
    bool always_stage = false;  // copy through staging memory even where device memory is mapped, as on a discrete GPU
};

// Memory of the device. Move-only; freed with the object.
class VulkanBuffer {
  public:
    VulkanBuffer(VulkanBuffer&&) noexcept;
    VulkanBuffer& operator=(VulkanBuffer&&) noexcept;
    ~VulkanBuffer();
    uint64_t address() const;  // what a shader's buffer_reference holds
    uint64_t size() const;     // bytes, as asked for

  private:
    friend class VulkanDevice;
    struct State;
    explicit VulkanBuffer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

// A compute shader, entry point `main`.
class VulkanPipeline {
  public:
    VulkanPipeline(VulkanPipeline&&) noexcept;
    VulkanPipeline& operator=(VulkanPipeline&&) noexcept;
    ~VulkanPipeline();

  private:
    friend class VulkanDevice;
    struct State;
    explicit VulkanPipeline(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

struct VulkanDispatch {
    const VulkanPipeline* pipeline = nullptr;
    std::span<const std::byte> push_constants;  // exactly as many bytes as the pipeline declares
    glm::uvec3 group_count = {1, 1, 1};         // work groups, not invocations
};

class VulkanDevice {
  public:
    static Result<VulkanDevice> create(const VulkanDeviceOptions& options = {});
    static Result<std::vector<std::string>> available();  // device names, best first

    const std::string& name() const { return name_; }

    Result<VulkanBuffer> create_buffer(uint64_t size);
    Result<void> upload(const VulkanBuffer& buffer, std::span<const std::byte> bytes, uint64_t offset = 0);
    Result<void> download(const VulkanBuffer& buffer, std::span<std::byte> bytes, uint64_t offset = 0);

    // `constants` are the values of the shader's specialisation constants 0, 1, …: known to the compiler, so that what
    // they switch off costs nothing, not even the time to compile it.
    Result<VulkanPipeline> create_pipeline(std::span<const uint32_t> spirv, uint32_t push_constant_size,
                                           std::span<const uint32_t> constants = {});

    // Runs dispatches in order; each sees what the earlier ones wrote.
    Result<void> run(std::span<const VulkanDispatch> dispatches);

    template <class T>
    Result<VulkanBuffer> create_buffer(std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        auto buffer = create_buffer(values.size_bytes());
        if (!buffer) return buffer.error();
        if (auto done = upload(*buffer, std::as_bytes(values)); !done) return done.error();
        return buffer;
    }

    // The whole buffer as an array of T.
    template <class T>
    Result<std::vector<T>> read(const VulkanBuffer& buffer) {
        static_assert(std::is_trivially_copyable_v<T>);
        std::vector<T> values(buffer.size() / sizeof(T));
        if (auto done = download(buffer, std::as_writable_bytes(std::span(values))); !done) return done.error();
        return values;
    }

    template <class PushConstants>
    Result<void> run(const VulkanPipeline& pipeline, const PushConstants& push_constants, glm::uvec3 group_count) {
        static_assert(std::is_trivially_copyable_v<PushConstants>);
        const VulkanDispatch dispatch{&pipeline, std::as_bytes(std::span(&push_constants, 1)), group_count};
        return run(std::span(&dispatch, 1));
    }

  private:
    VulkanDevice(std::shared_ptr<VulkanContext> context, bool always_stage);
    Result<VulkanBuffer> create_staging(uint64_t size);

    std::shared_ptr<VulkanContext> context_;
    std::string name_;
    bool always_stage_ = false;
};

}  // namespace spinel
