// The ways in which a kernel can read the scene's words; shaders/buffer_access.glsl defines them.
#pragma once

#include <cstdint>
#include <string>

namespace turner {

// `automatic`: the fastest on the device, by measurement (docs/performance.md).
enum class BufferAccess { automatic, texelBuffer, storageBuffer, deviceAddress };

inline constexpr uint32_t kSceneArrays = 6;  // nodes, primitives, vertex normals, materials, lights, light buffers
inline constexpr uint32_t kWordBytes = 16;

// "texels", "buffers" or "addresses".
std::string accessName(BufferAccess access);

// How many bindings a kernel has, and which of them are storage texel buffers; all others are storage buffers. By
// device address it has none for the scene.
uint32_t bindingCount(BufferAccess access);
bool bindsTexels(uint32_t binding, BufferAccess access);

// What compileGlsl reads before the kernel.
std::string accessPreamble(BufferAccess access);

}  // namespace turner
