// Names of the ways, for people and for the kernel's preprocessor.
#include "kernel/buffer_access.h"

#include "layout.h"

namespace turner {

std::string fetchName(Fetch fetch) {
  switch (fetch) {
    case Fetch::texels:
      return "texels";
    case Fetch::buffers:
      return "buffers";
    case Fetch::addresses:
      return "addresses";
    default:
      return "automatic";
  }
}

std::string fetchPreamble(Fetch fetch) {
  const char* number = fetch == Fetch::texels ? "0" : fetch == Fetch::addresses ? "2" : "1";
  return std::string("#define FETCH ") + number + "\n";
}

uint32_t bindingCount(Fetch fetch) {
  return fetch == Fetch::addresses ? gpu::kBindNodes : gpu::kBindCount;
}

bool bindsTexels(uint32_t binding, Fetch fetch) {
  return fetch == Fetch::texels && binding >= gpu::kBindNodes;
}

}  // namespace turner
