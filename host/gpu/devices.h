// The Vulkan devices of this machine, as the user sees and names them.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace turner {

class Instance;

struct DeviceInfo {
  int index = 0;                             // in the order of the Vulkan loader; what --device takes
  std::string name;                          // "llvmpipe (LLVM 15.0.6, 256 bits)"
  std::string type;                          // "discrete GPU", "integrated GPU", "virtual GPU", "CPU" or "other"
  std::string driver;                        // name and version as the driver gives them
  std::string api;                           // Vulkan version, "1.3.230"
  bool usable = true;                        // has Vulkan 1.2 and a compute queue
  std::shared_ptr<const Instance> instance;  // that listed it; to make another one takes 60 ms
};

// Throws RunError, saying what to install, when there is no Vulkan loader or no device at all.
std::vector<DeviceInfo> listDevices();

// The device that `wanted` names, by its index or by a part of its name (case ignored); if empty, the best one:
// discrete GPU, integrated, virtual, CPU. Throws InputError listing the devices when none or more than one fits,
// RunError when none is usable.
DeviceInfo chooseDevice(const std::vector<DeviceInfo>& devices, const std::string& wanted);

// Throws RunError with what the validation layers have complained about since the last call, if anything.
void throwIfInvalid();

}  // namespace turner
