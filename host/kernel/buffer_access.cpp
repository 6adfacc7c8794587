// Names of the accesses, for users and for the kernel's preprocessor.
#include "kernel/buffer_access.h"

#include "layout.h"

namespace turner {

std::string accessName(BufferAccess access) {
  switch (access) {
    case BufferAccess::texelBuffer:
      return "texels";
    case BufferAccess::storageBuffer:
      return "buffers";
    case BufferAccess::deviceAddress:
      return "addresses";
    default:
      return "automatic";
  }
}

std::string accessPreamble(BufferAccess access) {
  const char* number = access == BufferAccess::texelBuffer ? "0" : access == BufferAccess::deviceAddress ? "2" : "1";
  return std::string("#define BUFFER_ACCESS ") + number + "\n";
}

uint32_t bindingCount(BufferAccess access) {
  return access == BufferAccess::deviceAddress ? gpu::kBindNodes : gpu::kBindCount;
}

bool bindsTexels(uint32_t binding, BufferAccess access) {
  return access == BufferAccess::texelBuffer && binding >= gpu::kBindNodes;
}

}  // namespace turner
