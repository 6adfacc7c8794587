// The host's side of the kernel's interface, as tables: shaders/interface.h expanded, with the names of the bindings
// and constants and the members of their blocks. Knows neither SPIR-V nor Vulkan.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "kernel/layout_text.h"

namespace turner {

// "uint" or "uvec4[6]".
std::string glslType(const LayoutMember& member);

// A structure of the host's; without one a block is all words.
struct HostBlock {
  std::string name;
  std::vector<LayoutMember> members;
};

struct HostBinding {
  uint32_t binding;
  const char* constant;  // its name in layout.h
  const char* variable;  // its name in the kernel
  const char* what;
  HostBlock block;
};

struct HostConstant {
  uint32_t id;
  const char* constant;  // its name in layout.h
  const char* variable;  // its name in the kernel
  bool isBoolean;        // else a 32-bit integer
};

// All bindings, in the order of their numbers, and all constants, in the order of their ids.
std::span<const HostBinding> hostBindings();
std::span<const HostConstant> hostConstants();

// The push constants.
HostBlock hostTile();

}  // namespace turner
