// Whether a device computes what the kernel relies on. A driver can be wrong without an error, and so would the
// picture.
#pragma once

#include <string>
#include <vector>

#include "gpu/vulkan_device.h"
#include "kernel/buffer_access.h"
#include "kernel/shader_sources.h"

namespace turner {

// How a device is to be used.
struct DeviceTrust {
  bool loopsAtHead = false;  // the kernel's loops end at their head (docs/kernel.md, Loops)
  std::string note;          // that says so to the user; else empty
};

// Runs the self-test, for kernels that fetch in this way, or finds that this driver has passed it before. Throws
// RunError saying what the device gets wrong.
DeviceTrust testDevice(const Device& device, BufferAccess access, const std::vector<ShaderSource>& sources);

// The self-test, with its sources in memory.
std::vector<ShaderSource> selfTestSources();

// What the device gets wrong of it, a line for each check, naming what of the kernel relies on it.
std::vector<std::string> runSelfTest(const Device& device, BufferAccess access,
                                     const std::vector<ShaderSource>& sources, bool loopsAtHead);

}  // namespace turner
