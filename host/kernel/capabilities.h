// Capabilities of SPIR-V (spv::Capability): which of them turner's device is opened with, and what users call them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kernel/buffer_access.h"

namespace turner {

// Whether every Vulkan 1.2 device takes it without a feature having been asked for; operations of subgroups are
// properties of the device, not features.
bool isOpenCapability(uint32_t capability, BufferAccess access);

// The specification's name: "Float64"; "capability 9999" where SPIRV-Tools know none.
std::string capabilityName(uint32_t capability);

// Words of GLSL that need the capability of this name, to find the place.
std::vector<std::string> glslWordsOfCapability(const std::string& name);

}  // namespace turner
