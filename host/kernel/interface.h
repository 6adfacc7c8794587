// The host's side of the kernel's interface, as tables: the structures, bindings and specialisation constants of
// shaders/layout.h with their names. Knows neither SPIR-V nor Vulkan.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace turner {

struct HostMember {
  const char* name;
  uint32_t offset;
  const char* type;  // as GLSL spells it
  uint32_t length;   // of an array of rows, else 0
  uint32_t size;     // bytes
};

// "uint" or "uvec4[6]".
std::string glslType(const HostMember& member);

// A structure of the host's; without one a block is all rows.
struct HostBlock {
  const char* name;
  std::span<const HostMember> members;
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
  const char* variable;  // its name in features.glsl
  bool isBoolean;        // else a 32-bit integer
};

// All bindings, in the order of their numbers, and all constants, in the order of their ids.
std::span<const HostBinding> hostBindings();
std::span<const HostConstant> hostConstants();

// The push constants.
HostBlock hostTile();

}  // namespace turner
