// The Vulkan instance and the validation layers. Includes vulkan_raii.hpp, which is slow to compile; devices.h has what
// others need.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>
#include <vulkan/vulkan_raii.hpp>

#include "gpu/devices.h"

namespace turner {

// A Vulkan instance, with the validation layers if the build or TURNER_VALIDATION=1 asks for them. Complaints of the
// layers are kept, and throwIfInvalid() throws them: a program that breaks Vulkan's rules has no result.
class Instance {
 public:
  Instance();  // throws RunError when there is no Vulkan loader
  const vk::raii::Instance& vulkan() const { return *instance_; }
  std::vector<vk::raii::PhysicalDevice> physicalDevices() const;
  bool hasDebugNames() const { return debugNames_; }

 private:
  vk::raii::Context context_;
  std::optional<vk::raii::Instance> instance_;
  std::optional<vk::raii::DebugUtilsMessengerEXT> messenger_;
  bool debugNames_ = false;
};

// A queue family for compute; one that does nothing else where there is a choice.
std::optional<uint32_t> computeFamily(const vk::raii::PhysicalDevice& device);

}  // namespace turner
