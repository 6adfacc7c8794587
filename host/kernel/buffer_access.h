// The ways in which a kernel can fetch the scene's rows; shaders/fetch.glsl says what they are.
#pragma once

#include <cstdint>
#include <string>

namespace turner {

// `automatic` is what suits the device, by measurement (docs/performance.md).
enum class Fetch { automatic, texels, buffers, addresses };

inline constexpr uint32_t kRowArrays = 6;  // nodes, primitives, vertex normals, materials, lights, cubes
inline constexpr uint32_t kRowBytes = 16;

// "texels", "buffers" or "addresses".
std::string fetchName(Fetch fetch);

// How many bindings a kernel has, and which of them are storage texel buffers; all others are storage buffers. By
// address it has none for rows.
uint32_t bindingCount(Fetch fetch);
bool bindsTexels(uint32_t binding, Fetch fetch);

// What compileGlsl reads before the kernel.
std::string fetchPreamble(Fetch fetch);

}  // namespace turner
