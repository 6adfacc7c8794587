// Vulkan held thin: a device with one compute queue, buffers, and running commands to their end.
// Knows nothing of scenes or rays. Included only where kernels are run: vulkan_raii.hpp is slow to compile.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>
#include <vulkan/vulkan_raii.hpp>

#include "gpu/devices.h"
#include "kernel/buffer_access.h"

namespace turner {

// Device-local memory where the device has its own, host-visible where the host reads or writes.
struct Buffer {
  vk::DeviceSize size = 0;
  std::optional<vk::raii::DeviceMemory> memory;  // before the buffer: destroyed after it
  std::optional<vk::raii::Buffer> buffer;
  std::byte* mapped = nullptr;                 // host-visible buffers stay mapped
  std::optional<vk::raii::BufferView> texels;  // of rows, where the kernel fetches texels
  vk::DeviceAddress address = 0;               // where it fetches by address
};

class Device {
 public:
  // `info` comes from chooseDevice. Throws RunError when the device cannot be opened.
  explicit Device(const DeviceInfo& info);

  const DeviceInfo& info() const { return info_; }
  const vk::raii::Device& vulkan() const { return *device_; }
  const vk::PhysicalDeviceLimits& limits() const { return limits_; }
  bool isCpu() const { return info_.type == "CPU"; }
  uint32_t subgroupSize() const { return subgroupSize_; }
  bool canAccess(BufferAccess access) const;
  // Most bytes of an array that kernels can read in this way.
  vk::DeviceSize mostBytes(BufferAccess access) const;
  // Differs wherever another driver, another build of it or another device may compute otherwise.
  const std::string& identity() const { return identity_; }

  // A storage buffer on the device. Throws InputError when it exceeds a limit of the device, RunError when the memory
  // is exhausted; both name the buffer and its size.
  Buffer storageBuffer(vk::DeviceSize size, const std::string& name) const;
  // A storage buffer that host and device both reach, coherent; slow for a device that has memory of its own.
  Buffer hostBuffer(vk::DeviceSize size, const std::string& name) const;
  // A storage buffer with this content, written directly or by way of a staging buffer.
  Buffer upload(std::span<const std::byte> bytes, const std::string& name) const;
  // The same of rows that the kernel fetches in this way.
  Buffer uploadWords(std::span<const std::byte> bytes, BufferAccess access, const std::string& name) const;

  // Records commands, submits them and waits until they are done. Returns the seconds that the device took between the
  // first command and the last, by its timestamps, or by the host's clock where it has none.
  double run(const std::function<void(vk::raii::CommandBuffer&)>& record) const;

  // Gives a Vulkan object a name in debuggers and in the layers' messages.
  template <class Object>
  void name(const Object& object, const std::string& text) const {
    if (!debugNames_) return;
    using Handle = std::remove_cvref_t<decltype(*object)>;
    const auto handle = uint64_t(static_cast<typename Handle::CType>(*object));
    device_->setDebugUtilsObjectNameEXT({Handle::objectType, handle, text.c_str()});
  }

 private:
  Buffer makeBuffer(vk::DeviceSize size, vk::BufferUsageFlags usage, vk::MemoryPropertyFlags required,
                    vk::MemoryPropertyFlags preferred, const std::string& name) const;
  void fill(const Buffer& target, std::span<const std::byte> bytes, const std::string& name) const;

  DeviceInfo info_;
  std::shared_ptr<const Instance> instance_;
  std::optional<vk::raii::PhysicalDevice> physical_;
  vk::PhysicalDeviceLimits limits_;
  std::string identity_;
  vk::DeviceSize maxAllocation_ = 0;
  uint32_t queueFamily_ = 0;
  uint32_t timestampBits_ = 0;
  uint32_t subgroupSize_ = 1;
  bool texelWords_ = false, addresses_ = false;  // what canAccess knows
  bool debugNames_ = false;
  std::optional<vk::raii::Device> device_;
  std::optional<vk::raii::Queue> queue_;
  std::optional<vk::raii::CommandPool> commandPool_;
  std::optional<vk::raii::QueryPool> timestamps_;
};

}  // namespace turner
