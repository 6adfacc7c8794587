// Vulkan-Hpp's RAII classes do the work; here are the choices: queue, memory types, limits, waiting.
#include "gpu/vulkan_device.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "base/errors.h"
#include "base/memory_limit.h"
#include "base/reserve.h"
#include "base/stopwatch.h"
#include "base/tell.h"
#include "gpu/instance.h"

namespace turner {
namespace {

// A lost device must not hang the program; no dispatch comes near this.
constexpr uint64_t kFenceTimeout = 120'000'000'000;  // nanoseconds

std::string megabytes(vk::DeviceSize bytes) {
  return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB";
}

}  // namespace

// --- the device -----------------------------------------------------------------------------------------------------

Device::Device(const DeviceInfo& info) : info_(info), instance_(info.instance) {
  std::vector<vk::raii::PhysicalDevice> devices = instance_->physicalDevices();
  if (size_t(info.index) >= devices.size()) throw RunError("the Vulkan device " + info.name + " has gone away");
  physical_.emplace(std::move(devices[size_t(info.index)]));
  const auto properties =
      physical_->getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceMaintenance3Properties,
                                vk::PhysicalDeviceSubgroupProperties>();
  const vk::PhysicalDeviceProperties& own = properties.get<vk::PhysicalDeviceProperties2>().properties;
  limits_ = own.limits;
  identity_ = info.name + '\n' + info.driver + '\n' + std::to_string(own.vendorID) + ' ' +
              std::to_string(own.deviceID) + ' ' + std::to_string(own.driverVersion) + '\n' +
              std::string(own.pipelineCacheUUID.begin(), own.pipelineCacheUUID.end());
  maxAllocation_ = properties.get<vk::PhysicalDeviceMaintenance3Properties>().maxMemoryAllocationSize;
  subgroupSize_ = std::max(1u, properties.get<vk::PhysicalDeviceSubgroupProperties>().subgroupSize);
  queueFamily_ = computeFamily(*physical_).value();
  timestampBits_ = physical_->getQueueFamilyProperties()[queueFamily_].timestampValidBits;
  debugNames_ = instance_->hasDebugNames();

  constexpr auto kTexelRows = vk::FormatFeatureFlagBits::eStorageTexelBuffer;
  const vk::FormatProperties format = physical_->getFormatProperties(vk::Format::eR32G32B32A32Uint);
  texelWords_ =
      (format.bufferFeatures & kTexelRows) == kTexelRows && limits_.maxPerStageDescriptorStorageImages >= kSceneArrays;
  const auto features =
      physical_->getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceBufferDeviceAddressFeatures>();
  addresses_ = features.get<vk::PhysicalDeviceBufferDeviceAddressFeatures>().bufferDeviceAddress;

  // lavapipe 22.3 dies where it gets no memory for a device and its threads; with less than this it does not get as far
  // as a picture.
  requireMemory(size_t(512) << 20);
  const float priority = 1;
  const vk::DeviceQueueCreateInfo queue({}, queueFamily_, 1, &priority);
  const vk::PhysicalDeviceBufferDeviceAddressFeatures addressFeature(addresses_);
  device_.emplace(*physical_, vk::DeviceCreateInfo({}, queue, {}, {}, {}, &addressFeature));
  queue_.emplace(*device_, queueFamily_, 0);
  commandPool_.emplace(*device_, vk::CommandPoolCreateInfo(vk::CommandPoolCreateFlagBits::eTransient, queueFamily_));
  if (timestampBits_ > 0) timestamps_.emplace(*device_, vk::QueryPoolCreateInfo({}, vk::QueryType::eTimestamp, 2));
  name(*queue_, "compute queue");
}

bool Device::canAccess(BufferAccess access) const {
  return access == BufferAccess::texelBuffer ? texelWords_ : access == BufferAccess::deviceAddress ? addresses_ : true;
}

vk::DeviceSize Device::mostBytes(BufferAccess access) const {
  const vk::DeviceSize bound = access == BufferAccess::texelBuffer
                                   ? vk::DeviceSize(limits_.maxTexelBufferElements) * kWordBytes
                               : access == BufferAccess::storageBuffer ? vk::DeviceSize(limits_.maxStorageBufferRange)
                                                                       : maxAllocation_;
  return std::min(bound, maxAllocation_);
}

// --- buffers --------------------------------------------------------------------------------------------------------

Buffer Device::makeBuffer(vk::DeviceSize size, vk::BufferUsageFlags usage, vk::MemoryPropertyFlags required,
                          vk::MemoryPropertyFlags preferred, const std::string& bufferName) const {
  Buffer result;
  result.size = std::max<vk::DeviceSize>(size, 16);  // an empty scene has buffers too
  const std::string what = "the buffer of " + bufferName + " needs " + megabytes(result.size);
  const bool byAddress = bool(usage & vk::BufferUsageFlagBits::eShaderDeviceAddress);
  if ((usage & vk::BufferUsageFlagBits::eStorageBuffer) && !byAddress && result.size > limits_.maxStorageBufferRange)
    throw InputError(what + ", more than the device " + info_.name + " can bind (" +
                     megabytes(limits_.maxStorageBufferRange) + ")");
  const vk::DeviceSize texels = vk::DeviceSize(limits_.maxTexelBufferElements) * kWordBytes;
  if ((usage & vk::BufferUsageFlagBits::eStorageTexelBuffer) && result.size > texels)
    throw InputError(what + ", more than the device " + info_.name + " can fetch as texels (" + megabytes(texels) +
                     "); fetch buffers or addresses instead (--fetch)");
  if (result.size > maxAllocation_)
    throw InputError(what + ", more than the device " + info_.name + " can allocate at once (" +
                     megabytes(maxAllocation_) + ")");

  result.buffer.emplace(*device_, vk::BufferCreateInfo({}, result.size, usage));
  const vk::MemoryRequirements needs = result.buffer->getMemoryRequirements();
  const vk::PhysicalDeviceMemoryProperties memory = physical_->getMemoryProperties();
  std::optional<uint32_t> type;
  for (const vk::MemoryPropertyFlags wanted : {required | preferred, required}) {
    for (uint32_t i = 0; i < memory.memoryTypeCount && !type; ++i)
      if ((needs.memoryTypeBits >> i & 1) && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) type = i;
  }
  if (!type) throw RunError("the device " + info_.name + " has no memory type for the buffer of " + bufferName);
  const vk::MemoryAllocateFlagsInfo addressable(vk::MemoryAllocateFlagBits::eDeviceAddress);
  try {
    result.memory.emplace(*device_, vk::MemoryAllocateInfo(needs.size, *type, byAddress ? &addressable : nullptr));
  } catch (const vk::OutOfDeviceMemoryError&) {
    throw RunError("out of device memory: " + what);
  } catch (const vk::OutOfHostMemoryError&) {
    throw RunError("out of memory: " + what);
  }
  result.buffer->bindMemory(**result.memory, 0);
  constexpr auto kReachable = vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent;
  if ((memory.memoryTypes[*type].propertyFlags & kReachable) == kReachable)
    result.mapped = static_cast<std::byte*>(result.memory->mapMemory(0, VK_WHOLE_SIZE));
  name(*result.buffer, bufferName);
  name(*result.memory, "memory of " + bufferName);
  return result;
}

Buffer Device::storageBuffer(vk::DeviceSize size, const std::string& bufferName) const {
  return makeBuffer(size,
                    vk::BufferUsageFlagBits::eStorageBuffer | vk::BufferUsageFlagBits::eTransferSrc |
                        vk::BufferUsageFlagBits::eTransferDst,
                    {}, vk::MemoryPropertyFlagBits::eDeviceLocal, bufferName);
}

Buffer Device::hostBuffer(vk::DeviceSize size, const std::string& bufferName) const {
  using Usage = vk::BufferUsageFlagBits;
  return makeBuffer(size, Usage::eTransferSrc | Usage::eTransferDst | Usage::eStorageBuffer,
                    vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent,
                    vk::MemoryPropertyFlagBits::eHostCached, bufferName);
}

Buffer Device::upload(std::span<const std::byte> bytes, const std::string& bufferName) const {
  Buffer target = storageBuffer(bytes.size(), bufferName);
  fill(target, bytes, bufferName);
  return target;
}

Buffer Device::uploadWords(std::span<const std::byte> bytes, BufferAccess access, const std::string& bufferName) const {
  using Usage = vk::BufferUsageFlagBits;
  const vk::BufferUsageFlags usage = access == BufferAccess::texelBuffer ? Usage::eStorageTexelBuffer
                                     : access == BufferAccess::deviceAddress
                                         ? Usage::eStorageBuffer | Usage::eShaderDeviceAddress
                                         : vk::BufferUsageFlags(Usage::eStorageBuffer);
  Buffer target =
      makeBuffer(bytes.size(), usage | Usage::eTransferDst, {}, vk::MemoryPropertyFlagBits::eDeviceLocal, bufferName);
  fill(target, bytes, bufferName);
  if (access == BufferAccess::texelBuffer) {
    target.texels.emplace(
        *device_, vk::BufferViewCreateInfo({}, **target.buffer, vk::Format::eR32G32B32A32Uint, 0, VK_WHOLE_SIZE));
    name(*target.texels, bufferName);
  }
  if (access == BufferAccess::deviceAddress) target.address = device_->getBufferAddress({**target.buffer});
  return target;
}

void Device::fill(const Buffer& target, std::span<const std::byte> bytes, const std::string& bufferName) const {
  if (bytes.empty()) return;
  // Memory that the host reaches too needs no copy of its content beside it.
  if (target.mapped) {
    prefault(target.mapped, bytes.size());
    std::memcpy(target.mapped, bytes.data(), bytes.size());
    return;
  }
  constexpr size_t kPiece = 64 << 20;
  const Buffer staging = hostBuffer(std::min(bytes.size(), kPiece), "staging of " + bufferName);
  for (size_t done = 0; done < bytes.size(); done += kPiece) {
    const size_t piece = std::min(kPiece, bytes.size() - done);
    std::memcpy(staging.mapped, bytes.data() + done, piece);
    run([&](vk::raii::CommandBuffer& commands) {
      commands.copyBuffer(**staging.buffer, **target.buffer, vk::BufferCopy(0, done, piece));
    });
  }
}

// --- running --------------------------------------------------------------------------------------------------------

double Device::run(const std::function<void(vk::raii::CommandBuffer&)>& record) const {
  vk::raii::CommandBuffers buffers(*device_, {**commandPool_, vk::CommandBufferLevel::ePrimary, 1});
  vk::raii::CommandBuffer& commands = buffers[0];
  commands.begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
  if (timestamps_) {
    commands.resetQueryPool(**timestamps_, 0, 2);
    commands.writeTimestamp(vk::PipelineStageFlagBits::eTopOfPipe, **timestamps_, 0);
  }
  record(commands);
  if (timestamps_) commands.writeTimestamp(vk::PipelineStageFlagBits::eBottomOfPipe, **timestamps_, 1);
  commands.end();

  const vk::raii::Fence fence(*device_, vk::FenceCreateInfo());
  const Stopwatch watch;
  try {
    queue_->submit(vk::SubmitInfo({}, {}, *commands), *fence);
    if (device_->waitForFences(*fence, true, kFenceTimeout) != vk::Result::eSuccess) {
      // What the device still uses must not be destroyed, and it may never be done: the process ends here.
      tellOnStderr("turner: error: the device {} did not finish a dispatch within {} s\n", info_.name,
                   kFenceTimeout / 1'000'000'000);
      std::_Exit(1);
    }
  } catch (const vk::DeviceLostError&) {
    throw RunError("the device " + info_.name + " was lost during a dispatch");
  }
  const double waited = watch.seconds();
  throwIfInvalid();
  if (!timestamps_) return waited;

  const auto [result, ticks] = timestamps_->getResults<uint64_t>(
      0, 2, 2 * sizeof(uint64_t), sizeof(uint64_t), vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWait);
  if (result != vk::Result::eSuccess) return waited;
  const uint64_t mask = timestampBits_ >= 64 ? ~uint64_t(0) : (uint64_t(1) << timestampBits_) - 1;
  return double((ticks[1] - ticks[0]) & mask) * double(limits_.timestampPeriod) * 1e-9;
}

}  // namespace turner
